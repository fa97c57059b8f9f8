"""Numbers of large messages, written by compiled code; NED/FRD becomes ENU/FLU as in `vehicle_state`.

The conversions are the functions of that module themselves, made known to compiled code here, so that nodes
that compile nothing need not load the compiler.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import callable_too, compiled
from heli_common.rotations import (
    Euler,
    Quaternion,
    canonical,
    divided,
    euler_from_unit,
    is_rotation,
    norm,
    quaternion_from_euler,
)
from heli_common.vehicle_state import quaternion_enu, swap_body, swap_earth, swap_frames

Array = NDArray[np.float64]

for _function in (
    canonical,
    quaternion_from_euler,
    swap_frames,
    quaternion_enu,
    swap_body,
    swap_earth,
    norm,
    is_rotation,
    divided,
    euler_from_unit,
):
    callable_too(_function)

_SWAPPED = np.array([1, 0, 2, 4, 3, 5])
_ENU_PLACES = (6 * _SWAPPED[:, np.newaxis] + _SWAPPED).ravel()
_ENU_SIGNS = np.outer([1, 1, -1] * 2, [1, 1, -1] * 2).ravel().astype(np.float64)
_FLU_SIGNS = np.outer([1, -1, -1] * 2, [1, -1, -1] * 2).ravel().astype(np.float64)


@compiled
def write_odometry(motion: Array, values: Array) -> None:
    """The numbers of an Odometry (layout `odometry`) in ENU/FLU.

    Args:
        motion: (84,) position [m] in earth NED; yaw, pitch, roll [rad]; velocity [m/s] and rates [rad/s] in
            body FRD; covariance (6, 6) of position and of rotations about north, east, down; covariance
            (6, 6) of velocity and rates.
        values: (85,) written.
    """
    values[0], values[1], values[2] = swap_earth((motion[0], motion[1], motion[2]))
    _write_quaternion(quaternion_enu(Euler(motion[3], motion[4], motion[5])), values[3:7])
    values[43], values[44], values[45] = swap_body((motion[6], motion[7], motion[8]))
    values[46], values[47], values[48] = swap_body((motion[9], motion[10], motion[11]))
    pose, twist = motion[12:48], motion[48:84]
    for place in range(36):
        values[7 + place] = pose[_ENU_PLACES[place]] * _ENU_SIGNS[place]
        values[49 + place] = twist[place] * _FLU_SIGNS[place]


@compiled
def read_pose(values: Array, pose: Array) -> bool:
    """Position and attitude from the numbers of an Odometry or a PoseStamped in ENU/FLU.

    Args:
        values: (7 or more,) position and quaternion in front.
        pose: (6 or more,) receives position in earth NED [m] and yaw, pitch, roll [rad].

    Returns:
        False, and nothing written, if the quaternion is zero or not finite.
    """
    turned = swap_frames(Quaternion(values[3], values[4], values[5], values[6]))
    length = norm(turned)
    if not is_rotation(length):
        return False
    pose[0], pose[1], pose[2] = swap_earth((values[0], values[1], values[2]))
    pose[3], pose[4], pose[5] = euler_from_unit(divided(turned, length))
    return True


@compiled
def write_pose(position: tuple[float, float, float], attitude: Euler, values: Array) -> None:
    """The numbers of a PoseStamped (layout `pose_stamped`) in ENU/FLU.

    Args:
        position: earth NED [m].
        attitude: yaw, pitch, roll [rad].
        values: (7,) written.
    """
    values[0], values[1], values[2] = swap_earth(position)
    _write_quaternion(quaternion_enu(attitude), values[3:7])


@compiled
def write_imu_attitude(
    attitude: Euler,
    variances: tuple[float, float, float],
    rates: tuple[float, float, float],
    rate_variance: float,
    values: Array,
) -> None:
    """The numbers of an Imu (layout `imu`) in ENU/FLU with attitude and rates.

    The acceleration is marked unknown (REP 145).

    Args:
        attitude: yaw, pitch, roll [rad].
        variances: of rotations about north, east, down [rad^2].
        rates: p, q, r, body FRD [rad/s].
        rate_variance: of each of them [rad^2/s^2].
        values: (37,) written.
    """
    for place in range(len(values)):
        values[place] = 0.0
    _write_quaternion(quaternion_enu(attitude), values[0:4])
    values[4], values[8], values[12] = variances[1], variances[0], variances[2]
    values[13], values[14], values[15] = swap_body(rates)
    values[16], values[20], values[24] = rate_variance, rate_variance, rate_variance
    values[28] = -1.0


@compiled
def _write_quaternion(quaternion: Quaternion, values: Array) -> None:
    values[0], values[1], values[2], values[3] = quaternion
