"""The rig and the helicopter as lines, discs and an arrow in the world frame: what eyes see of a pose.

Arms and forearms follow the kinematics of `delta_arm`, so a forearm in the picture has its true length. What
the source says nothing about is drawn to be recognised and marked so.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.delta_arm import arm_angles
from heli_bench_sim.parameters import HelicopterParameters
from heli_common.rig_geometry import ARM_AZIMUTH, RigGeometry
from heli_common.rotations import Euler, Matrix3, Quaternion, Vector3, matrix_from_euler, multiply, rotate
from heli_common.vehicle_state import quaternion_enu, swap_earth

Array = NDArray[np.float64]

FOREARM_HALF_WIDTH = 0.03
"""Half distance of a forearm's two rods [m]; drawn, not known."""
GIMBAL_HALF_LENGTH = 0.12
"""Of the three axes in the picture [m]; drawn, not known."""
NOSE = 0.35
"""Nose ahead of the centre of gravity [m]; drawn, not known."""
WIND_SECONDS = 0.2
"""The arrow of the wind is as long as the air moves in this time."""
WIND_HEIGHT = 0.6
"""Of the arrow's tail above the centre of gravity [m]."""

_ON_ITS_SIDE = Quaternion(-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""A quarter turn about the nose axis, after which the z axis is where y was."""

Line = tuple[Vector3, Vector3]


class Lines(NamedTuple):
    """Straight lines of one part, ENU from the flight-space centre [m]."""

    part: str
    lines: tuple[Line, ...]


class Disc(NamedTuple):
    """A round disc: centre ENU [m], attitude whose z axis is normal to it, diameter [m]."""

    part: str
    centre: Vector3
    attitude: Quaternion
    diameter: float


class Picture(NamedTuple):
    """All there is to see at one instant."""

    lines: tuple[Lines, ...]
    discs: tuple[Disc, ...]
    wind: Line


def draw(
    position: Vector3, attitude: Euler, wind: Vector3, rig: RigGeometry, helicopter: HelicopterParameters
) -> Picture:
    """The picture of a pose.

    Args:
        position: of the centre of gravity, NED from the flight-space centre [m].
        attitude: yaw, pitch, roll [rad].
        wind: velocity of the air, NED [m/s].
        rig: its geometry.
        helicopter: its dimensions.

    Raises:
        ValueError: no arm posture reaches this position.
    """
    body = matrix_from_euler(attitude)

    def place(x: float, y: float, z: float) -> Vector3:
        """ENU of a point in body FRD."""
        return swap_earth(_plus(position, rotate(body, (x, y, z))))

    hub = place(helicopter.hub_x, 0.0, helicopter.hub_z)
    tail = place(helicopter.tail_x, 0.0, helicopter.tail_z)
    centre = swap_earth(position)
    shaft = place(helicopter.hub_x, 0.0, 0.0)
    frame = ((place(NOSE, 0.0, 0.0), centre), (centre, tail), (shaft, hub))
    upright = quaternion_enu(attitude)
    above = _plus(position, (0.0, 0.0, -WIND_HEIGHT))
    blown = _plus(above, (wind[0] * WIND_SECONDS, wind[1] * WIND_SECONDS, wind[2] * WIND_SECONDS))
    return Picture(
        lines=(
            *_delta_arm(position, rig),
            Lines("gimbal", _gimbal(position, attitude)),
            Lines("helicopter", frame),
        ),
        discs=(
            Disc("rotor_disc", hub, upright, 2.0 * helicopter.radius),
            Disc("tail_rotor_disc", tail, multiply(upright, _ON_ITS_SIDE), 2.0 * helicopter.tail_radius),
        ),
        wind=(swap_earth(above), swap_earth(blown)),
    )


def elbows(position: Vector3, rig: RigGeometry) -> Array:
    """(3, 3) elbows of the three arms, NED from the flight-space centre [m], a row each.

    Args:
        position: of the platform, NED [m].
        rig: its geometry.

    Raises:
        ValueError: no arm posture reaches this position.
    """
    found = []
    for azimuth, angle in zip(ARM_AZIMUTH, arm_angles(np.array(position), rig), strict=True):
        reach = rig.base_radius + rig.upper_arm * math.cos(angle)
        down = rig.centre_height - rig.upper_arm * math.sin(angle)
        found.append((reach * math.cos(azimuth), reach * math.sin(azimuth), down))
    return np.array(found)


def _delta_arm(position: Vector3, rig: RigGeometry) -> tuple[Lines, ...]:
    """Base, upper arms, forearms of two parallel rods, and platform."""
    pivots, joints, upper, fore = [], [], [], []
    for azimuth, elbow in zip(ARM_AZIMUTH, elbows(position, rig).tolist(), strict=True):
        north, east = math.cos(azimuth), math.sin(azimuth)
        pivot = (rig.base_radius * north, rig.base_radius * east, rig.centre_height)
        joint = _plus(position, (rig.platform_radius * north, rig.platform_radius * east, 0.0))
        pivots.append(swap_earth(pivot))
        joints.append(swap_earth(joint))
        upper.append((swap_earth(pivot), swap_earth(tuple(elbow))))
        for side in (-FOREARM_HALF_WIDTH, FOREARM_HALF_WIDTH):
            aside = (-side * east, side * north, 0.0)
            fore.append((swap_earth(_plus(tuple(elbow), aside)), swap_earth(_plus(joint, aside))))
    return (
        Lines("base", _triangle(pivots)),
        Lines("upper_arms", tuple(upper)),
        Lines("forearms", tuple(fore)),
        Lines("platform", _triangle(joints)),
    )


def _gimbal(position: Vector3, attitude: Euler) -> tuple[Line, ...]:
    """Axes of yaw, pitch and roll through the centre of gravity, each as the rotations before it leave it."""
    axes: tuple[tuple[Matrix3, Vector3], ...] = (
        (matrix_from_euler(Euler(0.0, 0.0, 0.0)), (0.0, 0.0, GIMBAL_HALF_LENGTH)),
        (matrix_from_euler(Euler(attitude.psi, 0.0, 0.0)), (0.0, GIMBAL_HALF_LENGTH, 0.0)),
        (matrix_from_euler(Euler(attitude.psi, attitude.theta, 0.0)), (GIMBAL_HALF_LENGTH, 0.0, 0.0)),
    )
    found = []
    for matrix, axis in axes:
        x, y, z = rotate(matrix, axis)
        found.append((swap_earth(_plus(position, (-x, -y, -z))), swap_earth(_plus(position, (x, y, z)))))
    return tuple(found)


def _triangle(corners: list[Vector3]) -> tuple[Line, ...]:
    return tuple((corners[index - 1], corners[index]) for index in range(len(corners)))


def _plus(left: Vector3, right: Vector3) -> Vector3:
    return (left[0] + right[0], left[1] + right[1], left[2] + right[2])
