"""From a vector of unknowns to the predictor: coefficients, noise, initial states and offsets.

The common unknowns are the free coefficients and the noise model; each record adds its initial state and, if
wanted, a constant on the derivative of every measured state, which takes up what is wrong with the operating
point.

Noise models (source eq. 2.67; L. Ljung, 1999, sec. 4.3):
- output error: K = 0, all disturbances are in the measurement;
- free gain: every entry of K is an unknown;
- Kalman: variances of the process noise on the states the coefficients act on and of the measurement noise
  are the unknowns (their logarithms), K and the innovations' covariance follow from the Riccati equation.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from heli_identification.helicopter_structures import SCALES
from heli_identification.innovations import Predictor, Sensitivity
from heli_identification.kalman_gain import gain_derivatives, kalman_gain
from heli_identification.sampling import Hold, Sampled, sample
from heli_identification.structures import Structure

Array = NDArray[np.float64]

LOG_LIMIT = 40.0
"""Bound on |log variance|, so that a variance may vanish without an overflow."""


class Noise(Enum):
    """How disturbances are modelled."""

    OUTPUT_ERROR = "output_error"
    FREE_GAIN = "free_gain"
    KALMAN = "kalman"


@dataclass(frozen=True, eq=False)
class Point:
    """Everything the predictor needs at one vector of unknowns.

    Attributes:
        sampled: matrices and their derivatives.
        K: shape (n, p).
        S: covariance of the innovations by the noise model, shape (p, p); None if the residuals decide.
        dK: shape (dense unknowns, n, p). dS: shape (dense unknowns, p, p).
    """

    sampled: Sampled
    K: Array
    S: Array | None
    dK: Array
    dS: Array


class Parametrisation:
    """Names, scales and places of the unknowns.

    Args:
        structure: whose free parameters are estimated.
        noise: model of the disturbances.
        period: sample time [s].
        hold: of the input.
        offsets: whether each record has a constant on the derivatives of the measured states.

    Attributes:
        common: number of unknowns all records share.
        local: number of those each record has for itself.
        dense: number of common unknowns that act through whole matrices.
        n: number of states of the predictor.
        scales: shape (common + local,).
    """

    def __init__(
        self, structure: Structure, noise: Noise, period: float, hold: Hold, *, offsets: bool = True
    ) -> None:
        self.structure, self.noise, self.period, self.hold = structure, noise, period, hold
        self.seen = np.array([structure.states.index(name) for name in structure.outputs], dtype=np.int64)
        self.free = structure.index(structure.free_names)
        self.disturbed = disturbed_states(structure)
        self.shifted = self.seen if offsets else self.seen[:0]
        self.n = n = len(structure.states)
        p = len(structure.outputs)
        state_scales = np.array([SCALES.get(name, 1.0) for name in structure.states])
        output_scales = state_scales[self.seen]
        scales = [structure.scales[self.free]]
        self.dense = len(self.free)
        if noise is Noise.KALMAN:
            scales.append(np.ones(len(self.disturbed) + p))
            self.dense += len(self.disturbed) + p
        elif noise is Noise.FREE_GAIN:
            scales.append((state_scales[:, None] / output_scales).ravel())
        self.common = sum(len(part) for part in scales)
        self.local = n + len(self.shifted)
        self.scales = np.concatenate((*scales, state_scales, state_scales[self.shifted]))

    @property
    def noise_names(self) -> tuple[str, ...]:
        """Names of the unknowns of the noise model."""
        states, outputs = self.structure.states, self.structure.outputs
        if self.noise is Noise.KALMAN:
            process = [f"log_q_{states[index]}" for index in self.disturbed]
            return (*process, *(f"log_r_{name}" for name in outputs))
        if self.noise is Noise.FREE_GAIN:
            return tuple(f"K_{state}_{output}" for state in states for output in outputs)
        return ()

    def values(self, common: Array) -> Array:
        """All parameters of the structure at common unknowns, shape (r,)."""
        values = self.structure.values.copy()
        values[self.free] = common[: len(self.free)]
        return values

    def point(self, common: Array) -> Point:
        """Sampled model, gain and derivatives at common unknowns, shape (common,), not scaled.

        Raises:
            ValueError: the noise model has no steady-state gain here.
        """
        sampled = sample(self.structure, self.values(common), self.period, self.hold)
        n, p = len(self.structure.states), len(self.seen)
        rest = common[len(self.free) :]
        dk: Array = np.zeros((self.dense, n, p))
        ds: Array = np.zeros((self.dense, p, p))
        if self.noise is Noise.OUTPUT_ERROR:
            return Point(sampled, np.zeros((n, p)), None, dk, ds)
        if self.noise is Noise.FREE_GAIN:
            return Point(sampled, rest.reshape(n, p).copy(), None, dk, ds)
        variances = np.exp(np.clip(rest, -LOG_LIMIT, LOG_LIMIT))
        count = len(self.disturbed)
        q, r = np.zeros((n, n)), np.diag(variances[count:])
        q[self.disturbed, self.disturbed] = variances[:count]
        c = self.structure.output_matrix()
        gain = kalman_gain(sampled.A, c, q, r)
        da = np.zeros((self.dense, n, n))
        da[: len(self.free)] = sampled.dA[self.free]
        dq, dr = np.zeros((self.dense, n, n)), np.zeros((self.dense, p, p))
        for place, state in enumerate(self.disturbed):
            dq[len(self.free) + place, state, state] = variances[place]
        for place in range(p):
            dr[len(self.free) + count + place, place, place] = variances[count + place]
        dk, ds = gain_derivatives(sampled.A, c, gain, da, dq, dr)
        return Point(sampled, gain.K, gain.S, dk, ds)

    def predictor(self, point: Point, local: Array) -> tuple[Predictor, Array]:
        """The predictor of one record and its initial state, shape (n,)."""
        drift = point.sampled.N[:, self.shifted] @ local[self.n :]
        predictor = Predictor(point.sampled.A, point.sampled.B, point.K, drift, self.seen)
        return predictor, local[: self.n].copy()

    def sensitivity(self, point: Point, local: Array) -> Sensitivity:
        """Derivatives with respect to common and local unknowns, not scaled."""
        sampled, n, p = point.sampled, self.n, len(self.seen)
        m, free, total = sampled.B.shape[1], len(self.free), self.common + self.local
        dense = np.zeros((n, n + m + p + 1, self.dense))
        dense[:, :n, :free] = sampled.dA[self.free].transpose(1, 2, 0)
        dense[:, n : n + m, :free] = sampled.dB[self.free].transpose(1, 2, 0)
        dense[:, n + m : n + m + p, :] = point.dK.transpose(1, 2, 0)
        dense[:, -1, :free] = (sampled.dN[self.free][:, :, self.shifted] @ local[n:]).T
        entries: list[tuple[int, int, int, float]] = []
        if self.noise is Noise.FREE_GAIN:
            for place in range(n * p):
                entries.append((free + place, place // p, n + m + place % p, 1.0))
        for place, state in enumerate(self.shifted):
            for row in range(n):
                entries.append((self.common + n + place, row, n + m + p, float(sampled.N[row, state])))
        unknown, row_, column = (np.array([e[i] for e in entries], dtype=np.int64) for i in range(3))
        start = np.zeros((n, total))
        start[:, self.common : self.common + n] = np.eye(n)
        return Sensitivity(dense, unknown, row_, column, np.array([e[3] for e in entries]), start)


def disturbed_states(structure: Structure) -> list[int]:
    """Measured states whose equation holds coefficients: gusts and model errors act there."""
    rows = {term.row for term in structure.terms if term.powers}
    return [structure.states.index(name) for name in structure.outputs if name in rows]
