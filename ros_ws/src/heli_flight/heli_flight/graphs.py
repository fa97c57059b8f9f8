"""Graphs of the reports as plain curves: a grid of plots, each with axes of its own."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


GREY = -1
"""Number of the colour of a reference or a claimed band, beside those of curves from 0 on."""


class Kind(Enum):
    """How a curve is drawn."""

    LINE = "line"
    WIDE = "wide"
    """pale and wide, for another curve on top"""
    DASHED = "dashed"
    POINTS = "points"
    CLOUD = "cloud"
    """many small translucent points"""
    CROSSES = "crosses"
    DIAMONDS = "diamonds"
    """hollow, for printed values"""
    STEMS = "stems"
    BAND = "band"


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve.

    Attributes:
        label: in the legend; empty keeps it out.
        x: shape (n,). y: shape (n,); NaN breaks a line.
        colour: number of the colour.
        kind: how it is drawn.
        upper: of a band, whose lower edge is y; shape (n,).
    """

    label: str
    x: Array
    y: Array
    colour: int
    kind: Kind = Kind.LINE
    upper: Array | None = None


@dataclass(frozen=True)
class Plot:
    """One pair of axes.

    Attributes:
        title: above it. x_label, y_label: of the axes.
        curves: later ones on top.
        limits: dotted lines across it.
        log, y_log: whether x or y is logarithmic.
        equal: whether a unit is as long in x as in y.
        x_range, y_range: None takes what there is.
    """

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    limits: tuple[float, ...] = ()
    log: bool = False
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    y_log: bool = False
    equal: bool = False


@dataclass(frozen=True, eq=False)
class Graph:
    """A grid of plots.

    Attributes:
        key: part of file names and links.
        title, caption: for people.
        rows: of plots, all of one length.
        row_height: of the page's plot [pixels].
        timed: whether every x is the time of flight [s].
    """

    key: str
    title: str
    caption: str
    rows: tuple[tuple[Plot, ...], ...]
    row_height: int = 220
    timed: bool = False
