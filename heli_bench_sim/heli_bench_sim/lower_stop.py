"""The lower stop on which the helicopter rests on its skids: contact, tilt and friction (spec 2.1, D).

The normal force is one-sided and continuous at touch-down (Hunt and Crossley: damping grows with depth).
Tilt and friction are proportional to it, so they fade out as the rotor takes the weight. Friction sticks: a
bristle per direction bends with the motion (Dahl's model) and the skid slips once it is fully bent; a
helicopter on its skids therefore holds against the drive's torque without creeping.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from heli_common.compiled import equation
from heli_common.quantities import quantity


@dataclass(frozen=True)
class StopParameters:
    """Lower stop and skids."""

    stiffness: float = quantity(4.0e4, "N/m", "D", "spring of the stop", 1e2, 1e6)
    damping: float = quantity(5.0, "s/m", "D", "growth of the force per closing speed", 0.0, 100.0)
    half_base: float = quantity(0.15, "m", "D", "half of the skids' width and length", 0.01, 1.0)
    tilt_scale: float = quantity(0.02, "rad", "D", "tilt at which the skids' edge takes over", 1e-3, 0.5)
    tilt_damping: float = quantity(0.1, "m s", "D", "tilt damping per normal force", 0.0, 10.0)
    friction: float = quantity(0.8, "-", "D", "friction coefficient of the skids' rubber", 0.0, 2.0)
    slip_distance: float = quantity(0.005, "m", "D", "bend of a bristle at which it slips", 1e-4, 0.1)
    slip_damping: float = quantity(4.0, "s/m", "D", "damping of the bristle per normal force", 0.0, 100.0)
    friction_radius: float = quantity(0.25, "m", "D", "lever of the friction in yaw", 0.01, 2.0)
    slip_angle: float = quantity(0.04, "rad", "D", "twist at which the skids slip in yaw", 1e-3, 0.5)
    twist_damping: float = quantity(0.17, "m s", "D", "damping of the twist per normal force", 0.0, 10.0)
    release_time: float = quantity(0.05, "s", "D", "time in which a free bristle straightens", 1e-3, 1.0)
    release_force: float = quantity(1.0, "N", "D", "normal force below which bristles let go", 1e-3, 100.0)


class StopConstants(NamedTuple):
    """What the compiled contact needs; every field a float, SI."""

    surface: float
    stiffness: float
    damping: float
    half_base: float
    tilt_scale: float
    tilt_damping: float
    friction: float
    slip_distance: float
    slip_damping: float
    friction_radius: float
    slip_angle: float
    twist_damping: float
    release_time: float
    release_force: float


def stop_constants(parameters: StopParameters, rest_depth: float, weight: float) -> StopConstants:
    """Constants of a stop on which a given weight comes to rest at the given depth.

    Args:
        parameters: of the stop.
        rest_depth: NED z at rest [m]; the unloaded surface lies higher by what the spring gives way.
        weight: resting on it [N].
    """
    return StopConstants(
        surface=rest_depth - weight / parameters.stiffness,
        stiffness=parameters.stiffness,
        damping=parameters.damping,
        half_base=parameters.half_base,
        tilt_scale=parameters.tilt_scale,
        tilt_damping=parameters.tilt_damping,
        friction=parameters.friction,
        slip_distance=parameters.slip_distance,
        slip_damping=parameters.slip_damping,
        friction_radius=parameters.friction_radius,
        slip_angle=parameters.slip_angle,
        twist_damping=parameters.twist_damping,
        release_time=parameters.release_time,
        release_force=parameters.release_force,
    )


@equation
def one_sided(depth: float, speed: float, stiffness: float, damping: float) -> float:
    """Force of a stop that only pushes: stiffness x depth x (1 + damping x speed), never below zero.

    Args:
        depth: how far the stop is pressed in [m or rad]; not positive means no contact.
        speed: its rate [1/s of the same].
        stiffness: force or moment per depth.
        damping: growth per closing speed.
    """
    if depth <= 0.0:
        return 0.0
    return max(0.0, stiffness * depth * (1.0 + damping * speed))


@equation
def normal_force(z: float, z_rate: float, s: StopConstants) -> float:
    """Force of the stop upwards [N] from the platform's NED z [m] and its rate [m/s].

    Args:
        z: NED z of the platform [m].
        z_rate: its rate [m/s].
        s: constants of the stop.
    """
    return one_sided(z - s.surface, z_rate, s.stiffness, s.damping)


@equation
def tilt_moment(angle: float, rate: float, normal: float, s: StopConstants) -> float:
    """Moment of the skids about one horizontal gimbal axis [N m].

    Restoring up to normal force times half the base: beyond that the helicopter tips over.

    Args:
        angle: of the axis [rad].
        rate: of the axis [rad/s].
        normal: force on the skids [N].
        s: constants of the stop.
    """
    lever = s.half_base * angle / math.sqrt(angle * angle + s.tilt_scale * s.tilt_scale)
    return -normal * (lever + s.tilt_damping * rate)


@equation
def bristle_rate(
    bend: float, velocity: float, speed: float, slip: float, normal: float, s: StopConstants
) -> float:
    """Rate at which a friction bristle bends (Dahl); without load it straightens.

    Args:
        bend: of the bristle [m or rad].
        velocity: of the skid along it [1/s of the same].
        speed: of the skid over the ground, all directions together, not negative.
        slip: bend at which it slips.
        normal: force on the skids [N].
        s: constants of the stop.
    """
    free = max(0.0, 1.0 - normal / s.release_force) ** 2
    return velocity - speed * bend / slip - free * bend / s.release_time


@equation
def friction_force(bend: float, bend_rate: float, normal: float, s: StopConstants) -> float:
    """Friction along one horizontal direction [N].

    Args:
        bend: of the bristle [m].
        bend_rate: its rate [m/s].
        normal: force on the skids [N].
        s: constants of the stop.
    """
    return -normal * (s.friction * bend / s.slip_distance + s.slip_damping * bend_rate)


@equation
def friction_moment(twist: float, twist_rate: float, normal: float, s: StopConstants) -> float:
    """Friction about the yaw axis [N m].

    Args:
        twist: of the bristle [rad].
        twist_rate: its rate [rad/s].
        normal: force on the skids [N].
        s: constants of the stop.
    """
    return -normal * (s.friction * s.friction_radius * twist / s.slip_angle + s.twist_damping * twist_rate)
