"""Everything that is known of the helicopter, with unit, source and range (spec: provenance T, R, D).

The symbols of the source stand in front of each text. Two sets are shipped: `thesis()`, in which the tail
rotor does not feel side velocity (source sec. 2.3.2), and `physical_tail()`, in which it does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from heli_bench_sim.h_force import HForceConstants, HForceParameters, h_force_constants
from heli_bench_sim.levers import LeverConstants, LeverParameters, lever_constants
from heli_common.quantities import quantity
from heli_common.records import packed


@dataclass(frozen=True)
class HelicopterParameters:
    """The helicopter's parameters; the defaults are the thesis set."""

    # Mass and surroundings
    mass: float = quantity(7.3, "kg", "T", "m: helicopter 3.5 kg and frame 3.8 kg", 0.5, 50.0)
    gravity: float = quantity(9.81, "m/s^2", "T", "g: acceleration of gravity", 0.0, 20.0)
    air_density: float = quantity(1.2056, "kg/m^3", "R", "rho: density of the room's air", 0.1, 2.0)
    inertia_xx: float = quantity(0.0938, "kg m^2", "R", "I_xx: about the body's x axis", 0.001, 50.0)
    inertia_yy: float = quantity(0.2357, "kg m^2", "R", "I_yy: about the body's y axis", 0.001, 50.0)
    inertia_zz: float = quantity(0.4004, "kg m^2", "R", "I_zz: about the body's z axis", 0.001, 50.0)
    inertia_xz: float = quantity(0.0, "kg m^2", "R", "I_xz: product of inertia", -10.0, 10.0)
    drag_area: float = quantity(0.166, "m^2", "R", "C_D S: drag area of fuselage and frame", 0.0, 5.0)

    # Main rotor
    rotor_speed: float = quantity(163.363, "rad/s", "T", "Omega_0: rotor speed in flight", 10.0, 500.0)
    radius: float = quantity(0.725, "m", "T", "R: blade tip", 0.1, 5.0)
    cutout: float = quantity(0.12, "m", "T", "r_0: inner end of the blade", 0.0, 5.0)
    chord: float = quantity(0.062, "m", "T", "c: blade chord", 0.001, 1.0)
    lift_slope: float = quantity(5.0, "1/rad", "T", "a: lift slope of the section", 0.1, 7.0)
    thrust_efficiency: float = quantity(0.4899, "-", "R", "eta: correction of the thrust", 0.01, 2.0)
    drag_constant: float = quantity(0.01449, "-", "T", "c_d0: section drag at zero angle", 0.0, 1.0)
    drag_linear: float = quantity(0.08905, "1/rad", "T", "c_d1: section drag per angle", 0.0, 5.0)
    drag_square: float = quantity(0.39076, "1/rad^2", "T", "c_d2: section drag per angle squared", 0.0, 20.0)
    inflow_time: float = quantity(0.15, "s", "T", "tau_V: time constant of the inflow", 0.001, 5.0)
    stall_angle: float = quantity(math.radians(12.0), "rad", "D", "section angle of stall", 0.05, 1.0)
    stall_rounding: float = quantity(math.radians(1.0), "rad", "D", "half-width of the stall knee", 1e-4, 0.1)
    fade_fraction: float = quantity(0.2, "-", "D", "share of Omega_0 below which 1/Omega fades", 0.01, 0.9)

    # Flapping and hub
    blade_mass: float = quantity(0.211, "kg", "T", "m_b: mass of one blade", 0.001, 10.0)
    blade_inertia: float = quantity(0.033223, "kg m^2", "T", "I_b: one blade, half the rotor", 1e-5, 10.0)
    hinge_offset: float = quantity(0.041, "m", "T", "e: offset of the flapping hinge", 0.0, 0.5)
    speed_flapping: float = quantity(
        0.505, "-", "R", "k_f: share of the speed derivative of flapping", 0.0, 5.0
    )
    lock_factor: float = quantity(1.0679, "-", "R", "k_g: factor on the Lock number, cause unknown", 0.1, 5.0)
    hub_x: float = quantity(-0.0133, "m", "R", "x_M: hub ahead of the centre of gravity", -1.0, 1.0)
    hub_z: float = quantity(-0.20, "m", "D", "z_M: hub below the centre of gravity", -1.0, 1.0)

    # Servo rotor (stabilizer bar) and levers
    bar_radius: float = quantity(0.35, "m", "T", "R_p: tip of a paddle", 0.01, 2.0)
    bar_cutout: float = quantity(0.24, "m", "T", "r_p: inner end of a paddle", 0.0, 2.0)
    bar_chord: float = quantity(0.05, "m", "T", "c_p: chord of a paddle", 0.001, 1.0)
    bar_lift_slope: float = quantity(2.67, "1/rad", "T", "a_p: lift slope of a paddle", 0.1, 7.0)
    bar_inertia: float = quantity(0.001707, "kg m^2", "T", "I_p: servo rotor", 1e-6, 1.0)
    bar_to_blade: float = quantity(0.5469, "-", "R", "k_p2r: servo rotor to blade pitch", 0.0, 5.0)
    plate_to_blade: float = quantity(0.3431, "-", "R", "k_s2r: swash plate to blade pitch", 0.0, 5.0)
    plate_to_bar: float = quantity(1.4199, "-", "R", "k_s2p: swash plate to paddle pitch", 0.0, 5.0)

    # Tail rotor
    tail_radius: float = quantity(0.15, "m", "T", "R_t: blade tip", 0.01, 2.0)
    tail_cutout: float = quantity(0.06, "m", "T", "r_t: inner end of the blade", 0.0, 2.0)
    tail_chord: float = quantity(0.032, "m", "T", "c_t: blade chord", 0.001, 1.0)
    tail_lift_slope: float = quantity(5.0, "1/rad", "T", "a_t: lift slope", 0.1, 7.0)
    tail_efficiency: float = quantity(0.8671, "-", "R", "eta_t: correction of the thrust", 0.01, 2.0)
    tail_inflow_time: float = quantity(0.10, "s", "T", "tau_Vt: time constant of the inflow", 0.001, 5.0)
    tail_thrust: float = quantity(6.842, "N", "R", "T_t0: thrust that balances the torque", 0.1, 100.0)
    tail_x: float = quantity(-0.8612, "m", "R", "x_t: tail hub ahead of the centre of gravity", -5.0, 0.0)
    tail_z: float = quantity(-0.0210, "m", "R", "z_t: tail hub below the centre of gravity", -1.0, 1.0)
    tail_side_flow: float = quantity(0.0, "-", "D", "s_t: tail feels side velocity, 0 no, 1 yes", 0.0, 1.0)

    # Drive
    motor_gear: float = quantity(8.0, "-", "R", "n: motor turns per rotor turn", 0.1, 100.0)
    tail_gear: float = quantity(4.0, "-", "R", "n_t: tail turns per rotor turn", 0.1, 100.0)
    rotor_inertia: float = quantity(0.066446, "kg m^2", "T", "I_main: both blades", 1e-5, 10.0)
    tail_inertia: float = quantity(0.934e-4, "kg m^2", "T", "I_tail: tail rotor", 0.0, 1.0)
    motor_inertia: float = quantity(1.2e-4, "kg m^2", "D", "I_motor: armature", 0.0, 1.0)
    motor_time: float = quantity(0.0134, "s", "T", "T_a: time constant of the motor torque", 1e-4, 1.0)
    torque_constant: float = quantity(0.0150, "N m/A", "R", "K: torque per current", 1e-4, 1.0)
    armature_resistance: float = quantity(0.0467, "ohm", "R", "R_a: armature and leads", 1e-4, 10.0)
    supply_gain: float = quantity(4.0, "-", "T", "supply voltage per control voltage", 0.1, 100.0)
    supply_voltage: float = quantity(40.0, "V", "T", "highest supply voltage", 1.0, 1000.0)
    supply_current: float = quantity(60.0, "A", "T", "highest supply current", 1.0, 1000.0)


