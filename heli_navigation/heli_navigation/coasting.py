"""Without IMU: the helicopter turns on as it turned, and flies as its attitude lets it.

The three estimates of the gyros' biases stand in for the rates while nothing measures those: with a reading
of zero, a bias of -w is a rate of w. Their errors stay what they were, the noise of a gyro's last sample
comes to it, and from then on an unknown angular acceleration, a white noise, lets them grow.

The accelerometers are replaced by what they read in any slow flight, (0, 0, -g), with a white noise for all
else that pushes. When the IMU comes back the biases are those from before, a little less certain.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.error_covariance import renew, widen
from heli_navigation.filter_memory import SIZE, Estimate, Memory
from heli_navigation.filter_parameters import FilterConstants

Array = NDArray[np.float64]

_COVARIANCE, _GYRO, _FORCE = int(Memory.covariance), int(Memory.gyro), int(Memory.force)
_KEPT, _KEPT_VARIANCE = int(Memory.kept_bias), int(Memory.kept_variance)
_G = int(Estimate.gyro_bias)


@compiled
def begin_coast(memory: Array, c: FilterConstants) -> None:
    """The IMU has gone: keep the biases, turn the rates into them.

    Args:
        memory: of the filter, in the parts of `Memory`.
        c: constants of the filter.
    """
    covariance = memory[Memory.covariance : Memory.gyro]
    for axis in range(3):
        memory[_KEPT + axis] = memory[_G + axis]
        memory[_KEPT_VARIANCE + axis] = covariance[(SIZE + 1) * (_G + axis)]
        memory[_G + axis] -= memory[_GYRO + axis]
        memory[_GYRO + axis] = 0.0
    widen(covariance, _G, c.gyro_density / c.period)
    memory[Memory.coasting], memory[Memory.coasted] = 1.0, 0.0


@compiled
def end_coast(
    memory: Array,
    gyro_x: float,
    gyro_y: float,
    gyro_z: float,
    force_x: float,
    force_y: float,
    force_z: float,
    c: FilterConstants,
) -> None:
    """The IMU is back: its first reading stands for the one before it too.

    Args:
        memory: of the filter, in the parts of `Memory`.
        gyro_x: reading, body FRD [rad/s].
        gyro_y: the same.
        gyro_z: the same.
        force_x: reading, body FRD [m/s^2].
        force_y: the same.
        force_z: the same.
        c: constants of the filter.
    """
    covariance = memory[Memory.covariance : Memory.gyro]
    renew(covariance, _G, 0.0)
    for axis in range(3):
        memory[_G + axis] = memory[_KEPT + axis]
        variance = memory[_KEPT_VARIANCE + axis] + c.gyro_walk * memory[Memory.coasted]
        covariance[(SIZE + 1) * (_G + axis)] = variance
    memory[_GYRO], memory[_GYRO + 1], memory[_GYRO + 2] = gyro_x, gyro_y, gyro_z
    memory[_FORCE], memory[_FORCE + 1], memory[_FORCE + 2] = force_x, force_y, force_z
    memory[Memory.coasting] = 0.0
