"""The one-step predictor and its sensitivities, in one compiled pass over the data.

    x(k+1) = A x(k) + B u(k) + d + K e(k)        e(k) = y(k) - C x(k)
    X(k+1) = (A - K C) X(k) + dA x(k) + dB u(k) + dd + dK e(k),   de/dtheta = -C X

(source eq. 2.67, 2.75; L. Ljung, *System Identification*, 1999, sec. 10.3). K = 0 is output error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

DIVERGED = 1e12
"""A residual beyond this ends a pass: the predictor is unstable."""


@dataclass(frozen=True, eq=False)
class Predictor:
    """Matrices of the predictor: n states, m input columns, p outputs.

    Attributes:
        A: shape (n, n). B: shape (n, m). K: shape (n, p).
        drift: constant added in every step, shape (n,).
        seen: which states the outputs are, shape (p,).
    """

    A: Array
    B: Array
    K: Array
    drift: Array
    seen: Indices

    def residuals(self, u: Array, y: Array, start: Array) -> tuple[Array, bool]:
        """Prediction errors, shape (N, p), from initial state, shape (n,); False if they diverged."""
        out = np.zeros_like(y)
        fine = _residuals(self.A, self.B, self.K, self.drift, self.seen, u, y, start, out)
        return out, bool(fine)


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What every unknown does to the predictor; P unknowns, the first of which are dense.

    Attributes:
        dense: derivative of [A B K d] with respect to the dense unknowns, shape (n, n + m + p + 1, P1).
        unknown: of a single entry, its column of the sensitivity, shape (s,).
        row: of a single entry, shape (s,).
        column: of a single entry in [A B K d], shape (s,).
        value: of a single entry, shape (s,).
        start: derivative of the initial state, shape (n, P).
    """

    dense: Array
    unknown: Indices
    row: Indices
    column: Indices
    value: Array
    start: Array


def with_sensitivities(
    predictor: Predictor, about: Sensitivity, u: Array, y: Array, start: Array
) -> tuple[Array, Array, bool]:
    """Prediction errors and their derivatives.

    Args:
        predictor: matrices.
        about: their derivatives.
        u: shape (N, m).
        y: shape (N, p).
        start: initial state, shape (n,).

    Returns:
        errors, shape (N, p); derivatives, shape (p, N, P); False if they diverged.
    """
    errors = np.zeros_like(y)
    slopes = np.zeros((y.shape[1], y.shape[0], about.start.shape[1]))
    contracted = predictor.A.copy()
    contracted[:, predictor.seen] -= predictor.K
    fine = _sensitivities(
        predictor.A,
        contracted,
        predictor.B,
        predictor.K,
        predictor.drift,
        predictor.seen,
        np.ascontiguousarray(about.dense),
        about.unknown,
        about.row,
        about.column,
        about.value,
        u,
        y,
        start,
        about.start,
        errors,
        slopes,
    )
    return errors, slopes, bool(fine)


@compiled
def _advance(
    a: Array, b: Array, k: Array, drift: Array, u: Array, e: Array, x: Array, following: Array
) -> None:
    for i in range(x.size):
        total = drift[i]
        for j in range(x.size):
            total += a[i, j] * x[j]
        for j in range(u.size):
            total += b[i, j] * u[j]
        for j in range(e.size):
            total += k[i, j] * e[j]
        following[i] = total
    for i in range(x.size):
        x[i] = following[i]


@compiled
def _residuals(
    a: Array,
    b: Array,
    k: Array,
    drift: Array,
    seen: Indices,
    u: Array,
    y: Array,
    start: Array,
    errors: Array,
) -> bool:
    x, following = start.copy(), np.zeros(start.size)
    for step in range(y.shape[0]):
        for output in range(seen.size):
            error = y[step, output] - x[seen[output]]
            if not abs(error) < DIVERGED:
                return False
            errors[step, output] = error
        _advance(a, b, k, drift, u[step], errors[step], x, following)
    return True


@compiled
def _sensitivities(
    a: Array,
    contracted: Array,
    b: Array,
    k: Array,
    drift: Array,
    seen: Indices,
    dense: Array,
    unknown: Indices,
    row: Indices,
    column: Indices,
    value: Array,
    u: Array,
    y: Array,
    start: Array,
    start_slope: Array,
    errors: Array,
    slopes: Array,
) -> bool:
    n, m, p = a.shape[0], b.shape[1], seen.size
    first = dense.shape[2]
    x, following = start.copy(), np.zeros(n)
    now, after = start_slope.copy(), np.zeros(start_slope.shape)
    z = np.zeros(n + m + p + 1)
    z[n + m + p] = 1.0
    for step in range(y.shape[0]):
        for output in range(p):
            error = y[step, output] - x[seen[output]]
            if not abs(error) < DIVERGED:
                return False
            errors[step, output] = error
            z[n + m + output] = error
            slopes[output, step, :] = -now[seen[output]]
        z[:n] = x
        z[n : n + m] = u[step]
        for i in range(n):
            line = after[i]
            line[:] = 0.0
            for j in range(n):
                factor = contracted[i, j]
                if factor != 0.0:
                    source = now[j]
                    for index in range(line.size):
                        line[index] += factor * source[index]
            for j in range(z.size):
                factor = z[j]
                forcing = dense[i, j]
                for index in range(first):
                    line[index] += factor * forcing[index]
        for entry in range(unknown.size):
            after[row[entry], unknown[entry]] += value[entry] * z[column[entry]]
        now, after = after, now
        _advance(a, b, k, drift, u[step], errors[step], x, following)
    return True
