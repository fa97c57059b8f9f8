"""H force in the rotor's torque: what speed through the air adds to Q (source sec. 2.3.2, eq. B.33).

The H force lies in the disc, against the speed s in its plane. The source leaves it out of the forces and
needs it for the torque only. Its eq. B.33 is too damaged in the scan to be copied. What can be read are the
hover torque, a profile drag of the same three coefficients with u^2 + v^2 over R^2 - r_0^2, and a product of
the collective with u over 3 Omega, which fits the work of the tilted thrust. Here these terms are rebuilt
from the blade elements of the thrust (eq. 2.28 to 2.33), to second order in the speed. With the flow down
through the disc W = k_v V_i r - w_a and S_n = (R^n - r_0^n) / n:

    F_1 = k_v V_i S_2 - w_a S_1,  F_2 = k_v V_i S_3 - w_a S_2     integrals of W and r W
    t   = -(2 Omega theta_0 S_3 - F_2) / (Omega^2 S_4)            cyclic pitch per speed, relative to the
                                                                  disc, that leaves no flapping moment
    h   = 2 eta rho c c_d Omega S_2 + eta rho c a (theta_0 F_1 + t Omega F_2) / 2
    H   = h s                                                     profile drag and tilted lift
    dQ  = (3 eta rho c c_d Omega S_2 s^2 - H s - T (a_1 u_a - b_1 v_a)) / Omega

The last line is a balance of powers: the blades lose more to drag, and what the rotor does along its path
comes from the shaft. The factor 2 eta of the drag is that of Q in `rotor`. Coning and the Y force are left
out. Nothing changes in hover: dQ = 0 for s = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from heli_bench_sim.standstill import reciprocal_speed
from heli_common.compiled import equation
from heli_common.quantities import quantity

if TYPE_CHECKING:  # the helicopter's constants hold those of this module
    from heli_bench_sim.parameters import HelicopterParameters


@dataclass(frozen=True)
class HForceParameters:
    """Whether the rotor's torque knows the H force."""

    active: float = quantity(0.0, "-", "D", "switch: H force in the rotor's torque, 0 no, 1 yes", 0.0, 1.0)


class HForceConstants(NamedTuple):
    """What the compiled H force needs; every field a float, SI."""

    active: float
    lift: float
    """eta rho c a, both blades [kg/m2]"""
    drag: float
    """2 eta rho c, both blades [kg/m2]"""
    drag_constant: float
    drag_linear: float
    drag_square: float
    inflow_gradient: float
    radius: float
    fade_speed: float
    first: float
    """S_1 [m]"""
    second: float
    """S_2 [m2]"""
    third: float
    """S_3 [m3]"""
    fourth: float
    """S_4 [m4]"""


def h_force_constants(parameters: HForceParameters, helicopter: HelicopterParameters) -> HForceConstants:
    """Constants of the compiled H force.

    Args:
        parameters: the switch.
        helicopter: whose main rotor it is.
    """
    h = helicopter
    blade = h.thrust_efficiency * h.air_density * h.chord
    return HForceConstants(
        active=parameters.active,
        lift=blade * h.lift_slope,
        drag=2.0 * blade,
        drag_constant=h.drag_constant,
        drag_linear=h.drag_linear,
        drag_square=h.drag_square,
        inflow_gradient=1.5 * h.radius**2 / (h.radius**3 - h.cutout**3),  # source eq. 2.28
        radius=h.radius,
        fade_speed=h.fade_fraction * h.rotor_speed,
        first=h.radius - h.cutout,
        second=(h.radius**2 - h.cutout**2) / 2.0,
        third=(h.radius**3 - h.cutout**3) / 3.0,
        fourth=(h.radius**4 - h.cutout**4) / 4.0,
    )


@equation
def section_drag(theta_0: float, omega: float, v_i: float, h: HForceConstants) -> float:
    """Mean drag coefficient of the blade sections c_d [-], as in `rotor.torque`.

    Args:
        theta_0: collective [rad].
        omega: rotor speed [rad/s].
        v_i: induced velocity [m/s].
        h: constants of the H force.
    """
    alpha = theta_0 - 1.5 * v_i * reciprocal_speed(omega, h.fade_speed) / h.radius
    return h.drag_constant + h.drag_linear * abs(alpha) + h.drag_square * alpha * alpha


@equation
def h_force_per_speed(
    theta_0: float, omega: float, v_i: float, w_a: float, c_d: float, h: HForceConstants
) -> float:
    """H force per speed in the plane of the disc [N s/m], against that speed; not switched.

    Args:
        theta_0: collective [rad].
        omega: rotor speed [rad/s].
        v_i: induced velocity [m/s].
        w_a: velocity down relative to the air [m/s].
        c_d: drag coefficient of the sections [-].
        h: constants of the H force.
    """
    per_speed = reciprocal_speed(omega, h.fade_speed)
    inflow = h.inflow_gradient * v_i
    flow = inflow * h.second - w_a * h.first
    flow_moment = inflow * h.third - w_a * h.second
    # t Omega; with omega per_speed = 1 in flight and 0 at rest nothing blows up in between
    cyclic = -(2.0 * omega * theta_0 * h.third - flow_moment) * per_speed / h.fourth
    return h.drag * c_d * omega * h.second + 0.5 * h.lift * (theta_0 * flow + cyclic * flow_moment)


@equation
def h_force_torque(
    thrust: float,
    theta_0: float,
    omega: float,
    v_i: float,
    u_a: float,
    v_a: float,
    w_a: float,
    a_1: float,
    b_1: float,
    h: HForceConstants,
) -> float:
    """Torque dQ [N m] that the air takes from the shaft on top of `rotor.torque`; 0 if switched off.

    Args:
        thrust: main rotor thrust [N].
        theta_0: collective [rad].
        omega: rotor speed [rad/s].
        v_i: induced velocity [m/s].
        u_a: velocity forward relative to the air, body frame [m/s].
        v_a: velocity right relative to the air [m/s].
        w_a: velocity down relative to the air [m/s].
        a_1: tilt of the disc back [rad].
        b_1: tilt of the disc right [rad].
        h: constants of the H force.
    """
    back = a_1 * u_a - b_1 * v_a
    square = u_a * u_a + v_a * v_a
    c_d = section_drag(theta_0, omega, v_i, h)
    per_speed = h_force_per_speed(theta_0, omega, v_i, w_a, c_d, h)
    power = (1.5 * h.drag * c_d * omega * h.second - per_speed) * square - thrust * back
    return h.active * power * reciprocal_speed(omega, h.fade_speed)