def thesis() -> HelicopterParameters:
    """The set that reproduces the source's tables with its own tail rotor (s_t = 0)."""
    return HelicopterParameters()


def physical_tail() -> HelicopterParameters:
    """The set whose tail rotor feels side velocity (s_t = 1), rebuilt on the same tables."""
    return HelicopterParameters(
        tail_side_flow=1.0,
        hub_x=-0.0137,
        tail_z=0.0253,
        tail_x=-0.8854,
        tail_efficiency=0.8174,
        speed_flapping=0.546,
        inertia_zz=0.4122,
    )


PARAMETER_SETS = {"thesis": thesis, "physical_tail": physical_tail}


RIGID_LEVERS, NO_H_FORCE = LeverParameters(), HForceParameters()
"""The switches of the real machine, off."""


class Constants(NamedTuple):
    """What the compiled equations need; floats and groups of floats, made by `constants`, SI units."""

    mass: float
    gravity: float
    weight: float
    air_density: float
    inertia_xx: float
    inertia_yy: float
    inertia_zz: float
    inertia_xz: float
    drag_area: float
    fade_speed: float
    radius: float
    lift_per_angle: float
    lift_per_speed_squared: float
    lift_per_inflow: float
    inflow_gradient: float
    stall_angle: float
    stall_rounding: float
    drag_moment: float
    drag_constant: float
    drag_linear: float
    drag_square: float
    hover_inflow: float
    inflow_time: float
    speed_flapping: float
    flapping_damping: float
    phase_cos: float
    phase_sin: float
    hub_stiffness: float
    hub_x: float
    hub_z: float
    bar_rate: float
    bar_to_blade: float
    plate_to_blade: float
    plate_to_bar: float
    tail_lift_per_angle: float
    tail_lift_per_inflow: float
    tail_inflow_gradient: float
    tail_drag_moment: float
    tail_side_flow: float
    tail_x: float
    tail_z: float
    tail_thrust: float
    tail_hover_inflow: float
    tail_inflow_time: float
    motor_gear: float
    tail_gear: float
    shaft_inertia: float
    drive_inertia: float
    motor_time: float
    torque_constant: float
    armature_resistance: float
    supply_gain: float
    supply_voltage: float
    supply_current: float
    levers: LeverConstants
    h_force: HForceConstants


