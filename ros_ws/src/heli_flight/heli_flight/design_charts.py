"""Charts of the design report as plain curves over one logarithmic axis: a grid of plots each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
