"""Long curves with few points that look the same: the lowest and the highest value of every stretch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_POINTS = 6000
"""Of a drawn curve: a minute at 100 Hz is drawn point by point, ten minutes as an envelope of 0.2 s."""


def thinned(x: Array, y: Array, most: int = MOST_POINTS) -> tuple[Array, Array]:
    """At most `most` points of a curve, with the first, the last, and both extremes of every stretch.

    Short curves come back as they are. A stretch without any number stays a gap; one that has a number loses
    its gaps.

    Args:
        x, y: shape (n,); NaN in y breaks the curve.
        most: at least 6.

    Raises:
        ValueError: `most` is too small.
    """
    if most < 6:
        raise ValueError(f"{most} points are too few for a curve")
    if len(y) <= most:
        return x, y
    edges = np.linspace(0, len(y), (most - 2) // 2 + 1).astype(np.int64)
    starts, lengths = edges[:-1], np.diff(edges)
    # stretches differ by one point at most: the shorter ones repeat their last
    index = np.minimum(np.arange(lengths.max())[None, :], lengths[:, None] - 1) + starts[:, None]
    table = y[index]
    gap = np.isnan(table)
    low = np.argmin(np.where(gap, np.inf, table), axis=1)
    high = np.argmax(np.where(gap, -np.inf, table), axis=1)
    both = np.sort(np.column_stack((low, high)), axis=1)
    kept = np.unique(np.concatenate(([0], np.take_along_axis(index, both, axis=1).ravel(), [len(y) - 1])))
    return x[kept], y[kept]
