"""Projection method: the part of the input that the external signal caused, then output error (source 2.5.1).

1. u is regressed on past and future samples of the external signal r: a non-causal FIR estimate of the input
   sensitivity, u_hat(k) = sum over j = -M .. M of s_j r(k - j), far lags sharing coefficients.
2. y is explained by u_hat alone in an output-error model. What feedback put into u is left out, so noise in
   the loop does not bias the estimate whatever its colour (U. Forssell, L. Ljung, 2000); it does spread it.

Nothing need be known of the controller. It needs an external signal, experiment (b) of the source.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_identification.parametrisation import Noise
from heli_identification.prediction_error import Estimate, Search, prediction_error
from heli_identification.records import Record
from heli_identification.sampling import Hold
from heli_identification.structures import Structure

Array = NDArray[np.float64]

BEHIND = 6.0
"""How far the filter reaches into the past [s]: the loop has forgotten by then."""
AHEAD = 0.2
"""How far it reaches into the future [s]."""
SINGLE = 16
"""Lags with a coefficient of their own; farther ones share theirs with neighbours."""
GROWTH = 1.12
"""Growth of the groups of far lags: the tail is smooth, and every coefficient lets noise through."""

CORRELATION_TIME = 4.0
"""The residuals hold the motion of the whole loop in noise, which is slow [s]."""


@dataclass(frozen=True, eq=False)
class Projected:
    """A record whose input is the projected one.

    Attributes:
        record: its ends, for which the filter lacks samples, are cut off.
        share: of the input's variance that the external signal explains, shape (m,).
    """

    record: Record
    share: Array


def project(record: Record, behind: float = BEHIND) -> Projected:
    """Step 1.

    Args:
        record: with an external signal.
        behind: reach of the filter into the past [s].

    Raises:
        InputError: no external signal, it is constant, or too few samples for the filter.
    """
    if record.r is None or not np.any(np.ptp(record.r, axis=0) > 0.0):
        problem = "no external signal within the input"
        raise InputError(problem, allowed="a flight with an excitation on the command", key=record.name)
    used = record.r[:, np.ptp(record.r, axis=0) > 0.0]
    past, future = round(behind / record.period), round(AHEAD / record.period)
    edges = lag_groups(past, future)
    rows, unknown = len(record) - past - future, used.shape[1] * (len(edges) - 1) + 1
    if rows < 4 * unknown:
        problem = f"{len(record)} samples for {unknown} coefficients of the projection"
        allowed = f"at least {4 * unknown + past + future} samples in one piece"
        raise InputError(problem, allowed=allowed, key=record.name)
    total = np.vstack((np.zeros(used.shape[1]), np.cumsum(used, axis=0)))
    # the sum of r over the lags first .. last - 1 before each sample
    groups = [
        total[past - first + 1 : past - first + 1 + rows] - total[past - last + 1 : past - last + 1 + rows]
        for first, last in pairwise(edges)
    ]
    regressors = np.hstack((*groups, np.ones((rows, 1))))
    u = record.u[past : past + rows]
    solution, *_ = np.linalg.lstsq(regressors, u, rcond=1e-10)
    projected = regressors @ solution
    explained = 1.0 - np.sum((u - projected) ** 2, axis=0) / np.sum((u - u.mean(axis=0)) ** 2, axis=0)
    return Projected(replace(record.piece(past, past + rows), u=projected), explained)


def lag_groups(past: int, future: int) -> list[int]:
    """First lags of the groups that share a coefficient, ascending; the last entry ends the last group.

    Args:
        past: largest lag.
        future: largest negative lag.
    """
    edges = list(range(-future, min(SINGLE, past) + 1))
    width = 1.0
    while edges[-1] <= past:
        width *= GROWTH
        edges.append(edges[-1] + max(1, round(width)))
    edges[-1] = past + 1
    return edges


def projection(
    structure: Structure,
    records: Sequence[Record],
    *,
    hold: Hold = Hold.ZERO,
    behind: float = BEHIND,
    search: Search | None = None,
) -> Estimate:
    """Both steps; standard errors are the robust ones, since all of the noise is in the residuals.

    Args:
        structure: what is estimated.
        records: data with external signals.
        hold: of the input.
        behind: reach of the filter into the past [s].
        search: how the minimum is looked for.

    Raises:
        InputError: see `project` and `prediction_error`.
    """
    data = [project(record, behind).record for record in records]
    how = search or Search(correlation_time=CORRELATION_TIME)
    return prediction_error(structure, data, noise=Noise.OUTPUT_ERROR, hold=hold, search=how)
