"""Kinematics of the Delta rig: three arm angles to the position of the platform (spec 2.1).

Each arm i stands at azimuth beta_i (from north toward east). Its elbow, shifted inward by the platform
radius, is the centre c_i of a sphere of forearm length on which the platform point p lies:

    c_i = (r_base - r_platform + l cos alpha_i) (cos beta_i, sin beta_i, 0) + (h - l sin alpha_i) (0, 0, 1)
    |p - c_i| = f

in earth NED [m] about the flight-space centre, h above the base plane. Three spheres meet in two points; the
platform is the upper one, because it starts above the fold and cannot pass through it. Backwards each arm
stands alone: the elbow is the outer of the two points in which its circle cuts the forearm's sphere.
"""

from __future__ import annotations

from math import atan2, cos, dist, sin, sqrt

from heli_common.rig_geometry import ARM_AZIMUTH, RigGeometry
from heli_common.rotations import Matrix3, Vector3

_RADIAL = tuple((cos(azimuth), sin(azimuth)) for azimuth in ARM_AZIMUTH)
"""North and east component of the direction in which each arm points."""

_SMALLEST = 1e-3
"""Elbows nearer to each other or to one line [m], or a forearm tip nearer to their plane, are degenerate."""


ROUND_TRIP = 1e-9
"""Furthest that a position may come back from its own angles [m] (spec 2.1)."""


def position_from_arms(angles: Vector3, geometry: RigGeometry) -> Vector3:
    """Forward kinematics: the point where the three forearm spheres meet, upper solution.

    Args:
        angles: alpha of the arms 1, 2, 3 from the horizontal, outward, up positive [rad].
        geometry: of the rig.

    Returns:
        position of the platform point in earth NED about the flight-space centre [m].

    Raises:
        ValueError: the forearms do not reach each other, or the platform would be below the fold, where the
            two solutions change places; the message holds the angles.
    """
    ax, ay, az = _elbow(0, angles[0], geometry)
    bx, by, bz = _elbow(1, angles[1], geometry)
    cx, cy, cz = _elbow(2, angles[2], geometry)
    # axes of the triangle of sphere centres: i from 1 to 2, j toward 3, k = i x j downward
    dx, dy, dz = bx - ax, by - ay, bz - az
    gx, gy, gz = cx - ax, cy - ay, cz - az
    side = sqrt(dx * dx + dy * dy + dz * dz)
    if side < _SMALLEST:
        raise ValueError(f"arm angles {angles} rad: two elbows coincide")
    ix, iy, iz = dx / side, dy / side, dz / side
    along = ix * gx + iy * gy + iz * gz
    jx, jy, jz = gx - along * ix, gy - along * iy, gz - along * iz
    across = sqrt(jx * jx + jy * jy + jz * jz)
    if across < _SMALLEST:
        raise ValueError(f"arm angles {angles} rad: the elbows are in line")
    jx, jy, jz = jx / across, jy / across, jz / across
    kx, ky, kz = iy * jz - iz * jy, iz * jx - ix * jz, ix * jy - iy * jx
    x = 0.5 * side
    y = 0.5 * (along * along + across * across - along * side) / across
    square = geometry.forearm**2 - x * x - y * y
    if not square > _SMALLEST**2:
        raise ValueError(f"arm angles {angles} rad: the forearms do not meet")
    up = sqrt(square)
    position = (
        ax + x * ix + y * jx - up * kx,
        ay + x * iy + y * jy - up * ky,
        az + x * iz + y * jz - up * kz,
    )
    height = geometry.centre_height - position[2]
    if height <= geometry.fold_height:
        raise ValueError(
            f"arm angles {angles} rad: platform at {height:.3f} m, "
            f"not above the fold at {geometry.fold_height:.3f} m"
        )
    return position


