"""Prediction error method, direct approach: Levenberg-Marquardt with analytic sensitivities (source 2.5.1).

The data are used as if there were no feedback; with a noise model that can describe the disturbance the
estimate is consistent all the same. Coefficients are freed step by step, as in the source, then all together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_identification.criterion import Criterion
from heli_identification.levenberg_marquardt import Step, minimise
from heli_identification.parametrisation import Noise, Parametrisation
from heli_identification.records import Record
from heli_identification.residual_tests import residuals_white
from heli_identification.sampling import Hold
from heli_identification.start_values import start_vector
from heli_identification.structures import Structure
from heli_identification.uncertainty import (
    QUANTILE_95,
    Weakness,
    correlations,
    inverse_information,
    sandwich,
    weaknesses,
)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Search:
    """How the minimum is looked for.

    Attributes:
        stepwise: whether coefficients are freed step by step first.
        iterations: at most, in the last step. stage_iterations: in each step before.
        tolerance: end when the expected gain of a step in log likelihood falls below.
        correlation_time: [s] over which the residuals may be correlated, for robust standard errors.
    """

    stepwise: bool = True
    iterations: int = 40
    stage_iterations: int = 4
    tolerance: float = 1e-3
    correlation_time: float = 1.0


@dataclass(frozen=True, eq=False)
class Estimate:
    """What came out.

    Attributes:
        structure: with the estimated values.
        names: of the estimated coefficients, r of them.
        values: shape (r,), SI.
        fisher: their covariance if the residuals are white, shape (r, r): the Cramer-Rao bound.
        robust: their covariance for coloured residuals, shape (r, r).
        white: whether the residuals pass the test of whiteness; decides which covariance is claimed.
        noise: model of the disturbances. noise_names, noise_values: its unknowns, variances as logarithms.
        K: gain of the one-step predictor, shape (n, p).
        weighting: covariance of the residuals, shape (p, p).
        residuals: shape (N, p) per record.
        starts: initial state per record, shape (n,). offsets: constant on the measured states' derivatives.
        converged: whether the search came to its end.
        steps: of the search.
        weak: what the data cannot determine.
    """

    structure: Structure
    names: tuple[str, ...]
    values: Array
    fisher: Array
    robust: Array
    white: bool
    noise: Noise
    noise_names: tuple[str, ...]
    noise_values: Array
    K: Array
    weighting: Array
    residuals: tuple[Array, ...]
    starts: tuple[Array, ...]
    offsets: tuple[Array, ...]
    converged: bool
    steps: tuple[Step, ...] = field(repr=False)
    weak: tuple[Weakness, ...] = ()

    @property
    def covariance(self) -> Array:
        """The claimed covariance, shape (r, r)."""
        return self.fisher if self.white else self.robust

    @property
    def errors(self) -> Array:
        """Claimed standard errors, shape (r,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)), dtype=np.float64)

    @property
    def intervals(self) -> Array:
        """95 % intervals, shape (r, 2)."""
        half = QUANTILE_95 * self.errors
        return np.column_stack((self.values - half, self.values + half))

    @property
    def correlations(self) -> Array:
        """Of the estimates, shape (r, r)."""
        return correlations(self.covariance)


def prediction_error(
    structure: Structure,
    records: Sequence[Record],
    *,
    noise: Noise = Noise.KALMAN,
    hold: Hold = Hold.ZERO,
    offsets: bool = True,
    weighting: Array | None = None,
    search: Search | None = None,
) -> Estimate:
    """Estimate the free parameters of a structure, starting from its values.

    Args:
        structure: what is estimated.
        records: data, prepared (`preparation`).
        noise: model of the disturbances.
        hold: what the input does between samples.
        offsets: whether constants on the derivatives of the measured states are estimated beside.
        weighting: covariance of the residuals, shape (p, p), instead of the noise model's or their own.
        search: how the minimum is looked for.

    Raises:
        InputError: no records, signals that are not the structure's, nothing free, or no usable predictor at
            the start values.
    """
    _check(structure, records)
    parametrisation = Parametrisation(structure, noise, records[0].period, hold, offsets=offsets)
    return estimate(parametrisation, records, weighting=weighting, search=search)


