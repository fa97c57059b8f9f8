"""Charts of the design report as plain curves over one logarithmic axis: a grid of plots each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_flight import graphs
from heli_flight.graphs import Curve, Graph, Kind

Array = NDArray[np.float64]

GREEK = {"theta": "θ", "phi": "φ", "psi": "ψ", "Omega": "Ω"}
"""Signals as they are written in charts."""

SIGNAL_COLOURS = {"theta": 0, "u": 1, "q": 2, "phi": 3, "v": 4, "p": 5, "w": 6, "r": 7, "Omega": 0}
"""Number of the colour of each signal."""


@dataclass(frozen=True, eq=False)
class Trace:
    """One curve.

    Attributes:
        label: in the legend.
        y: over the x of the chart, shape (n,).
        colour: number of the colour.
        dashed: whether it is a model, a bound or a wish.
    """

    label: str
    y: Array
    colour: int
    dashed: bool = False


@dataclass(frozen=True)
class Marker:
    """A printed value of the source as a point; `colour` is that of its curve."""

    label: str
    x: float
    y: float
    colour: int


@dataclass(frozen=True)
class Plot:
    """One pair of axes.

    Attributes:
        title: above it.
        traces: curves.
        markers: points.
        unit: of y.
        limits: dotted lines across it.
        range: of y; None takes what there is.
    """

    title: str
    traces: tuple[Trace, ...]
    markers: tuple[Marker, ...] = ()
    unit: str = "dB"
    limits: tuple[float, ...] = ()
    range: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Chart:
    """A grid of plots over the same x.

    Attributes:
        key: part of file names and links.
        title, caption: for people.
        x: ascending, positive, shape (n,).
        rows: of plots, all of one length.
        x_label: below the last row.
    """

    key: str
    title: str
    caption: str
    x: Array
    rows: tuple[tuple[Plot, ...], ...]
    x_label: str = "frequency [rad/s]"


def decibel(magnitude: Array) -> Array:
    """20 log10 of a magnitude; zero is -400 dB."""
    return np.asarray(20.0 * np.log10(np.maximum(magnitude, 1e-20)), dtype=np.float64)


def chart_graph(chart: Chart) -> Graph:
    """A chart as page and pictures draw it."""
    last = len(chart.rows) - 1
    rows = tuple(
        tuple(_plot(chart, plot, row == last, column == 0) for column, plot in enumerate(plots))
        for row, plots in enumerate(chart.rows)
    )
    return Graph(chart.key, chart.title, chart.caption, rows)


def _plot(chart: Chart, plot: Plot, lowest: bool, leftmost: bool) -> graphs.Plot:
    """The plot with its traces, cut off well below its range, and printed values on top."""
    low = plot.range[0] - 60.0 if plot.range else -np.inf
    curves = [
        Curve(
            trace.label,
            chart.x,
            np.maximum(trace.y, low),
            trace.colour,
            Kind.DASHED if trace.dashed else Kind.LINE,
        )
        for trace in plot.traces
    ]
    curves += [
        Curve(marker.label, np.array([marker.x]), np.array([marker.y]), marker.colour, Kind.DIAMONDS)
        for marker in plot.markers
    ]
    return graphs.Plot(
        plot.title,
        chart.x_label if lowest else "",
        f"[{plot.unit}]" if leftmost else "",
        tuple(curves),
        plot.limits,
        log=True,
        x_range=(float(chart.x[0]), float(chart.x[-1])),
        y_range=plot.range,
    )
