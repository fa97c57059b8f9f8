"""Main rotor: thrust and torque from blade elements (source sec. 2.3.2, spec 1.3).

Linear inflow: the induced velocity grows with the radius and is V_i at the disc mean (source eq. 2.28), so
the section angle does not depend on the radius but for the vertical speed. Beyond the stall angle the lift
slope is zero (design choice): the thrust stops rising with the angle, the drag goes on.
"""

from __future__ import annotations

from heli_bench_sim.parameters import Constants
from heli_bench_sim.standstill import reciprocal_speed
from heli_common.compiled import equation

REFERENCE_SECTION = 0.75
"""Share of the radius at which the section angle is taken for stall."""


@equation
def section_angle(theta_0: float, omega: float, v_i: float, w_a: float, c: Constants) -> float:
    """Angle of attack at 0.75 R [rad] from collective [rad], rotor speed, inflow and vertical air speed.

    Args:
        theta_0: collective [rad].
        omega: rotor speed [rad/s].
        v_i: induced velocity [m/s].
        w_a: velocity down relative to the air, body frame [m/s].
        c: constants of the helicopter.
    """
    per_speed = reciprocal_speed(omega, c.fade_speed)
    return theta_0 + per_speed * (w_a / (REFERENCE_SECTION * c.radius) - c.inflow_gradient * v_i)


@equation
def lost_angle(angle: float, c: Constants) -> float:
    """Part of the section angle that gives no more lift because the blade is stalled [rad].

    Zero below the knee, angle - stall angle above it, a parabola in between; odd in the angle.
    """
    size = abs(angle)
    beyond = size - c.stall_angle
    if beyond <= -c.stall_rounding:
        return 0.0
    if beyond < c.stall_rounding:
        beyond = (beyond + c.stall_rounding) ** 2 / (4.0 * c.stall_rounding)
    return beyond if angle > 0.0 else -beyond


@equation
def thrust(
    theta_0: float, omega: float, v_i: float, u_a: float, v_a: float, w_a: float, c: Constants
) -> float:
    """Thrust T [N] along the disc normal (source eq. 2.33, B.26).

    Args:
        theta_0: collective [rad].
        omega: rotor speed [rad/s].
        v_i: induced velocity [m/s].
        u_a: velocity forward relative to the air, body frame [m/s].
        v_a: velocity right relative to the air [m/s].
        w_a: velocity down relative to the air [m/s].
        c: constants of the helicopter.
    """
    lost = lost_angle(section_angle(theta_0, omega, v_i, w_a, c), c)
    return (
        c.lift_per_angle * omega * (omega * (theta_0 - lost) - c.inflow_gradient * v_i)
        + c.lift_per_speed_squared * theta_0 * (u_a * u_a + v_a * v_a)
        + c.lift_per_inflow * w_a * omega
    )


@equation
def torque(thrust: float, theta_0: float, omega: float, v_i: float, w_a: float, c: Constants) -> float:
    """Torque Q [N m] that the air takes from the shaft: profile drag and the power of the thrust.

    Args:
        thrust: main rotor thrust [N].
        theta_0: collective [rad].
        omega: rotor speed [rad/s].
        v_i: induced velocity [m/s].
        w_a: velocity down relative to the air, body frame [m/s].
        c: constants of the helicopter.
    """
    per_speed = reciprocal_speed(omega, c.fade_speed)
    alpha = theta_0 - 1.5 * v_i * per_speed / c.radius
    drag = c.drag_constant + c.drag_linear * abs(alpha) + c.drag_square * alpha * alpha
    # the drag opposes the motion, so that a rotor pushed backwards is braked too
    return c.drag_moment * drag * omega * abs(omega) + thrust * (v_i - w_a) * per_speed
