"""Where the helicopter was while it hovered: the deviation from the reference in three planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from heli_flight.flight_record import Array, FlightRecord
from heli_flight.graphs import GREY, Curve, Graph, Kind, Plot
from heli_flight.metrics import hover_start, reference_legs

MOST_DOTS = 2500
"""Of one flight in one plane."""

_QUANTILE_95 = 2.4477
"""Radius of the circle that holds 95 % of a plane normal distribution of unit deviation."""

_PLANES = (
    ("seen from above: x over y", 1, 0, "y east [cm]", "x north [cm]"),
    ("seen from the south: z over y", 1, 2, "y east [cm]", "up [cm]"),
    ("seen from the east: z over x", 0, 2, "x north [cm]", "up [cm]"),
)


def hover_graph(records: Sequence[FlightRecord], names: Sequence[str]) -> Graph | None:
    """Deviation in the planes xy, zy and zx, with the ellipse that holds 95 % of it; None without hover.

    Args:
        records: flights, at least one.
        names: one for each flight.
    """
    clouds = [hover_deviation(record) for record in records]
    if not any(map(len, clouds)):
        return None
    plots = []
    widest = 1e-3
    for title, across, up, x_label, y_label in _PLANES:
        curves: list[Curve] = []
        for flight, (cloud, name) in enumerate(zip(clouds, names, strict=True)):
            if len(cloud):
                label = name if len(records) > 1 else "true position"
                flat = cloud[:, (across, up)]
                widest = max(widest, float(np.max(np.abs(flat))))
                dots = flat[:: -(-len(flat) // MOST_DOTS)]
                curves.append(Curve(label, dots[:, 0], dots[:, 1], flight, Kind.CLOUD))
                if len(flat) > 2:
                    around = ellipse(flat)
                    widest = max(widest, float(np.max(np.abs(around))))
                    inside = "95 %" if len(records) == 1 else f"{name}, 95 %"
                    curves.append(Curve(inside, around[:, 0], around[:, 1], flight))
        curves.append(Curve("reference", np.zeros(1), np.zeros(1), GREY, Kind.CROSSES))
        plots.append(Plot(title, x_label, y_label, tuple(curves), equal=True))
    window = (-1.08 * widest, 1.08 * widest)
    plots = [replace(plot, x_range=window, y_range=window) for plot in plots]
    caption = (
        "True position less reference while hovering, without the end of the climb. The ellipse would hold "
        "95 % of a normal distribution of the same mean and covariance. All scales are the same."
    )
    return Graph("hover", "Hover in three planes", caption, (tuple(plots),), row_height=360)


def hover_deviation(record: FlightRecord) -> Array:
    """True position less reference in all hovers: north, east, up [cm], shape (n, 3)."""
    truth = record.truth
    parts: list[Array] = [np.zeros((0, 3))]
    for leg in reference_legs(record):
        if leg.jump is None:
            inside = (truth.stamps >= hover_start(leg)) & (truth.stamps < leg.end_ns)
            parts.append(100.0 * (truth.position[inside] - leg.reference[:3]))
    found: Array = np.concatenate(parts) * np.array([1.0, 1.0, -1.0])
    return found


def ellipse(cloud: Array, radius: float = _QUANTILE_95) -> Array:
    """Points of equal likelihood of the normal distribution that fits a cloud.

    Args:
        cloud: shape (n, 2), n at least 3.
        radius: in standard deviations.

    Returns:
        Closed curve, shape (73, 2).
    """
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    values, vectors = np.linalg.eigh(np.cov(cloud.T))
    axes = vectors * np.sqrt(np.maximum(values, 0.0))
    return np.asarray(
        cloud.mean(axis=0) + radius * np.column_stack((np.cos(turn), np.sin(turn))) @ axes.T,
        dtype=np.float64,
    )