def estimate(
    parametrisation: Parametrisation,
    records: Sequence[Record],
    *,
    weighting: Array | None = None,
    search: Search | None = None,
) -> Estimate:
    """The same for any parametrisation, records being its inputs and outputs.

    Args:
        parametrisation: of the predictor.
        records: data.
        weighting: covariance of the residuals, shape (p, p), instead of the noise model's or their own.
        search: how the minimum is looked for.

    Raises:
        InputError: no usable predictor at the start values.
    """
    how, structure = search or Search(), parametrisation.structure
    criterion = Criterion(parametrisation, records, weighting)
    vector = start_vector(criterion)
    steps: list[Step] = []
    everything = np.ones(criterion.size, dtype=bool)
    if how.stepwise:
        freed: set[str] = set()
        for stage in structure.stages:
            freed |= set(stage)
            active = everything.copy()
            active[: len(structure.free_names)] = [name in freed for name in structure.free_names]
            if active[: len(structure.free_names)].any():
                limits = (how.stage_iterations, 1.0)
                vector, _ = minimise(criterion, vector, active, limits, " ".join(stage), steps)
    last = (how.iterations, how.tolerance)
    vector, converged = minimise(criterion, vector, everything, last, "all", steps)
    return _estimate(criterion, vector, converged, tuple(steps), how)


def _check(structure: Structure, records: Sequence[Record]) -> None:
    if not records:
        raise InputError("no data", allowed="at least one record", key=structure.name)
    if not structure.free_names:
        raise InputError("nothing is free", allowed=", ".join(structure.names), key=structure.name)
    for record in records:
        for found, wanted in ((record.inputs, structure.inputs), (record.outputs, structure.outputs)):
            if found != wanted:
                problem = f"signals {', '.join(found)}"
                raise InputError(problem, allowed=", ".join(wanted), key=record.name)
        if record.period != records[0].period:
            problem = f"sample time {record.period} s beside {records[0].period} s"
            raise InputError(problem, allowed="one sample time", key=record.name)


def _estimate(
    criterion: Criterion,
    vector: Array,
    converged: bool,
    steps: tuple[Step, ...],
    how: Search,
) -> Estimate:
    p = criterion.parametrisation
    structure, free = p.structure, len(p.free)
    evaluation = criterion.evaluate(vector, scores=True)
    common = criterion.common(vector)
    whole = inverse_information(evaluation.information)
    unit = np.outer(criterion.scales[:free], criterion.scales[:free])
    lag = max(1, round(how.correlation_time / p.period))
    finite = np.where(np.isfinite(whole), whole, 0.0)
    robust = sandwich(finite, evaluation.scores, lag)[:free, :free]
    robust[~np.isfinite(whole[:free, :free])] = np.inf
    names = structure.free_names
    fisher = whole[:free, :free] * unit
    white = residuals_white(evaluation.residuals)
    claimed = fisher if white else robust * unit
    return Estimate(
        structure=structure.with_values(dict(zip(names, common[:free].tolist(), strict=True))),
        names=names,
        values=common[:free].copy(),
        fisher=fisher,
        robust=robust * unit,
        white=white,
        noise=p.noise,
        noise_names=p.noise_names,
        noise_values=common[free:].copy(),
        K=p.point(common).K,
        weighting=evaluation.weighting,
        residuals=evaluation.residuals,
        starts=tuple(criterion.local(vector, i)[: p.n] for i in range(len(criterion.records))),
        offsets=tuple(criterion.local(vector, i)[p.n :] for i in range(len(criterion.records))),
        converged=converged,
        steps=steps,
        weak=weaknesses(names, claimed, np.maximum(structure.scales[p.free], np.abs(common[:free]))),
    )
