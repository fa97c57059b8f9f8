"""Friction of the arms on the platform and of the gimbal's bearings (spec 2.1, D).

It is why the source identified X_u = -1.07 and Y_v = -1.19 1/s in flight where the aerodynamic model gives
hundredths. Coulomb friction is smoothed over a small speed, so that it has a slope at rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from heli_common.compiled import equation
from heli_common.quantities import quantity


@dataclass(frozen=True)
class ArmFrictionParameters:
    """Viscous and Coulomb friction of the rig."""

    viscous_x: float = quantity(7.7, "N s/m", "D", "viscous friction of the platform, north", 0.0, 100.0)
    viscous_y: float = quantity(8.6, "N s/m", "D", "viscous friction of the platform, east", 0.0, 100.0)
    viscous_z: float = quantity(5.0, "N s/m", "D", "viscous friction of the platform, down", 0.0, 100.0)
    coulomb: float = quantity(0.2, "N", "D", "Coulomb friction of the platform", 0.0, 10.0)
    coulomb_speed: float = quantity(0.005, "m/s", "D", "speed over which it is smoothed", 1e-4, 1.0)
    gimbal: float = quantity(0.005, "N m", "D", "Coulomb friction of each gimbal axis", 0.0, 1.0)
    gimbal_rate: float = quantity(0.02, "rad/s", "D", "rate over which it is smoothed", 1e-4, 1.0)


NO_ARM_FRICTION = ArmFrictionParameters(viscous_x=0.0, viscous_y=0.0, viscous_z=0.0, coulomb=0.0, gimbal=0.0)
"""A rig without friction, as in the source's linear model."""


class ArmFrictionConstants(NamedTuple):
    """What the compiled friction needs; the fields of `ArmFrictionParameters`, every one a float, SI."""

    viscous_x: float
    viscous_y: float
    viscous_z: float
    coulomb: float
    coulomb_speed: float
    gimbal: float
    gimbal_rate: float


def arm_friction_constants(parameters: ArmFrictionParameters) -> ArmFrictionConstants:
    """Constants of the compiled friction."""
    return ArmFrictionConstants(**vars(parameters))


@equation
def platform_friction(
    north: float, east: float, down: float, f: ArmFrictionConstants
) -> tuple[float, float, float]:
    """Force of the arms on the platform against its motion, NED [N].

    Args:
        north: velocity of the platform, NED [m/s].
        east: the same.
        down: the same.
        f: constants.
    """
    speed = math.sqrt(north * north + east * east + down * down + f.coulomb_speed * f.coulomb_speed)
    dry = f.coulomb / speed
    return -(f.viscous_x + dry) * north, -(f.viscous_y + dry) * east, -(f.viscous_z + dry) * down


@equation
def gimbal_friction(rate: float, f: ArmFrictionConstants) -> float:
    """Torque of one gimbal bearing against its rate [rad/s], in N m."""
    return -f.gimbal * rate / math.sqrt(rate * rate + f.gimbal_rate * f.gimbal_rate)
