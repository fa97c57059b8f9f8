"""The terms in 1/Omega near standstill: run-up from rest must have no singularity (spec 1.3)."""

from __future__ import annotations

from heli_common.compiled import equation


@equation
def reciprocal_speed(omega: float, fade_speed: float) -> float:
    """1/Omega above the fade speed, going smoothly (twice differentiable) to 0 at standstill.

    Args:
        omega: rotor speed [rad/s].
        fade_speed: speed below which the terms in 1/Omega fade [rad/s], > 0.

    Returns:
        1/Omega [s/rad] from the fade speed on, exactly; 0 for a rotor at rest.
    """
    if omega >= fade_speed:
        return 1.0 / omega
    if omega <= 0.0:
        return 0.0
    # fifth-order smooth step s^3 (6 s^2 - 15 s + 10) over Omega, with one Omega cancelled
    share = omega / fade_speed
    return share * share * (share * (6.0 * share - 15.0) + 10.0) / fade_speed
