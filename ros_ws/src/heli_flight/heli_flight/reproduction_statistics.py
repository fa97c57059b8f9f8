"""Means with intervals, ratios over the same seeds, and orders, of what was flown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Interval:
    """A mean and the Student interval that holds the true one in 95 of 100 cases.

    Attributes:
        mean: of the values; of ratios the geometric one.
        low, high: ends; NaN of a single value.
        count: values.
    """

    mean: float
    low: float
    high: float
    count: int

    def scaled(self, factor: float) -> Interval:
        """In another unit; the factor is positive."""
        return Interval(self.mean * factor, self.low * factor, self.high * factor, self.count)


def interval(values: Sequence[float]) -> Interval | None:
    """Mean and interval of independent values; None of no values."""
    if not len(values):
        return None
    array = np.asarray(values, dtype=np.float64)
    mean, count = float(array.mean()), len(array)
    if count == 1:
        return Interval(mean, math.nan, math.nan, 1)
    half = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, count - 1) * array.std(ddof=1) / math.sqrt(count))
    return Interval(mean, mean - half, mean + half, count)


def paired_ratio(ours: Mapping[int, float], theirs: Mapping[int, float]) -> Interval | None:
    """Geometric mean of the ratios of positive values with the same seed, interval by logarithms.

    Args:
        ours: by seed. theirs: by seed; seeds that only one has do not count.
    """
    seeds = sorted(ours.keys() & theirs.keys())
    found = interval([math.log(ours[seed] / theirs[seed]) for seed in seeds])
    if found is None:
        return None
    return Interval(math.exp(found.mean), math.exp(found.low), math.exp(found.high), found.count)


def order(values: Mapping[str, float]) -> tuple[str, ...]:
    """Names from the smallest value to the largest."""
    return tuple(sorted(values, key=lambda name: values[name]))


def rank_correlation(ours: Mapping[str, float], theirs: Mapping[str, float]) -> float | None:
    """Kendall's tau between two orders of the same names: 1 the same, -1 reversed; None below two names."""
    names = sorted(ours.keys() & theirs.keys())
    if len(names) < 2:
        return None
    found = stats.kendalltau([ours[name] for name in names], [theirs[name] for name in names])
    return None if math.isnan(found.statistic) else float(found.statistic)
