"""What a report shows of the IMU and of the air, as plain curves."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

import numpy as np

from heli_flight.figures import ESTIMATE, REFERENCE, TRUTH, Curve, Figure, Panel, bands
from heli_flight.flight_record import Array, FlightRecord, Series, attitude_ned, seconds

_DEGREE = degrees(1.0)
_AXES = ("x", "y", "z")


def imu_figure(records: Sequence[FlightRecord], names: Sequence[str]) -> Figure:
    """Biases of the gyros, estimated and true, and the attitude by the IMU alone less the true one.

    Args:
        records: flights, at least one.
        names: one for each flight.
    """
    panels = []
    for axis in _AXES:
        curves: list[Curve] = []
        for flight, (record, name) in enumerate(zip(records, names, strict=True)):
            for topic, role in (("bench_condition", TRUTH), ("imu_bias", ESTIMATE)):
                label = role if len(records) == 1 else f"{name}: {role}"
                curves += _curve(record.series[topic], f"position.gyro_{axis}", _DEGREE, label, role, flight)
        panels.append(Panel(f"gyro bias {axis}", "deg/s", tuple(curves)))
    for column, label in enumerate(("yaw", "pitch", "roll")):
        curves = []
        for flight, record in enumerate(records):
            curves += _attitude_error(record, column, names[flight], flight, len(records) == 1)
        panels.append(Panel(f"{label} error", "deg", tuple(curves)))
    caption = (
        "Biases of the gyros (FLU): true, and as the navigation estimates them. Below: attitude by the IMU "
        "alone less the true one, with twice its own deviation; of yaw gravity says nothing."
    )
    return Figure("imu", "IMU", caption, tuple(panels), bands(records))


def air_figure(records: Sequence[FlightRecord], names: Sequence[str]) -> Figure:
    """True velocity of the air at the helicopter, and the room's yaw moment; empty if the air stood still.

    Args:
        records: flights, at least one.
        names: one for each flight.
    """
    panels = []
    for field, label in (("vector.y", "wind north"), ("vector.x", "wind east"), ("vector.z", "wind up")):
        panels.append(Panel(label, "m/s", _blown(records, names, "wind", field)))
    moment = _blown(records, names, "bench_condition", "position.gust_yaw")
    panels.append(Panel("yaw moment", "N m", moment))
    caption = "Velocity of the air at the helicopter as it was, gusts and turbulence included."
    return Figure("air", "Air", caption, tuple(panels), bands(records))


def _blown(
    records: Sequence[FlightRecord], names: Sequence[str], topic: str, field: str
) -> tuple[Curve, ...]:
    curves: list[Curve] = []
    for flight, (record, name) in enumerate(zip(records, names, strict=True)):
        if _air_moves(record):
            label = TRUTH if len(records) == 1 else name
            curves += _curve(record.series[topic], field, 1.0, label, TRUTH, flight)
    return tuple(curves)


def _air_moves(record: FlightRecord) -> bool:
    return bool(np.any(record.series["wind"].values != 0.0))


def _curve(series: Series, field: str, factor: float, label: str, role: str, flight: int) -> list[Curve]:
    if not len(series.stamps):
        return []
    return [Curve(label, role, seconds(series.stamps), factor * series.column(field), flight)]


def _attitude_error(record: FlightRecord, column: int, name: str, flight: int, alone: bool) -> list[Curve]:
    """Error of one angle from the moment it is known, and twice its deviation to either side."""
    series, truth = record.series["imu_attitude"], record.truth
    rows = min(len(series.stamps), len(truth.stamps))
    # rotations about the axes east, north, up: near level and north they are pitch, roll and yaw
    variance = series.column(f"orientation_covariance[{(8, 0, 4)[column]}]")[:rows]
    known = variance < 1.0
    if not known.any():
        return []
    seen = attitude_ned(series.values[:rows, 0:4])[known, column]
    error: Array = np.angle(np.exp(1j * (seen - truth.attitude[:rows][known, column])))
    time = seconds(series.stamps[:rows][known])
    curves = [Curve("error" if alone else name, ESTIMATE, time, _DEGREE * error, flight)]
    if alone:
        wide = 2.0 * _DEGREE * np.sqrt(variance[known])
        curves += [Curve("2 sigma", REFERENCE, time, wide), Curve("-2 sigma", REFERENCE, time, -wide)]
    return curves