def arms_from_position(position: Vector3, geometry: RigGeometry) -> Vector3:
    """Inverse kinematics: the arm angles with which `position_from_arms` gives this position.

    With the platform at distance o outward of the shifted pivot, s aside and H above it, the forearm's length
    makes o cos alpha + H sin alpha = e, where 2 l e = o^2 + s^2 + H^2 + l^2 - f^2; of its two roots the elbow
    further out is tan(alpha / 2) = (e - o) / (H + sqrt(o^2 + H^2 - e^2)).

    Args:
        position: of the platform point in earth NED about the flight-space centre [m].
        geometry: of the rig.

    Returns:
        alpha of the arms 1, 2, 3 from the horizontal, outward, up positive [rad].

    Raises:
        ValueError: an arm does not reach there, or the position does not come back from the angles because it
            is not above the fold or the posture is degenerate; the message holds the position.
    """
    north, east, down = position
    height = geometry.centre_height - down
    upper, forearm = geometry.upper_arm, geometry.forearm
    angles = []
    for along, across in _RADIAL:
        outward = north * along + east * across - (geometry.base_radius - geometry.platform_radius)
        aside = east * along - north * across
        excess = outward * outward + aside * aside + height * height + (upper - forearm) * (upper + forearm)
        needed = 0.5 * excess / upper
        square = outward * outward + height * height - needed * needed
        if not square >= 0.0:
            raise ValueError(f"position {position} m (NED) is out of the arms' reach")
        angles.append(2.0 * atan2(needed - outward, height + sqrt(square)))
    found = (angles[0], angles[1], angles[2])
    try:
        there = position_from_arms(found, geometry)
    except ValueError as error:
        raise ValueError(f"position {position} m (NED) does not come back from its angles: {error}") from None
    if dist(there, position) > ROUND_TRIP:
        raise ValueError(f"position {position} m (NED) is not above the fold of the arms")
    return found


def arm_jacobian(angles: Vector3, position: Vector3, geometry: RigGeometry) -> Matrix3:
    """d position / d angles, from the derivative of |p - c_i|^2 = f^2.

    With the forearm vectors s_i = p - c_i: s_i . dp = s_i . (dc_i / d alpha_i) d alpha_i, a linear system
    whose inverse has the columns s_j x s_k / det.

    Args:
        angles: alpha of the arms [rad].
        position: what `position_from_arms` gives for them [m].
        geometry: of the rig.

    Returns:
        rows north, east, down; columns arm 1, 2, 3 [m/rad].

    Raises:
        ValueError: the forearms lie in one plane, so the position has no derivative.
    """
    forearms = [_difference(position, _elbow(arm, angles[arm], geometry)) for arm in range(3)]
    crosses = [_cross(forearms[(arm + 1) % 3], forearms[(arm + 2) % 3]) for arm in range(3)]
    determinant = _dot(forearms[0], crosses[0])
    if abs(determinant) < _SMALLEST**3:
        raise ValueError(f"arm angles {angles} rad: the forearms lie in one plane")
    columns = []
    for arm in range(3):
        north, east = _RADIAL[arm]
        back, down = -geometry.upper_arm * sin(angles[arm]), -geometry.upper_arm * cos(angles[arm])
        pull = _dot(forearms[arm], (back * north, back * east, down)) / determinant
        columns.append((pull * crosses[arm][0], pull * crosses[arm][1], pull * crosses[arm][2]))
    a, b, c = columns
    return ((a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2]))


def position_variance(jacobian: Matrix3, angle_variance: float) -> Vector3:
    """Diagonal of J J' sigma^2: variance of north, east, down [m2].

    Args:
        jacobian: of `arm_jacobian` [m/rad].
        angle_variance: of every arm angle, errors independent of each other [rad2].
    """
    north, east, down = jacobian
    return (
        angle_variance * _dot(north, north),
        angle_variance * _dot(east, east),
        angle_variance * _dot(down, down),
    )


def _elbow(arm: int, angle: float, geometry: RigGeometry) -> Vector3:
    """Centre of the forearm sphere in earth NED [m]."""
    out = geometry.base_radius - geometry.platform_radius + geometry.upper_arm * cos(angle)
    north, east = _RADIAL[arm]
    return (out * north, out * east, geometry.centre_height - geometry.upper_arm * sin(angle))


def _difference(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _dot(a: Vector3, b: Vector3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
