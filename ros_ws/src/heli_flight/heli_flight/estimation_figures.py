"""Estimated less true motion over time, within the band that the navigation claims."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

import numpy as np

from heli_flight.decimation import thinned
from heli_flight.estimation_error import EstimationError, estimation_errors
from heli_flight.flight_record import FlightRecord, seconds
from heli_flight.graphs import GREY, Curve, Graph, Kind, Plot

_SHOWN = {
    "m": ("mm", 1e3),
    "rad": ("deg", degrees(1.0)),
    "m_s": ("cm/s", 1e2),
    "rad_s": ("deg/s", degrees(1.0)),
}
"""Unit and factor from SI."""

NAMES = {"theta": "pitch θ", "phi": "roll φ", "psi": "yaw ψ"}
_MOST, _EDGE = 3000, 600
"""Points of an error, and of the edge of its band."""


def estimation_graph(records: Sequence[FlightRecord], names: Sequence[str]) -> Graph | None:
    """Errors of position, attitude, velocity and rates; None if either side is missing.

    Args:
        records: flights, at least one.
        names: one for each flight.
    """
    found = [estimation_errors(record) for record in records]
    if not any(found):
        return None
    quantities = [(error.name, error.unit) for error in next(filter(None, found))]
    plots = []
    for index, (quantity, unit) in enumerate(quantities):
        shown, factor = _SHOWN[unit]
        curves: list[Curve] = []
        size = 0.0
        for flight, (errors, name) in enumerate(zip(found, names, strict=True)):
            if errors:
                label = name if len(records) > 1 else "estimated − true"
                curves += _curves(errors[index], label, flight, factor, len(records) == 1)
                size = max(size, _size(errors[index], factor))
        title = NAMES.get(quantity, quantity)
        plots.append(Plot(title, "time [s]", f"[{shown}]", tuple(curves), y_range=(-size, size)))
    rows = tuple(tuple(plots[start : start + 3]) for start in range(0, len(plots), 3))
    caption = (
        "Estimated less true, from the moment the pose is known; band: twice the standard deviation that the "
        "navigation claims. Position north, east, down; velocity and rates in the body."
    )
    return Graph("estimation", "Estimated against true", caption, rows, row_height=170, timed=True)


def _curves(error: EstimationError, label: str, flight: int, factor: float, alone: bool) -> list[Curve]:
    time = seconds(error.stamps)
    curves = []
    if alone:
        every = max(1, len(time) // _EDGE)
        edge = 2.0 * factor * error.sigma[::every]
        curves.append(Curve("± 2 σ claimed", time[::every], -edge, GREY, Kind.BAND, upper=edge))
    curves.append(Curve(label, *thinned(time, factor * error.values, _MOST), flight))
    return curves


def _size(error: EstimationError, factor: float) -> float:
    """Half the height of the plot: nearly all errors and nearly all of the band."""
    largest = max(np.quantile(np.abs(error.values), 0.9995), 2.0 * np.quantile(error.sigma, 0.98), 1e-9)
    return 1.15 * factor * float(largest)
