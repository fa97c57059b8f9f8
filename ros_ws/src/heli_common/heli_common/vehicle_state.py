"""The vehicle's state, and the only place where NED/FRD becomes ENU/FLU and back (REP 103, REP 147).

Earth is north-east-down, body is forward-right-down in all maths; messages carry earth east-north-up and
body forward-left-up. Origin of both is the centre of the flight space.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan, sqrt
from typing import NamedTuple

from heli_common.rotations import (
    Euler,
    Quaternion,
    Vector3,
    canonical,
    euler_from_quaternion,
    quaternion_from_euler,
)

WORLD_FRAME = "world"
BODY_FRAME = "base_link"
IMU_FRAME = "imu_link"
HEADING_FRAME = "heading"

_HALF = sqrt(0.5)
"""Vector parts of half a turn about the axis between north and east."""

UNKNOWN_VARIANCE = 1e6
"""Variance of a pose that nobody knows yet, because the encoders are not indexed."""


class VehicleState(NamedTuple):
    """What controllers know of the helicopter.

    Attributes:
        position: of the centre of gravity in earth NED [m].
        attitude: yaw, pitch, roll [rad].
        velocity: against the earth, in body FRD [m/s].
        rates: p, q, r of the body against the earth, in body FRD [rad/s].
        known: whether the pose is absolute (all encoders indexed).
    """

    position: Vector3
    attitude: Euler
    velocity: Vector3
    rates: Vector3
    known: bool = True


NOWHERE = VehicleState((0.0, 0.0, 0.0), Euler(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), False)
"""What is known of the helicopter while nothing is."""


def swap_earth(vector: Vector3) -> Vector3:
    """NED to ENU or ENU to NED."""
    return (vector[1], vector[0], -vector[2])


def swap_body(vector: Vector3) -> Vector3:
    """FRD to FLU or FLU to FRD."""
    return (vector[0], -vector[1], -vector[2])


def quaternion_enu(attitude: Euler) -> Quaternion:
    """Attitude as ROS has it: FLU body to ENU earth, scalar part not negative."""
    return canonical(swap_frames(quaternion_from_euler(attitude)))


def attitude_ned(quaternion: Quaternion) -> Euler:
    """Yaw, pitch, roll of the helicopter from the attitude in a message; q and -q are the same.

    Raises:
        ValueError: the quaternion is zero or not finite.
    """
    return euler_from_quaternion(swap_frames(quaternion))


def swap_frames(quaternion: Quaternion) -> Quaternion:
    """FRD body to NED earth from FLU body to ENU earth, of any length, or the other way (up to sign).

    The product with half a turn about the nose on its right and half a turn about the axis between north and
    east on its left, (1, 0, 0, 0) and (1, 1, 0, 0) / sqrt 2, without their zeros.
    """
    x, y, z, w = quaternion
    h = _HALF
    # the zero in front keeps what is level and heads north from becoming minus zero
    return Quaternion(0.0 - h * x - h * y, 0.0 + h * y - h * x, 0.0 + h * z - h * w, 0.0 - h * w - h * z)


def pose_values(position: Vector3, attitude: Euler) -> tuple[float, ...]:
    """Numbers of a PoseStamped (layout `pose_stamped`) in ENU/FLU from a pose in NED/FRD."""
    return (*swap_earth(position), *quaternion_enu(attitude))


def pose_from_values(values: Sequence[float]) -> tuple[Vector3, Euler]:
    """Position [m] NED and attitude [rad] from the numbers of a PoseStamped in ENU/FLU."""
    position = swap_earth((values[0], values[1], values[2]))
    return position, attitude_ned(Quaternion(values[3], values[4], values[5], values[6]))


def odometry_values(
    state: VehicleState, pose_variance: Sequence[float], twist_variance: Sequence[float]
) -> tuple[float, ...]:
    """Numbers of an Odometry (layout `odometry`) in ENU/FLU.

    Args:
        state: in NED/FRD.
        pose_variance: of x, y, z in ENU [m2] and of rotations about the ENU axes [rad2].
        twist_variance: of the velocities [m2/s2] and rates [rad2/s2] in body FLU.
    """
    pose = pose_values(state.position, state.attitude)
    twist = (*swap_body(state.velocity), *swap_body(state.rates))
    return (*pose, *_diagonal(pose_variance), *twist, *_diagonal(twist_variance))


def state_from_odometry(values: Sequence[float]) -> VehicleState:
    """The state in NED/FRD from the numbers of an Odometry in ENU/FLU.

    Nodes of one process that are handed the same tuple work it out once.

    Raises:
        ValueError: the quaternion is zero or not finite.
    """
    if values is _Latest.values:
        return _Latest.state
    position, attitude = pose_from_values(values)
    velocity = swap_body((values[43], values[44], values[45]))
    rates = swap_body((values[46], values[47], values[48]))
    state = VehicleState(position, attitude, velocity, rates, values[7] < 0.5 * UNKNOWN_VARIANCE)
    if isinstance(values, tuple):  # what cannot change
        _Latest.values, _Latest.state = values, state
    return state


class _Latest:
    """The odometry that was read last; none at first."""

    values: tuple[float, ...] = (nan,)
    state = NOWHERE


def twist_values(linear: Vector3, angular: Vector3) -> tuple[float, ...]:
    """Numbers of a TwistStamped in FLU axes from vectors in FRD axes."""
    return (*swap_body(linear), *swap_body(angular))


def twist_from_values(values: Sequence[float]) -> tuple[Vector3, Vector3]:
    """Linear and angular velocity in FRD axes from the numbers of a TwistStamped in FLU axes."""
    return (
        swap_body((values[0], values[1], values[2])),
        swap_body((values[3], values[4], values[5])),
    )


def imu_values(
    gyro: Vector3, accelerometer: Vector3, variances: tuple[float, float], valid: bool = True
) -> tuple[float, ...]:
    """Numbers of an Imu (layout `imu`) in FLU from readings in FRD; the attitude is marked unknown (REP 145).

    Args:
        gyro: body rates, FRD [rad/s].
        accelerometer: specific force, FRD [m/s^2].
        variances: of one gyro [rad^2/s^2] and one accelerometer sample [m^2/s^4].
        valid: False marks both readings as not measured at this sample.
    """
    known = 1.0 if valid else 0.0
    unknown = known - 1.0
    covariances = [
        (known * variance + unknown, 0.0, 0.0, 0.0, known * variance, 0.0, 0.0, 0.0, known * variance)
        for variance in variances
    ]
    return (
        *(0.0, 0.0, 0.0, 1.0),
        *(-1.0, *(0.0,) * 8),
        *swap_body(gyro),
        *covariances[0],
        *swap_body(accelerometer),
        *covariances[1],
    )


def imu_from_values(values: Sequence[float]) -> tuple[Vector3, Vector3, bool]:
    """Body rates [rad/s] and specific force [m/s^2] in FRD, and validity, from the numbers of an Imu."""
    gyro = swap_body((values[13], values[14], values[15]))
    accelerometer = swap_body((values[25], values[26], values[27]))
    return gyro, accelerometer, values[16] >= 0.0


def _diagonal(variances: Sequence[float]) -> tuple[float, ...]:
    covariance = [0.0] * 36
    for axis, variance in enumerate(variances):
        covariance[7 * axis] = variance
    return tuple(covariance)
