"""Delta arm, inverse: from the platform's position to the three arm angles (spec 2.1).

Each upper arm swings in the vertical plane of its azimuth; the parallelogram forearm keeps the elbow at a
fixed distance from the platform joint. Seen in that plane the elbow lies on a circle and on the sphere of the
forearm: two solutions, of which the rig is built with the outer one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_common.rig_geometry import ARM_AZIMUTH, RigGeometry

Array = NDArray[np.float64]

ARMS = len(ARM_AZIMUTH)

_SINE = tuple(math.sin(azimuth) for azimuth in ARM_AZIMUTH)
_COSINE = tuple(math.cos(azimuth) for azimuth in ARM_AZIMUTH)


class ArmConstants(NamedTuple):
    """Geometry for the compiled kinematics; every field a float [m]."""

    inward: float
    """base circle less platform circle"""
    upper_arm: float
    forearm: float
    centre_height: float


def arm_constants(geometry: RigGeometry) -> ArmConstants:
    """The few lengths that the kinematics need.

    Args:
        geometry: of the rig.
    """
    return ArmConstants(
        inward=geometry.base_radius - geometry.platform_radius,
        upper_arm=geometry.upper_arm,
        forearm=geometry.forearm,
        centre_height=geometry.centre_height,
    )


@compiled
def solve_arms(x: float, y: float, z: float, geometry: ArmConstants, out: Array) -> bool:
    """Write the three arm angles [rad] into `out`; False, and `out` incomplete, if an arm cannot reach.

    Args:
        x: platform north of the flight-space centre [m].
        y: east [m].
        z: down [m].
        geometry: of the rig.
        out: (3,) receives the angles from the horizontal, outward, up positive.
    """
    height = geometry.centre_height - z
    for arm in range(ARMS):
        sine, cosine = _SINE[arm], _COSINE[arm]
        outward = x * cosine + y * sine - geometry.inward
        aside = y * cosine - x * sine
        reach = math.sqrt(outward * outward + height * height)
        squares = outward * outward + aside * aside + height * height
        excess = squares + geometry.upper_arm**2 - geometry.forearm**2
        bound = 2.0 * geometry.upper_arm * reach
        if not abs(excess) <= bound or bound == 0.0:
            return False
        out[arm] = math.atan2(height, outward) - math.acos(excess / bound)
    return True


def arm_angles(position: Array, geometry: RigGeometry) -> Array:
    """Arm angles at a position of the platform.

    Args:
        position: (3,) NED from the flight-space centre [m].
        geometry: of the rig.

    Returns:
        (3,) angles from the horizontal, outward, up positive [rad], in the order of the azimuths.

    Raises:
        ValueError: no arm posture reaches this position.
    """
    angles = np.empty(ARMS)
    x, y, z = (float(part) for part in position)
    if not solve_arms(x, y, z, arm_constants(geometry), angles):
        raise ValueError(f"platform position {(x, y, z)!r} m (NED) is out of the arms' reach")
    return angles


def arm_jacobian(position: Array, geometry: RigGeometry) -> Array:
    """(3, 3) change of the arm angles per platform displacement [rad/m], NED columns.

    From the constant length of the forearm: for a moving platform and elbow its direction e gives
    e . (platform velocity) = e . (elbow velocity).

    Args:
        position: (3,) NED from the flight-space centre [m].
        geometry: of the rig.

    Raises:
        ValueError: the position is out of reach, or an arm is stretched there.
    """
    angles = arm_angles(position, geometry)
    rows = []
    for azimuth, angle in zip(ARM_AZIMUTH, angles, strict=True):
        outward = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        up = np.array([0.0, 0.0, -1.0])
        base = (geometry.base_radius - geometry.platform_radius) * outward - geometry.centre_height * up
        elbow = base + geometry.upper_arm * (math.cos(angle) * outward + math.sin(angle) * up)
        forearm = np.asarray(position, dtype=np.float64) - elbow
        swing = geometry.upper_arm * (math.cos(angle) * up - math.sin(angle) * outward)
        lever = float(forearm @ swing)
        if abs(lever) < 1e-9:
            raise ValueError(f"an arm is stretched at platform position {tuple(position)!r} m (NED)")
        rows.append(forearm / lever)
    return np.array(rows)
