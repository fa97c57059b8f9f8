"""Azimuth of the main rotor, which vibration and Hall sensor take their phase from.

It is counted from the nose in the sense in which the rotor turns, anticlockwise seen from above (spec 1.1).
"""

from __future__ import annotations

import math

from heli_common.compiled import compiled

TURN = 2.0 * math.pi


@compiled
def turned(azimuth: float, omega_before: float, omega_after: float, period: float) -> float:
    """Azimuth [rad] after a period at the mean of two speeds, in [0, 2 pi).

    Exact for a speed that changes linearly.

    Args:
        azimuth: at the beginning [rad].
        omega_before: rotor speed at the beginning [rad/s].
        omega_after: at the end [rad/s].
        period: in between [s].
    """
    after = (azimuth + 0.5 * (omega_before + omega_after) * period) % TURN
    # the rest of a tiny negative number is rounded up to a whole turn
    return 0.0 if after >= TURN else after
