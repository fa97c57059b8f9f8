"""Tail rotor: thrust to the right and torque on its own shaft (source eq. B.27, B.34; spec 1.3)."""

from __future__ import annotations

from heli_bench_sim.parameters import Constants
from heli_bench_sim.standstill import reciprocal_speed
from heli_common.compiled import equation


@equation
def thrust(theta_t: float, omega: float, v_t: float, v_a: float, r: float, c: Constants) -> float:
    """Tail thrust T_t [N], positive along body y.

    The tail hub moves to the right with v_a + r x_t; motion against its thrust raises the thrust. The source
    leaves the side velocity out (s_t = 0).

    Args:
        theta_t: tail collective [rad].
        omega: main rotor speed [rad/s].
        v_t: induced velocity of the tail rotor [m/s].
        v_a: velocity right relative to the air, body frame [m/s].
        r: yaw rate [rad/s].
        c: constants of the helicopter.
    """
    omega_t = c.tail_gear * omega
    inflow = c.tail_side_flow * v_a + r * c.tail_x
    return (
        c.tail_lift_per_angle * omega_t * (omega_t * theta_t - c.tail_inflow_gradient * v_t)
        - c.tail_lift_per_inflow * inflow * omega_t
    )


@equation
def torque(thrust: float, theta_t: float, omega: float, v_t: float, c: Constants) -> float:
    """Torque Q_t [N m] that the air takes from the tail shaft; it pitches the body up.

    Args:
        thrust: tail thrust [N].
        theta_t: tail collective [rad].
        omega: main rotor speed [rad/s].
        v_t: induced velocity of the tail rotor [m/s].
        c: constants of the helicopter.
    """
    omega_t = c.tail_gear * omega
    drag = c.drag_constant + c.drag_square * theta_t * theta_t
    per_speed = reciprocal_speed(omega, c.fade_speed) / c.tail_gear
    return c.tail_drag_moment * drag * omega_t * abs(omega_t) + thrust * v_t * per_speed
