"""How well estimated numbers are known: covariances, intervals, and what the data cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

QUANTILE_95 = 1.959963984540054
"""Half width of a normal 95 % interval in standard errors."""

BLIND = 1e-12
"""An unknown whose information is below this share of its neighbours' has no effect on the data."""

TOGETHER = 0.3
"""Component of a unit direction from which a parameter is named as part of it."""


def inverse_information(information: Array) -> Array:
    """Covariance of all unknowns, shape (P, P); infinite variance where the data say nothing.

    Args:
        information: Fisher's, symmetric, not negative, shape (P, P).
    """
    diagonal = np.diag(information).copy()
    active = diagonal > BLIND * max(float(np.max(diagonal)), 1e-300) * 1e-12
    root = np.sqrt(diagonal[active])
    correlation = information[np.ix_(active, active)] / np.outer(root, root)
    values, vectors = np.linalg.eigh(correlation)
    known = values > 1e-13 * len(values)
    inverse = (vectors[:, known] / values[known]) @ vectors[:, known].T
    lost = np.sum(vectors[:, ~known] ** 2, axis=1) > 1e-6
    covariance = np.zeros_like(information)
    covariance[np.ix_(active, active)] = inverse / np.outer(root, root)
    blind = ~active
    blind[np.flatnonzero(active)[lost]] = True
    covariance[blind, :] = covariance[:, blind] = 0.0
    covariance[blind, blind] = np.inf
    return covariance


def sandwich(covariance: Array, scores: Sequence[Array], lag: int) -> Array:
    """Covariance that holds for coloured residuals, too (W. Newey, K. West, 1987), shape (P, P).

    Args:
        covariance: inverse of the information, shape (P, P), finite.
        scores: each sample's part of the gradient, shape (N, P), one array per piece of data.
        lag: samples over which residuals are correlated; Bartlett weights, as overlapping sums.
    """
    middle = np.zeros_like(covariance)
    for score in scores:
        width = min(lag, len(score))
        padded = np.zeros((len(score) + 2 * width - 1, score.shape[1]))
        padded[width : width + len(score)] = score
        total = np.cumsum(padded, axis=0)
        sums = total[width:] - total[:-width]
        middle += sums.T @ sums / width
    return covariance @ middle @ covariance


def correlations(covariance: Array) -> Array:
    """Correlation matrix, shape (r, r); zero where a variance is infinite or zero."""
    deviation = np.sqrt(np.diag(covariance))
    usable = np.isfinite(deviation) & (deviation > 0.0)
    found = np.eye(len(covariance))
    part = np.ix_(usable, usable)
    found[part] = covariance[part] / np.outer(deviation[usable], deviation[usable])
    return found


@dataclass(frozen=True)
class Weakness:
    """A direction in which the data hardly determine the parameters.

    Attributes:
        names: parameters that take part, strongest first.
        shares: their components of the unit direction in scaled parameters.
        deviation: standard error along the direction, relative to the scales.
        reason: in words.
    """

    names: tuple[str, ...]
    shares: tuple[float, ...]
    deviation: float
    reason: str


def weaknesses(
    names: Sequence[str], covariance: Array, scales: Array, limit: float = 0.5
) -> tuple[Weakness, ...]:
    """Directions whose standard error exceeds `limit` times the parameters' scales, worst first.

    Args:
        names: r parameters.
        covariance: of their estimates, shape (r, r).
        scales: expected sizes, shape (r,).
        limit: relative standard error from which a direction counts as not identified.
    """
    found = []
    blind = ~np.isfinite(np.diag(covariance))
    for index in np.flatnonzero(blind):
        reason = "the data do not depend on it, or only together with others that are estimated"
        found.append(Weakness((names[index],), (1.0,), float("inf"), reason))
    rest = np.flatnonzero(~blind)
    relative = covariance[np.ix_(rest, rest)] / np.outer(scales[rest], scales[rest])
    values, vectors = np.linalg.eigh(relative)
    for value, vector in sorted(zip(values, vectors.T, strict=True), key=lambda pair: -pair[0]):
        deviation = float(np.sqrt(max(value, 0.0)))
        if deviation <= limit:
            continue
        order = [i for i in np.argsort(-np.abs(vector)) if abs(vector[i]) >= TOGETHER]
        part = tuple(names[rest[i]] for i in order)
        if len(part) == 1:
            reason = f"{part[0]} hardly moves the outputs in these data"
        else:
            reason = f"{' and '.join(part)} act alike in these data: only their combination is seen"
        found.append(Weakness(part, tuple(float(vector[i]) for i in order), deviation, reason))
    return tuple(found)
