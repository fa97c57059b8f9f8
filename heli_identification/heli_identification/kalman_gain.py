"""The steady-state Kalman gain of a sampled model and its derivatives.

    P = A P A' + Q - K S K',   S = C P C' + R,   K = A P C' S^-1
    dP = (A - K C) dP (A - K C)' + dA P (A - K C)' + (A - K C) P dA' + dQ + K dR K'
    dS = C dP C' + dR,         dK = (dA P C' + A dP C' - K dS) S^-1

P is stationary with respect to K, so dK does not appear in dP (L. Ljung, 1999, sec. 4.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve, solve_discrete_are

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class KalmanGain:
    """Gain and covariances in the steady state.

    Attributes:
        K: of the one-step predictor, shape (n, p).
        S: covariance of the innovations, shape (p, p).
        P: covariance of the predicted state, shape (n, n).
    """

    K: Array
    S: Array
    P: Array


def kalman_gain(a: Array, c: Array, q: Array, r: Array) -> KalmanGain:
    """Steady-state gain.

    Args:
        a: sampled, shape (n, n).
        c: shape (p, n).
        q: covariance of the process noise per step, shape (n, n).
        r: covariance of the measurement noise, shape (p, p).

    Raises:
        ValueError: there is no stabilising solution.
    """
    try:
        p = solve_discrete_are(a.T, c.T, q, r)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise ValueError(f"no steady-state Kalman gain: {error}") from None
    s = c @ p @ c.T + r
    return KalmanGain(np.linalg.solve(s, c @ p @ a.T).T, s, p)


def gain_derivatives(
    a: Array, c: Array, gain: KalmanGain, da: Array, dq: Array, dr: Array
) -> tuple[Array, Array]:
    """dK, shape (r, n, p), and dS, shape (r, p, p), for r simultaneous directions.

    Args:
        a: sampled, shape (n, n).
        c: shape (p, n).
        gain: from `kalman_gain`.
        da: shape (r, n, n).
        dq: shape (r, n, n).
        dr: shape (r, p, p).
    """
    k, s, p = gain.K, gain.S, gain.P
    n = len(a)
    contracted = a - k @ c
    forcing = da @ p @ contracted.T
    forcing = forcing + forcing.transpose(0, 2, 1) + dq + k @ dr @ k.T
    lyapunov = lu_factor(np.eye(n * n) - np.kron(contracted, contracted))
    dp = lu_solve(lyapunov, forcing.reshape(len(da), n * n).T).T.reshape(-1, n, n)
    ds = c @ dp @ c.T + dr
    right = da @ p @ c.T + a @ dp @ c.T - k @ ds
    dk = np.linalg.solve(s, right.transpose(0, 2, 1)).transpose(0, 2, 1)
    return dk, ds
