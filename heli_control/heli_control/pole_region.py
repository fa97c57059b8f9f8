"""Controller poles too fast for the sampling rate, and their removal.

The fast modes of a nearly optimal controller act as a gain over the range of the loop. They are split off by
an ordered Schur form and replaced by their gain at rest (modal residualisation), which keeps K(0).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import schur, solve_sylvester

from heli_common.timing import CONTROL_PERIOD
from heli_control.realisation import Realisation

NYQUIST = float(np.pi) / CONTROL_PERIOD
"""Half the sampling frequency [rad/s]: a faster pole cannot be told from a gain at 100 Hz."""


def fastest(system: Realisation) -> float:
    """Largest absolute value of a pole [rad/s]; zero without states."""
    return float(np.abs(np.linalg.eigvals(system.A)).max(initial=0.0))


def without_fast_modes(system: Realisation, limit: float) -> Realisation:
    """The system with its modes beyond `limit` at rest.

    Args:
        system: n states.
        limit: largest absolute value of a pole to keep [rad/s].

    Returns:
        the slow modes, and the gain of the fast ones at s = 0 in D.

    Raises:
        ValueError: a limit that is not positive.
    """
    if not limit > 0.0:
        raise ValueError(f"limit {limit} rad/s; allowed: above 0")
    form, basis, slow = schur(system.A, sort=lambda real, imaginary: np.hypot(real, imaginary) <= limit)
    a, coupling, fast = form[:slow, :slow], form[:slow, slow:], form[slow:, slow:]
    if not len(fast):
        return system
    # x_slow = z + T x_fast takes the coupling away: A T - T A_fast = -coupling
    turn = solve_sylvester(a, -fast, -coupling) if slow else np.zeros((0, len(fast)))
    b, c = basis.T @ system.B, system.C @ basis
    fast_b, fast_c = b[slow:], c[:, slow:] + c[:, :slow] @ turn
    return Realisation(
        a, b[:slow] - turn @ fast_b, c[:, :slow], system.D - fast_c @ np.linalg.solve(fast, fast_b)
    )
