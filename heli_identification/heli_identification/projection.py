"""Projection method: the part of the input that the external signal caused, then output error (source 2.5.1).

1. u is regressed on past and future samples of the external signal r: a non-causal FIR estimate of the input
   sensitivity, u_hat(k) = sum over j = -M .. M of s_j r(k - j).
2. y is explained by u_hat alone in an output-error model. What feedback put into u is left out, so noise in
   the loop does not bias the estimate whatever its colour (U. Forssell, L. Ljung, 2000); it does spread it.

Nothing need be known of the controller. It needs an external signal, experiment (b) of the source.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_identification.parametrisation import Noise
from heli_identification.prediction_error import Estimate, Search, prediction_error
from heli_identification.records import Record
from heli_identification.sampling import Hold
from heli_identification.structures import Structure

Array = NDArray[np.float64]

REACH = 1.5
"""Length of the filter to either side [s]: the loop has forgotten by then."""


@dataclass(frozen=True, eq=False)
class Projected:
    """A record whose input is the projected one.

    Attributes:
        record: its ends, for which the filter lacks samples, are cut off.
        share: of the input's variance that the external signal explains, shape (m,).
    """

    record: Record
    share: Array


def project(record: Record, reach: float = REACH) -> Projected:
    """Step 1.

    Args:
        record: with an external signal.
        reach: of the filter to either side [s].

    Raises:
        InputError: no external signal, it is constant, or too few samples for the filter.
    """
    if record.r is None or not np.any(np.ptp(record.r, axis=0) > 0.0):
        problem = "no external signal within the input"
        raise InputError(problem, allowed="a flight with an excitation on the command", key=record.name)
    used = record.r[:, np.ptp(record.r, axis=0) > 0.0]
    taps = round(reach / record.period)
    rows = len(record) - 2 * taps
    unknown = used.shape[1] * (2 * taps + 1) + 1
    if rows < 2 * unknown:
        problem = f"{len(record)} samples for {unknown} coefficients of the projection"
        allowed = f"at least {2 * unknown + 2 * taps} samples in one piece"
        raise InputError(problem, allowed=allowed, key=record.name)
    lags = [used[taps + lag : taps + lag + rows] for lag in range(-taps, taps + 1)]
    regressors = np.hstack((*lags, np.ones((rows, 1))))
    u = record.u[taps : taps + rows]
    solution, *_ = np.linalg.lstsq(regressors, u, rcond=1e-10)
    projected = regressors @ solution
    explained = 1.0 - np.sum((u - projected) ** 2, axis=0) / np.sum((u - u.mean(axis=0)) ** 2, axis=0)
    return Projected(replace(record.piece(taps, taps + rows), u=projected), explained)


def projection(
    structure: Structure,
    records: Sequence[Record],
    *,
    hold: Hold = Hold.ZERO,
    reach: float = REACH,
    search: Search | None = None,
) -> Estimate:
    """Both steps; standard errors are the robust ones, since all of the noise is in the residuals.

    Args:
        structure: what is estimated.
        records: data with external signals.
        hold: of the input.
        reach: of the filter to either side [s].
        search: how the minimum is looked for.

    Raises:
        InputError: see `project` and `prediction_error`.
    """
    data = [project(record, reach).record for record in records]
    return prediction_error(structure, data, noise=Noise.OUTPUT_ERROR, hold=hold, search=search)