def constants(
    parameters: HelicopterParameters,
    levers: LeverParameters = RIGID_LEVERS,
    h_force: HForceParameters = NO_H_FORCE,
) -> Constants:
    """Derived constants of the compiled equations.

    Args:
        parameters: the helicopter.
        levers: gains that depend on the collective, and play.
        h_force: whether the H force is counted in the torque.

    Raises:
        ValueError: a blade whose inner end is not inside its tip.
    """
    h = parameters
    for name, inner, tip in (
        ("cutout", h.cutout, h.radius),
        ("bar_cutout", h.bar_cutout, h.bar_radius),
        ("tail_cutout", h.tail_cutout, h.tail_radius),
    ):
        if inner >= tip:
            raise ValueError(f"{name} {inner!r} m is not inside the tip radius {tip!r} m")

    blade = h.air_density * h.chord
    lift = h.thrust_efficiency * blade * h.lift_slope
    tail_blade = h.air_density * h.tail_chord
    tail_lift = h.tail_efficiency * tail_blade * h.tail_lift_slope
    fourth = h.radius**4 - h.cutout**4
    lock_number = h.lock_factor * blade * h.lift_slope * fourth / h.blade_inertia  # source eq. 2.36
    blade_centre = 0.5 * (h.radius + h.cutout)
    hinge_moment = h.hinge_offset * h.blade_mass * blade_centre
    phase = math.atan(hinge_moment / h.blade_inertia / (lock_number / 8.0))
    bar_fourth = h.bar_radius**4 - h.bar_cutout**4
    bar_lock_number = h.air_density * h.bar_chord * h.bar_lift_slope * bar_fourth / h.bar_inertia
    weight = h.mass * h.gravity
    shaft_inertia = h.rotor_inertia + h.bar_inertia
    return packed(
        Constants(
            mass=h.mass,
            gravity=h.gravity,
            weight=weight,
            air_density=h.air_density,
            inertia_xx=h.inertia_xx,
            inertia_yy=h.inertia_yy,
            inertia_zz=h.inertia_zz,
            inertia_xz=h.inertia_xz,
            drag_area=h.drag_area,
            fade_speed=h.fade_fraction * h.rotor_speed,
            radius=h.radius,
            lift_per_angle=lift * (h.radius**3 - h.cutout**3) / 3.0,
            lift_per_speed_squared=lift * (h.radius - h.cutout) / 2.0,
            lift_per_inflow=lift * (h.radius**2 - h.cutout**2) / 2.0,
            inflow_gradient=1.5 * h.radius**2 / (h.radius**3 - h.cutout**3),  # source eq. 2.28
            stall_angle=h.stall_angle,
            stall_rounding=h.stall_rounding,
            drag_moment=2.0 * h.thrust_efficiency * blade * fourth / 4.0,
            drag_constant=h.drag_constant,
            drag_linear=h.drag_linear,
            drag_square=h.drag_square,
            hover_inflow=math.sqrt(weight / (2.0 * h.air_density * math.pi * h.radius**2)),  # eq. 2.22
            inflow_time=h.inflow_time,
            speed_flapping=h.speed_flapping,
            flapping_damping=16.0 / lock_number,  # tau_M Omega, source eq. 2.40
            phase_cos=math.cos(phase),
            phase_sin=math.sin(phase),
            hub_stiffness=h.blade_mass * blade_centre * h.hinge_offset,
            hub_x=h.hub_x,
            hub_z=h.hub_z,
            bar_rate=bar_lock_number / 16.0,  # k / Omega, source eq. 2.47
            bar_to_blade=h.bar_to_blade,
            plate_to_blade=h.plate_to_blade,
            plate_to_bar=h.plate_to_bar,
            tail_lift_per_angle=tail_lift * (h.tail_radius**3 - h.tail_cutout**3) / 3.0,
            tail_lift_per_inflow=tail_lift * (h.tail_radius**2 - h.tail_cutout**2) / 2.0,
            tail_inflow_gradient=1.5 * h.tail_radius**2 / (h.tail_radius**3 - h.tail_cutout**3),
            tail_drag_moment=2.0
            * h.tail_efficiency
            * tail_blade
            * (h.tail_radius**4 - h.tail_cutout**4)
            / 4.0,
            tail_side_flow=h.tail_side_flow,
            tail_x=h.tail_x,
            tail_z=h.tail_z,
            tail_thrust=h.tail_thrust,
            tail_hover_inflow=math.sqrt(h.tail_thrust / (2.0 * h.air_density * math.pi * h.tail_radius**2)),
            tail_inflow_time=h.tail_inflow_time,
            motor_gear=h.motor_gear,
            tail_gear=h.tail_gear,
            shaft_inertia=shaft_inertia,
            drive_inertia=shaft_inertia + h.tail_gear**2 * h.tail_inertia + h.motor_gear**2 * h.motor_inertia,
            motor_time=h.motor_time,
            torque_constant=h.torque_constant,
            armature_resistance=h.armature_resistance,
            supply_gain=h.supply_gain,
            supply_voltage=h.supply_voltage,
            supply_current=h.supply_current,
            levers=lever_constants(levers, h),
            h_force=h_force_constants(h_force, h),
        )
    )
