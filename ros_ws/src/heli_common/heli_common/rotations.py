"""Rotations between earth and body: Euler angles yaw-pitch-roll, matrices, quaternions (source app. A).

A quaternion is (x, y, z, w), of the rotation that takes body coordinates to earth coordinates. Scalar code
on plain floats, which compiled code may call as well (`heli_common.compiled_messages`).
"""

from __future__ import annotations

from math import asin, atan2, cos, pi, sin, sqrt
from typing import NamedTuple

Matrix3 = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
Vector3 = tuple[float, float, float]


class Euler(NamedTuple):
    """Yaw psi, pitch theta, roll phi [rad]: rotations about z, y', x'' from earth to body."""

    psi: float
    theta: float
    phi: float


class Quaternion(NamedTuple):
    """Unit quaternion, vector part first as in ROS."""

    x: float
    y: float
    z: float
    w: float


def matrix_from_euler(euler: Euler) -> Matrix3:
    """C_nb: body coordinates to earth coordinates (source eq. 2.1)."""
    spsi, cpsi = sin(euler.psi), cos(euler.psi)
    sth, cth = sin(euler.theta), cos(euler.theta)
    sphi, cphi = sin(euler.phi), cos(euler.phi)
    return (
        (cpsi * cth, cpsi * sth * sphi - spsi * cphi, cpsi * sth * cphi + spsi * sphi),
        (spsi * cth, spsi * sth * sphi + cpsi * cphi, spsi * sth * cphi - cpsi * sphi),
        (-sth, cth * sphi, cth * cphi),
    )


def rotate(matrix: Matrix3, vector: Vector3) -> Vector3:
    """matrix @ vector."""
    x, y, z = vector
    a, b, c = matrix
    return (
        a[0] * x + a[1] * y + a[2] * z,
        b[0] * x + b[1] * y + b[2] * z,
        c[0] * x + c[1] * y + c[2] * z,
    )


def transpose(matrix: Matrix3) -> Matrix3:
    """The inverse rotation."""
    a, b, c = matrix
    return ((a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2]))


def quaternion_from_euler(euler: Euler) -> Quaternion:
    """The quaternion with w >= 0 of a yaw-pitch-roll attitude."""
    cy, sy = cos(0.5 * euler.psi), sin(0.5 * euler.psi)
    cp, sp = cos(0.5 * euler.theta), sin(0.5 * euler.theta)
    cr, sr = cos(0.5 * euler.phi), sin(0.5 * euler.phi)
    return canonical(
        Quaternion(
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )
    )


def euler_from_quaternion(quaternion: Quaternion) -> Euler:
    """Yaw-pitch-roll of a quaternion; q and -q give the same angles.

    Raises:
        ValueError: the quaternion is zero or not finite.
    """
    return euler_from_unit(normalized(quaternion))


def euler_from_unit(quaternion: Quaternion) -> Euler:
    """The same of a quaternion whose length is 1 already."""
    x, y, z, w = quaternion
    sin_theta = 2.0 * (w * y - z * x)
    theta = asin(max(-1.0, min(1.0, sin_theta)))
    if abs(sin_theta) > 1.0 - 1e-12:
        # nose straight up or down: only psi - phi (up) or psi + phi (down) is defined, so phi is set to 0
        return Euler(atan2(-2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z)), theta, 0.0)
    psi = atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    phi = atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return Euler(psi, theta, phi)


def multiply(left: Quaternion, right: Quaternion) -> Quaternion:
    """Hamilton product: first `right`, then `left`."""
    ax, ay, az, aw = left
    bx, by, bz, bw = right
    return Quaternion(
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def conjugate(quaternion: Quaternion) -> Quaternion:
    """The inverse rotation."""
    return Quaternion(-quaternion.x, -quaternion.y, -quaternion.z, quaternion.w)


def normalized(quaternion: Quaternion) -> Quaternion:
    """Unit length.

    Raises:
        ValueError: the quaternion is zero or not finite.
    """
    length = norm(quaternion)
    if not is_rotation(length):
        raise ValueError(f"{tuple(quaternion)} is no rotation")
    return divided(quaternion, length)


def norm(quaternion: Quaternion) -> float:
    """Length of a quaternion."""
    x, y, z, w = quaternion
    return sqrt(x * x + y * y + z * z + w * w)


def is_rotation(length: float) -> bool:
    """Whether a quaternion of this length can be brought to unit length."""
    return 1e-9 < length < 1e9


def divided(quaternion: Quaternion, length: float) -> Quaternion:
    """Every part over a length."""
    x, y, z, w = quaternion
    return Quaternion(x / length, y / length, z / length, w / length)


def canonical(quaternion: Quaternion) -> Quaternion:
    """The one of q and -q whose scalar part is not negative."""
    if quaternion.w < 0.0:
        return Quaternion(-quaternion.x, -quaternion.y, -quaternion.z, -quaternion.w)
    return quaternion


def wrap(angle: float) -> float:
    """The same angle in -pi .. pi [rad]."""
    if -pi <= angle <= pi:
        return angle
    return (angle + pi) % (2.0 * pi) - pi
