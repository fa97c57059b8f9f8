"""The likelihood of the prediction errors, its gradient and Fisher information (source eq. 2.75-2.78).

With a noise model that gives the innovations' covariance S:  V = 1/2 sum e' S^-1 e + N/2 log det S. Otherwise
the weighting is the residuals' own covariance, V = N/2 log det (1/N sum e e'), or a matrix that is given. All
in scaled unknowns (L. Ljung, 1999, sec. 7.2, 10.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_identification.innovations import with_sensitivities
from heli_identification.parametrisation import Parametrisation, Point
from heli_identification.records import Record
from heli_identification.sampling import held_inputs

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The criterion at one vector of P unknowns.

    Attributes:
        cost: negative logarithm of the likelihood, up to a constant.
        gradient: shape (P,).
        information: Fisher's, shape (P, P).
        scores: each sample's part of the gradient, shape (N, P), one array per record; empty if not wanted.
        residuals: shape (N, p), one array per record.
        weighting: covariance of the residuals that was used, shape (p, p).
    """

    cost: float
    gradient: Array
    information: Array
    scores: tuple[Array, ...]
    residuals: tuple[Array, ...]
    weighting: Array


class Criterion:
    """Cost of a vector of scaled unknowns on some records.

    Args:
        parametrisation: of the unknowns.
        records: data; all of the parametrisation's period, inputs and outputs.
        weighting: covariance of the residuals, shape (p, p), or None: the noise model's or their own.

    Attributes:
        size: number of unknowns, P.
        scales: of all unknowns, shape (P,).
    """

    def __init__(
        self, parametrisation: Parametrisation, records: Sequence[Record], weighting: Array | None = None
    ) -> None:
        self.parametrisation, self.records, self.weighting = parametrisation, tuple(records), weighting
        self._u = [
            np.ascontiguousarray(held_inputs(record.u, parametrisation.hold)) for record in self.records
        ]
        self._y = [np.ascontiguousarray(record.y) for record in self.records]
        self.samples = sum(len(y) for y in self._y)
        common, local = parametrisation.common, parametrisation.local
        self.size = common + local * len(self.records)
        shared, own = parametrisation.scales[:common], parametrisation.scales[common:]
        self.scales = np.concatenate((shared, np.tile(own, len(self.records))))

    def places(self, record: int) -> NDArray[np.int64]:
        """Where the common and the local unknowns of a record stand, shape (common + local,)."""
        common, local = self.parametrisation.common, self.parametrisation.local
        own = common + record * local + np.arange(local)
        return np.concatenate((np.arange(common), own))

    def common(self, vector: Array) -> Array:
        """Common unknowns in SI."""
        count = self.parametrisation.common
        common: Array = vector[:count] * self.scales[:count]
        return common

    def local(self, vector: Array, record: int) -> Array:
        """Initial state and offsets of a record in SI."""
        own = self.places(record)[self.parametrisation.common :]
        local: Array = vector[own] * self.scales[own]
        return local

    def residuals(self, vector: Array) -> tuple[Point, tuple[Array, ...]] | None:
        """The point and its residuals, or None where the predictor is unstable or does not exist."""
        try:
            point = self.parametrisation.point(self.common(vector))
        except ValueError:
            return None
        found = []
        for index, (u, y) in enumerate(zip(self._u, self._y, strict=True)):
            predictor, start = self.parametrisation.predictor(point, self.local(vector, index))
            errors, fine = predictor.residuals(u, y, start)
            if not fine:
                return None
            found.append(errors)
        return point, tuple(found)

    def cost(self, vector: Array) -> float:
        """The criterion, infinite where the predictor is unstable or does not exist."""
        known = self.residuals(vector)
        if known is None:
            return float("inf")
        return self._cost(*known)[0]

    def evaluate(self, vector: Array, *, scores: bool = False) -> Evaluation:
        """Criterion, gradient, information and, if wanted, scores.

        Raises:
            ValueError: the predictor is unstable or does not exist here.
        """
        known = self.residuals(vector)
        if known is None:
            raise ValueError("the predictor is unstable here")
        point, residuals = known
        cost, weighting = self._cost(point, residuals)
        inverse = np.linalg.inv(weighting)
        whitening = np.linalg.cholesky(inverse).T
        information = np.zeros((self.size, self.size))
        gradient, found = np.zeros(self.size), []
        dense = self.parametrisation.dense
        modelled = point.S is not None and self.weighting is None
        if modelled:
            weighted = inverse @ point.dS
            traces = np.trace(weighted, axis1=1, axis2=2)
            curvature = 0.5 * np.einsum("aij,bji->ab", weighted, weighted)
            scale = self.scales[:dense]
            information[:dense, :dense] += self.samples * curvature * np.outer(scale, scale)
            moment = np.sum([inverse @ errors.T @ errors for errors in residuals], axis=0) @ inverse
            bending = np.einsum("ij,aij->a", moment, point.dS)
            gradient[:dense] += 0.5 * (self.samples * traces - bending) * scale
        for index, errors in enumerate(residuals):
            predictor, start = self.parametrisation.predictor(point, self.local(vector, index))
            about = self.parametrisation.sensitivity(point, self.local(vector, index))
            _, slopes, _ = with_sensitivities(predictor, about, self._u[index], self._y[index], start)
            place = self.places(index)
            slopes *= self.scales[place]
            p, n, count = slopes.shape
            white = (whitening @ slopes.reshape(p, n * count)).reshape(p * n, count)
            information[np.ix_(place, place)] += white.T @ white
            bent = (whitening @ errors.T).reshape(p * n)
            gradient[place] += white.T @ bent
            if scores:
                score = np.zeros((n, self.size))
                score[:, place] = (bent[:, None] * white).reshape(p, n, count).sum(axis=0)
                if modelled:
                    side = errors @ inverse
                    bending = np.einsum("ki,aij,kj->ka", side, point.dS, side, optimize=True)
                    score[:, :dense] += 0.5 * (traces - bending) * self.scales[:dense]
                found.append(score)
        return Evaluation(cost, gradient, information, tuple(found), residuals, weighting)

    def _cost(self, point: Point, residuals: tuple[Array, ...]) -> tuple[float, Array]:
        moment = np.sum([errors.T @ errors for errors in residuals], axis=0)
        weighting = self.weighting if self.weighting is not None else point.S
        if weighting is None:
            own = moment / self.samples
            sign, logarithm = np.linalg.slogdet(own)
            return (0.5 * self.samples * float(logarithm) if sign > 0 else float("inf")), own
        sign, logarithm = np.linalg.slogdet(weighting)
        if sign <= 0:
            return float("inf"), weighting
        quadratic = float(np.trace(np.linalg.solve(weighting, moment)))
        return 0.5 * quadratic + 0.5 * self.samples * float(logarithm), weighting
