"""Servo rotor (stabilizer bar): two paddles flapping slowly above the main rotor (source eq. 2.45-2.47)."""

from __future__ import annotations

from heli_bench_sim.levers import lever_gains
from heli_bench_sim.parameters import Constants
from heli_bench_sim.standstill import reciprocal_speed
from heli_common.compiled import equation


@equation
def flapping_rates(
    a_1p: float,
    b_1p: float,
    b_1s: float,
    a_1s: float,
    theta_0: float,
    omega: float,
    q: float,
    p: float,
    c: Constants,
) -> tuple[float, float]:
    """Rates of the servo rotor's tilt back and right relative to the body, (a_1p', b_1p') [rad/s].

    Args:
        a_1p: tilt back [rad].
        b_1p: tilt right [rad].
        b_1s: longitudinal cyclic [rad].
        a_1s: lateral cyclic [rad].
        theta_0: collective [rad].
        omega: rotor speed [rad/s].
        q: pitch rate [rad/s].
        p: roll rate [rad/s].
        c: constants of the helicopter.
    """
    per_speed = reciprocal_speed(omega, c.fade_speed)
    _, _, plate_to_bar = lever_gains(theta_0, c.levers)
    k = c.bar_rate * abs(omega)
    return (
        k * (-a_1p + plate_to_bar * b_1s + p * per_speed) - q,
        k * (-b_1p + plate_to_bar * a_1s - q * per_speed) - p,
    )
