"""Error budget of the encoders: how well whole counts can tell position and attitude (spec 2.1, 2.2).

An angle read in whole counts is wrong by up to half a count either way, evenly spread: variance count^2 / 12,
independent from arm to arm. Through the arms' Jacobian J the position has the covariance

    P = J J' count^2 / 12

The three half counts that can come together are a vector of at most sqrt(3)/2 count = 3 count / sqrt(12).
By Cauchy-Schwarz three sigma of the position in any direction is therefore not only a deviation but the
farthest a platform at rest can be from where it is read; the curvature of the kinematics adds 3 % at the
bottom of the work space.

The gimbal's encoders read yaw, pitch and roll themselves, so attitude is known equally well everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import cos, pi, sin, sqrt

import numpy as np

from heli_common.rig_geometry import QUANTISATION_VARIANCE, RADIAN_PER_COUNT, RigGeometry
from heli_common.rotations import Euler, Matrix3, Vector3
from heli_navigation.arm_kinematics import arm_jacobian, arms_from_position

AZIMUTHS = tuple(index * pi / 36.0 for index in range(72))
"""Where a ring of the work space is searched for its worst point: every 5 deg [rad]."""


@dataclass(frozen=True)
class PositionError:
    """What the arms' counts make of one position."""

    per_count: Vector3
    """how far the platform moves per count of arm 1, 2, 3 alone [m]"""
    covariance: Matrix3
    """of north, east, down [m2]"""
    three_sigma: Vector3
    """of north, east, down [m]"""
    worst: float
    """three sigma along the worst direction [m]"""
    worst_direction: Vector3
    """that direction, unit vector NED; either sign"""


@dataclass(frozen=True)
class RingError:
    """The largest errors on a horizontal circle about the work space's axis, each where it is largest."""

    height: float
    """above the base plane [m]"""
    radius: float
    """from the axis [m]"""
    per_count: float
    """displacement per count of one arm [m]"""
    north: float
    """three sigma [m]"""
    east: float
    """three sigma [m]"""
    down: float
    """three sigma [m]"""
    worst: float
    """three sigma along the worst direction [m]"""
    azimuth: float
    """where on the circle `worst` is first met, from north toward east [rad]"""


def position_error(position: Vector3, geometry: RigGeometry) -> PositionError:
    """Error of a position from the quantisation of the three arm angles.

    Args:
        position: of the platform point in earth NED about the flight-space centre [m].
        geometry: of the rig.

    Raises:
        ValueError: the arms do not reach there.
    """
    jacobian = np.array(arm_jacobian(arms_from_position(position, geometry), position, geometry))
    covariance = jacobian @ jacobian.T * QUANTISATION_VARIANCE
    variances, directions = np.linalg.eigh(covariance)
    rows = covariance.tolist()
    return PositionError(
        per_count=_three(np.linalg.norm(jacobian, axis=0) * RADIAN_PER_COUNT),
        covariance=(tuple(rows[0]), tuple(rows[1]), tuple(rows[2])),
        three_sigma=_three(3.0 * np.sqrt(np.diag(covariance))),
        worst=3.0 * sqrt(variances[-1]),
        worst_direction=_three(directions[:, -1]),
    )


def attitude_three_sigma() -> Euler:
    """Three sigma of yaw, pitch and roll [rad], anywhere; the error itself never exceeds half a count."""
    sigma = sqrt(QUANTISATION_VARIANCE)
    return Euler(3.0 * sigma, 3.0 * sigma, 3.0 * sigma)


def ring_error(
    height: float, radius: float, geometry: RigGeometry, azimuths: Sequence[float] = AZIMUTHS
) -> RingError:
    """The largest errors on one circle.

    Args:
        height: above the base plane [m].
        radius: from the axis [m], 0 or more.
        geometry: of the rig.
        azimuths: where on the circle to look [rad], at least one.

    Raises:
        ValueError: the arms do not reach there.
    """
    down = geometry.centre_height - height
    places = azimuths if radius > 0.0 else azimuths[:1]
    errors = [
        position_error((radius * cos(azimuth), radius * sin(azimuth), down), geometry) for azimuth in places
    ]
    worst = max(error.worst for error in errors)
    # places alike by the rig's symmetry differ by rounding: the first of them
    first = next(index for index, error in enumerate(errors) if error.worst > (1.0 - 1e-9) * worst)
    return RingError(
        height=height,
        radius=radius,
        per_count=max(max(error.per_count) for error in errors),
        north=max(error.three_sigma[0] for error in errors),
        east=max(error.three_sigma[1] for error in errors),
        down=max(error.three_sigma[2] for error in errors),
        worst=worst,
        azimuth=places[first],
    )


def budget(
    heights: Sequence[float],
    radii: Sequence[float],
    geometry: RigGeometry,
    azimuths: Sequence[float] = AZIMUTHS,
) -> tuple[RingError, ...]:
    """The largest errors on circles at all heights and radii, heights in the outer loop.

    Args:
        heights: above the base plane [m].
        radii: from the axis [m].
        geometry: of the rig.
        azimuths: where on each circle to look [rad].

    Raises:
        ValueError: the arms do not reach one of them.
    """
    return tuple(ring_error(height, radius, geometry, azimuths) for height in heights for radius in radii)


def steps(low: float, high: float, number: int) -> Iterator[float]:
    """Evenly spaced values, both ends exactly included.

    Args:
        low: the first.
        high: the last.
        number: how many, at least 2.
    """
    for index in range(number):
        share = index / (number - 1)
        yield low * (1.0 - share) + high * share


def _three(values: object) -> Vector3:
    a, b, c = np.asarray(values, dtype=np.float64).tolist()
    return (a, b, c)
