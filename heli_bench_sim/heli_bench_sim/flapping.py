"""Main rotor flapping: quasi-static tilt of the disc (source eq. 2.38-2.44, B.16-B.22)."""

from __future__ import annotations

from heli_bench_sim.levers import cyclic_after_slack, lever_gains
from heli_bench_sim.parameters import Constants
from heli_bench_sim.standstill import reciprocal_speed
from heli_common.compiled import equation


@equation
def disc_tilt(
    a_1p: float,
    b_1p: float,
    b_1s: float,
    a_1s: float,
    theta_0: float,
    omega: float,
    v_i: float,
    u_a: float,
    v_a: float,
    q: float,
    p: float,
    c: Constants,
) -> tuple[float, float]:
    """Tilt of the disc back and to the right, (a_1, b_1) [rad].

    Swash plate and servo rotor set the cyclic pitch (source eq. 2.44); air speed and body rates add to it
    (source eq. 2.41). With a hinge offset the blade lags by less than 90 deg: the phase xi turns the tilt.

    Args:
        a_1p: servo rotor flapping back [rad].
        b_1p: servo rotor flapping right [rad].
        b_1s: longitudinal cyclic [rad].
        a_1s: lateral cyclic [rad].
        theta_0: collective [rad].
        omega: rotor speed [rad/s].
        v_i: induced velocity [m/s].
        u_a: velocity forward relative to the air, body frame [m/s].
        v_a: velocity right relative to the air [m/s].
        q: pitch rate [rad/s].
        p: roll rate [rad/s].
        c: constants of the helicopter.
    """
    per_speed = reciprocal_speed(omega, c.fade_speed)
    inflow_ratio = v_i * per_speed / c.radius
    per_air_speed = c.speed_flapping * (8.0 / 3.0 * theta_0 - 2.0 * inflow_ratio) * per_speed / c.radius
    tau = c.flapping_damping * per_speed
    bar_to_blade, plate_to_blade, _ = lever_gains(theta_0, c.levers)
    pitch_back, pitch_right = cyclic_after_slack(
        bar_to_blade * a_1p + plate_to_blade * b_1s,
        bar_to_blade * b_1p + plate_to_blade * a_1s,
        c.levers.slack,
    )
    back = pitch_back + per_air_speed * u_a - tau * q + p * per_speed
    right = pitch_right - per_air_speed * v_a - tau * p - q * per_speed
    a_1 = c.phase_cos * (c.phase_cos * back + c.phase_sin * right)
    b_1 = c.phase_cos * (c.phase_cos * right - c.phase_sin * back)
    return a_1, b_1


@equation
def hub_stiffness(omega: float, c: Constants) -> float:
    """Moment of the hub per angle of the disc, K_b [N m/rad]: centrifugal force on two blades' hinges.

    Args:
        omega: rotor speed [rad/s].
        c: constants of the helicopter.
    """
    return c.hub_stiffness * omega * omega
