"""Frequency response of a loop opened at the plant input: sensitivity peaks and cross-overs (spec 3.6).

L_u = K G,   S_u = (I + L_u)^-1,   T_u = L_u (I + L_u)^-1
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.linear_model import StateSpace

Array = NDArray[np.float64]
Response = NDArray[np.complex128]


def frequency_response(system: StateSpace, omega: Array, period: float | None = None) -> Response:
    """Transfer matrix on the imaginary axis, or on the unit circle for a sampled system.

    Args:
        system: with m inputs and p outputs.
        omega: frequencies [rad/s], shape (k,).
        period: sample time [s]; None for a continuous system.

    Returns:
        shape (k, p, m).
    """
    s = 1j * omega if period is None else np.exp(1j * omega * period)
    identity = np.eye(len(system.states))
    inverse = np.linalg.solve(
        s[:, None, None] * identity - system.A, np.broadcast_to(system.B, (omega.size, *system.B.shape))
    )
    return np.asarray(system.C @ inverse + system.D, dtype=np.complex128)


def sensitivity_peaks(loop: Response) -> tuple[float, float]:
    """Largest singular values of S and T over the frequencies of a square loop.

    Args:
        loop: L for negative feedback, shape (k, m, m).

    Returns:
        |S| and |T| [dB].
    """
    identity = np.eye(loop.shape[1])
    sensitivity = np.asarray(np.linalg.inv(identity + loop), dtype=np.complex128)
    return _peak(sensitivity), _peak(np.matmul(loop, sensitivity))


def crossovers(response: Response | Array, omega: Array) -> list[float]:
    """Frequencies at which the magnitude of a scalar response crosses 0 dB [rad/s], ascending.

    Args:
        response: shape (k,).
        omega: shape (k,), ascending [rad/s].
    """
    level = np.log(np.abs(response))
    found = []
    for index in np.flatnonzero(np.sign(level[:-1]) * np.sign(level[1:]) < 0.0):
        share = level[index] / (level[index] - level[index + 1])
        found.append(float(omega[index] * (omega[index + 1] / omega[index]) ** share))
    return found


def _peak(response: Response) -> float:
    return float(20.0 * np.log10(np.linalg.svd(response, compute_uv=False).max()))
