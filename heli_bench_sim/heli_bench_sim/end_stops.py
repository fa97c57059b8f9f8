"""Ends of travel: the cylinder of the work space and the gimbal's stops (spec 2.1, D)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from heli_bench_sim.lower_stop import one_sided
from heli_common.compiled import equation
from heli_common.quantities import quantity
from heli_common.rig_geometry import RigGeometry


@dataclass(frozen=True)
class EndStopParameters:
    """Springs and dampers at the ends of travel."""

    tilt_limit: float = quantity(math.radians(25.0), "rad", "D", "roll and pitch stops", 0.01, 1.4)
    yaw_limit: float = quantity(math.radians(170.0), "rad", "D", "yaw stops", 0.01, 3.2)
    gimbal_stiffness: float = quantity(400.0, "N m/rad", "D", "spring of a gimbal stop", 1.0, 1e5)
    gimbal_damping: float = quantity(0.5, "s/rad", "D", "growth per closing rate", 0.0, 100.0)
    platform_stiffness: float = quantity(8000.0, "N/m", "D", "spring of side and top stops", 10.0, 1e6)
    platform_damping: float = quantity(1.0, "s/m", "D", "growth per closing speed", 0.0, 100.0)


class EndStopConstants(NamedTuple):
    """What the compiled stops need; every field a float, SI."""

    tilt_limit: float
    yaw_limit: float
    gimbal_stiffness: float
    gimbal_damping: float
    platform_stiffness: float
    platform_damping: float
    radius: float
    top: float


def end_stop_constants(parameters: EndStopParameters, geometry: RigGeometry) -> EndStopConstants:
    """Constants of the stops around a work space; `top` is its NED z [m].

    Args:
        parameters: of the stops.
        geometry: of the rig.
    """
    return EndStopConstants(
        tilt_limit=parameters.tilt_limit,
        yaw_limit=parameters.yaw_limit,
        gimbal_stiffness=parameters.gimbal_stiffness,
        gimbal_damping=parameters.gimbal_damping,
        platform_stiffness=parameters.platform_stiffness,
        platform_damping=parameters.platform_damping,
        radius=geometry.work_radius,
        top=geometry.centre_height - geometry.work_top,
    )


@equation
def gimbal_torque(angle: float, rate: float, limit: float, e: EndStopConstants) -> float:
    """Torque of the two stops of one gimbal axis [N m] at +-limit [rad].

    Args:
        angle: of the axis [rad].
        rate: of the axis [rad/s].
        limit: where the stops stand, +- [rad].
        e: constants of the stops.
    """
    back = one_sided(angle - limit, rate, e.gimbal_stiffness, e.gimbal_damping)
    return one_sided(-limit - angle, -rate, e.gimbal_stiffness, e.gimbal_damping) - back


@equation
def platform_force(
    x: float, y: float, z: float, x_rate: float, y_rate: float, z_rate: float, e: EndStopConstants
) -> tuple[float, float, float]:
    """Force of the cylinder's wall and top on the platform, NED [N], from its position and velocity, NED.

    Args:
        x: position north [m].
        y: east [m].
        z: down [m].
        x_rate: velocity north [m/s].
        y_rate: east [m/s].
        z_rate: down [m/s].
        e: constants of the stops.
    """
    down = one_sided(e.top - z, -z_rate, e.platform_stiffness, e.platform_damping)
    distance = math.sqrt(x * x + y * y)
    if distance <= e.radius:
        return 0.0, 0.0, down
    outward = (x * x_rate + y * y_rate) / distance
    push = one_sided(distance - e.radius, outward, e.platform_stiffness, e.platform_damping) / distance
    return -push * x, -push * y, down
