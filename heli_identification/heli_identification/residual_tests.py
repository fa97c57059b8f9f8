"""What is left over: whiteness of residuals and their correlation with the inputs, with bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from heli_identification.uncertainty import QUANTILE_95

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Correlations:
    """Correlations over lags with their bound.

    Attributes:
        lags: in samples, shape (l,).
        values: shape (l, p) of residuals with themselves, or (l, p, m) of residuals with past inputs.
        bound: white residuals stay within +- bound 95 % of the time, shape (p,) or (p, m).
    """

    lags: NDArray[np.int64]
    values: Array
    bound: Array

    @property
    def outside(self) -> Array:
        """Share of the lags, zero left out, that lie outside the bound, shape (p,) or (p, m)."""
        counted = self.lags != 0
        share: Array = np.mean(np.abs(self.values[counted]) > self.bound, axis=0)
        return share


def autocorrelation(residuals: Array, lags: int = 25) -> Correlations:
    """Normalised autocorrelations of lags 0 .. `lags` (L. Ljung, 1999, sec. 16.6).

    Args:
        residuals: shape (N, p).
        lags: largest lag in samples.
    """
    centred = residuals - residuals.mean(axis=0)
    count, power = len(centred), np.maximum(np.sum(centred**2, axis=0), 1e-300)
    values = [np.sum(centred[lag:] * centred[: count - lag], axis=0) / power for lag in range(lags + 1)]
    bound = np.full(residuals.shape[1], QUANTILE_95 / np.sqrt(count))
    return Correlations(np.arange(lags + 1), np.array(values), bound)


def cross_correlation(residuals: Array, inputs: Array, lags: int = 25) -> Correlations:
    """Correlations of residuals with inputs `lag` samples before, lags -`lags` .. `lags`.

    Negative lags are later inputs: with feedback they may be correlated, without that being an error of the
    model. The bound takes the colour of both into account.

    Args:
        residuals: shape (N, p).
        inputs: shape (N, m).
        lags: largest lag in samples.
    """
    e, u = residuals - residuals.mean(axis=0), inputs - inputs.mean(axis=0)
    count = len(e)
    sizes = np.outer(
        np.maximum(np.sqrt(np.sum(e**2, axis=0)), 1e-150), np.maximum(np.sqrt(np.sum(u**2, axis=0)), 1e-150)
    )
    values = []
    for lag in range(-lags, lags + 1):
        late, early = (e[lag:], u[: count - lag]) if lag >= 0 else (e[: count + lag], u[-lag:])
        values.append(late.T @ early / sizes)
    widest = min(count - 1, 10 * lags)
    own_e, own_u = autocorrelation(e, widest).values, autocorrelation(u, widest).values
    joint = 1.0 + 2.0 * np.einsum("lp,lm->pm", own_e[1:], own_u[1:])
    bound = QUANTILE_95 * np.sqrt(np.maximum(joint, 0.1) / count)
    return Correlations(np.arange(-lags, lags + 1), np.array(values), bound)


def residuals_white(residuals: Sequence[Array], lags: int = 20, level: float = 0.001) -> bool:
    """Whether the autocorrelations of all residuals over some lags are those of white noise (Ljung and Box).

    Args:
        residuals: shape (N, p) per record.
        lags: number of lags.
        level: probability of calling white residuals coloured, of all p outputs together.
    """
    for output in range(residuals[0].shape[1]):
        statistic = 0.0
        series = np.concatenate([part[:, output] - part[:, output].mean() for part in residuals])
        power = float(series @ series)
        if power == 0.0:
            continue
        for lag in range(1, lags + 1):
            correlation = float(series[lag:] @ series[:-lag]) / power
            statistic += correlation**2 / (len(series) - lag)
        statistic *= len(series) * (len(series) + 2)
        if statistic > chi2.ppf(1.0 - level / residuals[0].shape[1], lags):
            return False
    return True
