"""The beginning: gyro biases from the rest before it, then a first estimate from six absolute counts."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_common.rotations import Vector3
from heli_navigation.arm_kinematics import arm_jacobian, position_from_arms
from heli_navigation.filter_memory import SIZE, Estimate, Memory, Work, blank_memory
from heli_navigation.filter_parameters import FilterConstants
from heli_navigation.strapdown import orient

Array = NDArray[np.float64]

ENOUGH = 0.5
"""Shortest time at rest whose mean is believed [s]."""

BEGINNING_SPEED = 0.3
"""Deviation of the velocity when the filter begins [m/s]: the hand may just be at work."""

LONG_AGO = 1e3
"""Time since something that has never happened [s]."""

CAUTION = 4.0
"""Factor on the variance of the mean: a hand may already have been at work within the cells."""


class FirstRest:
    """Means of the gyros whenever no encoder has changed its count for a while.

    Args:
        period: of the samples [s].
        still_time: for which no count may have changed [s].
    """

    def __init__(self, period: float, still_time: float) -> None:
        self._period, self._still_time = period, still_time
        self._angles: tuple[float, ...] = ()
        self._unchanged = 0.0
        self._sum = np.zeros(3)
        self._samples = 0

    @property
    def time(self) -> float:
        """For which the gyros have been averaged [s]."""
        return self._samples * self._period

    def add(self, angles: Sequence[float], gyro: Sequence[float]) -> None:
        """One more sample.

        Args:
            angles: of the six encoders, absolute or not [rad].
            gyro: (3,) body rates, FRD [rad/s].
        """
        now = tuple(angles)
        self._unchanged = self._unchanged + self._period if now == self._angles else 0.0
        self._angles = now
        if self._unchanged >= self._still_time:
            self._sum += gyro
            self._samples += 1

    def bias(self, density: float, prior: float) -> tuple[Array, float]:
        """(3,) biases [rad/s] and the variance of each [rad^2/s^2].

        Args:
            density: square of the gyros' noise density [rad^2/s].
            prior: variance of a bias about which nothing is known [rad^2/s^2].
        """
        if self.time < ENOUGH:
            return np.zeros(3), prior
        return self._sum / self._samples, CAUTION * density / self.time


def first_memory(
    arms: Vector3,
    gimbal: Vector3,
    gyro: Vector3,
    force: Vector3,
    bias: tuple[Array, float],
    c: FilterConstants,
    geometry: RigGeometry,
) -> Array:
    """What the filter begins with: where the counts say, each angle in the middle of its cell.

    Args:
        arms: angles of the arms, absolute [rad].
        gimbal: yaw, pitch, roll, absolute [rad].
        gyro: (3,) reading, body FRD [rad/s].
        force: (3,) reading of the accelerometers, body FRD [m/s^2].
        bias: of the gyros and the variance of each, from `FirstRest.bias`.
        c: constants of the filter.
        geometry: of the rig.

    Returns:
        memory of the filter, in the parts of `Memory`.

    Raises:
        ValueError: the arms' angles fit no position.
    """
    memory, work = blank_memory(), np.zeros(Work.end)
    position = position_from_arms(arms, geometry)
    jacobian = np.array(arm_jacobian(arms, position, geometry))
    orient(*gimbal, work)
    body = work[Work.body : Work.rates].reshape(3, 3)
    lever = body @ (c.x, c.y, c.z)
    slope = lever_slope(lever, body)
    v, e, g, f = Estimate.velocity, Estimate.angle, Estimate.gyro_bias, Estimate.force_bias
    memory[:v], memory[e:g], memory[g:f] = np.array(position) + lever, gimbal, bias[0]
    covariance = np.zeros((SIZE, SIZE))
    covariance[:v, :v] = (jacobian @ jacobian.T + slope @ slope.T) * c.cell_variance
    covariance[:v, e:g] = slope * c.cell_variance
    covariance[e:g, :v] = covariance[:v, e:g].T
    variances = (BEGINNING_SPEED**2, c.cell_variance, bias[1], c.accelerometer_bias)
    covariance[range(v, SIZE), range(v, SIZE)] = np.repeat(variances, 3)
    memory[Memory.covariance : Memory.gyro] = covariance.ravel()
    memory[Memory.gyro : Memory.force], memory[Memory.force : Memory.line] = gyro, force
    memory[Memory.line : Memory.age] = np.floor(np.array((*arms, *gimbal)) / c.cell + 0.5)
    memory[Memory.calm] = LONG_AGO
    return memory


def lever_slope(lever: Array, body: Array) -> Array:
    """(3, 3) derivative of a vector fixed in the body by yaw, pitch and roll: gimbal axis x vector.

    Args:
        lever: (3,) the vector in NED.
        body: (3, 3) C_nb, body to earth.
    """
    right = np.array([-body[1, 0], body[0, 0], 0.0]) / math.hypot(body[0, 0], body[1, 0])
    axes = (np.array([0.0, 0.0, 1.0]), right, body[:, 0])
    return np.stack([np.cross(axis, lever) for axis in axes], axis=1)


def sensor_parts(sample: Array) -> tuple[list[float], list[float], list[float], list[float], list[float]]:
    """Angles of arms and gimbal [rad], flags, rates and forces of one sample of `InertialNavigation.run`.

    Args:
        sample: (18 or more,) counts first.
    """
    s: list[float] = sample.tolist()
    angles = [count * RADIAN_PER_COUNT for count in s[0:6]]
    return angles[0:3], angles[3:6], s[6:12], s[12:15], s[15:18]
