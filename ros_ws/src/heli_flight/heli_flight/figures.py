"""What a report shows of a flight, as plain curves: drawn interactively or as pictures by others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import degrees

import numpy as np

from heli_common.flight_state import FlightState
from heli_flight.flight_record import Array, FlightRecord, Stamps, seconds
from heli_flight.flight_statistics import SERVO_LIMITS, VOLTAGE_LIMITS

TRUTH, ESTIMATE, REFERENCE, COMMAND, LIMIT = "truth", "estimate", "reference", "command", "limit"

_RADIAN = degrees(1.0)


@dataclass(frozen=True)
class Curve:
    """One line in a panel.

    Attributes:
        label: in the legend.
        role: truth, estimate, reference, command or limit; decides colour and dash.
        x, y: shape (n,).
        flight: number of the flight in a comparison, from 0.
    """

    label: str
    role: str
    x: Array
    y: Array
    flight: int = 0


@dataclass(frozen=True)
class Panel:
    """One pair of axes; `limits` are drawn as lines across it."""

    label: str
    unit: str
    curves: tuple[Curve, ...]
    limits: tuple[float, ...] = ()


@dataclass(frozen=True)
class Band:
    """A stage of the flight behind the curves [s]."""

    label: str
    start: float
    end: float


@dataclass(frozen=True)
class Figure:
    """Panels above each other with one time axis.

    Attributes:
        key: part of file names and links.
        title, caption: for people.
        panels: from top to bottom.
        bands: stages of the flight.
    """

    key: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    bands: tuple[Band, ...] = ()


def flight_figure(key: str, records: Sequence[FlightRecord], names: Sequence[str]) -> Figure:
    """One figure of one flight, or of several laid over each other; without data it has no curves.

    Args:
        key: `position`, `attitude`, `velocity`, `commands` or `rotor`.
        records: flights, at least one.
        names: one for each flight.

    Raises:
        KeyError: no such figure.
    """
    builders = {
        "position": _position,
        "attitude": _attitude,
        "velocity": _velocity,
        "commands": _commands,
        "rotor": _rotor,
    }
    return builders[key](records, names)


Columns = Callable[[FlightRecord], tuple[Stamps, Array]]


def _curve(
    record: FlightRecord, source: Columns, column: int, factor: float, label: str, role: str, flight: int = 0
) -> list[Curve]:
    stamps, values = source(record)
    if not len(stamps):
        return []
    return [Curve(label, role, seconds(stamps), values[:, column] * factor, flight)]


def _overlaid(
    records: Sequence[FlightRecord],
    names: Sequence[str],
    column: int,
    factor: float,
    *,
    truth: Columns | None,
    estimate: Columns | None = None,
    reference: Columns | None = None,
    command: Columns | None = None,
) -> tuple[Curve, ...]:
    """The curves of one panel: all that is known of a single flight, one line for each of several."""
    curves: list[Curve] = []
    if len(records) == 1:
        for source, label in ((estimate, ESTIMATE), (command, COMMAND), (truth, TRUTH)):
            if source is not None:
                curves += _curve(records[0], source, column, factor, label, label)
    elif (shown := truth or command) is not None:
        for flight, (record, name) in enumerate(zip(records, names, strict=True)):
            curves += _curve(record, shown, column, factor, name, TRUTH, flight)
    if reference is not None:
        curves += _curve(records[0], reference, column, factor, REFERENCE, REFERENCE)
    return tuple(curves)


def bands(records: Sequence[FlightRecord]) -> tuple[Band, ...]:
    """Stages of the first flight; in a comparison they would not fit all."""
    return tuple(
        Band(stage.state.word, stage.start_ns * 1e-9, stage.end_ns * 1e-9)
        for stage in records[0].stages
        if stage.state not in (FlightState.IDLE, FlightState.STOPPED)
    )


def _position(records: Sequence[FlightRecord], names: Sequence[str]) -> Figure:
    panels = tuple(
        Panel(
            label,
            "m",
            _overlaid(
                records,
                names,
                column,
                sign,
                truth=lambda record: (record.truth.stamps, record.truth.position),
                estimate=lambda record: _known(record, record.estimate.position),
                reference=lambda record: record.reference,
            ),
        )
        for label, column, sign in (("x north", 0, 1.0), ("y east", 1, 1.0), ("height", 2, -1.0))
    )
    caption = "Of the centre of gravity, from the centre of the flight space."
    return Figure("position", "Position", caption, panels, bands(records))


def _attitude(records: Sequence[FlightRecord], names: Sequence[str]) -> Figure:
    panels = tuple(
        Panel(
            label,
            "deg",
            _overlaid(
                records,
                names,
                column,
                _RADIAN,
                truth=lambda record: (record.truth.stamps, record.truth.attitude),
                estimate=lambda record: _known(record, record.estimate.attitude),
                reference=(lambda record: _yaw(record.reference)) if column == 0 else None,
            ),
        )
        for label, column in (("pitch θ", 1), ("roll φ", 2), ("yaw ψ", 0))
    )
    return Figure(
        "attitude", "Attitude", "Euler angles yaw, pitch, roll of the body.", panels, bands(records)
    )


def _known(record: FlightRecord, values: Array) -> tuple[Stamps, Array]:
    """An estimated pose with a gap where it is unknown, because the encoders are not indexed yet."""
    return record.estimate.stamps, np.where(record.estimate.known[:, None], values, np.nan)


def _yaw(reference: tuple[Stamps, Array]) -> tuple[Stamps, Array]:
    return reference[0], reference[1][:, 3:]


def _velocity(records: Sequence[FlightRecord], names: Sequence[str]) -> Figure:
    alone = len(records) == 1  # the reference comes from the position controller: every flight has its own
    panels = [
        Panel(
            label,
            "m/s",
            _overlaid(
                records,
                names,
                column,
                1.0,
                truth=lambda record: (record.truth.stamps, record.truth.velocity),
                estimate=lambda record: (record.estimate.stamps, record.estimate.velocity),
                reference=(lambda record: record.velocity_reference) if alone else None,
            ),
        )
        for label, column in (("u ahead", 0), ("v right", 1), ("w down", 2))
    ]
    rate = _overlaid(
        records,
        names,
        0,
        _RADIAN,
        truth=lambda record: (record.truth.stamps, record.truth.rates[:, 2:]),
        estimate=lambda record: (record.estimate.stamps, record.estimate.rates[:, 2:]),
        reference=(lambda record: _yaw(record.velocity_reference)) if alone else None,
    )
    caption = "Of the body, in body axes; the reference of the position controller in heading axes."
    panels.append(Panel("yaw rate r", "deg/s", rate))
    return Figure("velocity", "Velocity", caption, tuple(panels), bands(records))


def _commands(records: Sequence[FlightRecord], names: Sequence[str]) -> Figure:
    labels = ("B₁ₛ longitudinal", "A₁ₛ lateral", "θ₀ collective", "θₜ tail")
    panels = tuple(
        Panel(
            label,
            "deg",
            _overlaid(
                records,
                names,
                column,
                _RADIAN,
                truth=lambda record: record.actuator_state,
                command=lambda record: record.servo_command,
            ),
            tuple(_RADIAN * limit for limit in SERVO_LIMITS[column]),
        )
        for column, label in enumerate(labels)
    )
    caption = "Blade angles: commanded, and as the servos set them (truth); lines: the servos' full travel."
    return Figure("commands", "Commands", caption, panels, bands(records))


def _rotor(records: Sequence[FlightRecord], names: Sequence[str]) -> Figure:
    def column(pair: tuple[Stamps, Array]) -> tuple[Stamps, Array]:
        return pair[0], pair[1][:, None]

    speed = _overlaid(
        records,
        names,
        0,
        30.0 / np.pi,
        truth=lambda record: column(record.rotor_speed),
        reference=lambda record: column(record.rotor_reference),
    )
    voltage = _overlaid(
        records, names, 0, 1.0, truth=None, command=lambda record: column(record.motor_voltage)
    )
    panels = (
        Panel("rotor speed", "rpm", speed),
        Panel("motor control voltage", "V", voltage, VOLTAGE_LIMITS),
    )
    caption = "Measured rotor speed, and what the motor controller asks of the supply."
    return Figure("rotor", "Rotor and motor", caption, panels, bands(records))
