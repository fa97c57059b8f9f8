"""Standstill, seen by the IMU alone: nothing spreads more than noise, so the gyros read their biases.

A window of readings is a standstill if on no axis the variance exceeds that of the IMU's noise by more than a
margin, and if the mean rates are what the biases may be; else it may be a steady turn. Accelerometer z is not
asked, because on the stop the helicopter may still sway a little up and down. The rotor shakes accelerometers
x and y as soon as it turns at a good third of its speed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.imu_attitude_equations import ROWS, STILL_AXES, AttitudeMemory, absorb, cell
from heli_navigation.imu_attitude_parameters import STILL_SAMPLES, ImuAttitudeConstants

Array = NDArray[np.float64]


@compiled
def rest(memory: Array, c: ImuAttitudeConstants) -> None:
    """At the end of a window: if the helicopter stood, the mean rates are the biases.

    Args:
        memory: of the filter, overwritten.
        c: constants of the filter.
    """
    count = memory[AttitudeMemory.still_count]
    still = True
    for axis in range(STILL_AXES):
        total, square = memory[AttitudeMemory.still_sum + axis], memory[AttitudeMemory.still_square + axis]
        variance = (square - total * total / count) / (count - 1.0)
        still = still and variance < (c.still_gyro if axis < 3 else c.still_force)
    for axis in range(3):
        turn = memory[AttitudeMemory.still_sum + axis] / count - memory[AttitudeMemory.gyro_bias + axis]
        variance = memory[cell(3 + axis, 3 + axis)] + c.still_variance
        still = still and turn * turn <= c.still_gate * variance
    if not still:
        return
    memory[AttitudeMemory.standstills] += 1.0
    for axis in range(3):
        for row in range(ROWS):
            memory[AttitudeMemory.product + row] = memory[cell(3 + axis, row)]
        turn = memory[AttitudeMemory.still_sum + axis] / count - memory[AttitudeMemory.gyro_bias + axis]
        absorb(memory, memory[cell(3 + axis, 3 + axis)] + c.still_variance, turn)


@compiled
def forget_window(memory: Array) -> None:
    """Begin a window of standstill.

    Args:
        memory: of the filter, overwritten.
    """
    for index in range(AttitudeMemory.still_count, AttitudeMemory.standstills):
        memory[index] = 0.0


@compiled
def wait(
    memory: Array, gyro: tuple[float, float, float], fx: float, fy: float, c: ImuAttitudeConstants
) -> None:
    """Put a sample into the window of standstill, and judge the window when it is full.

    Args:
        memory: of the filter, overwritten.
        gyro: readings [rad/s].
        fx: reading of accelerometer x [m/s^2].
        fy: of accelerometer y.
        c: constants of the filter.
    """
    for axis in range(STILL_AXES):
        value = gyro[axis] if axis < 3 else (fx if axis == 3 else fy)
        memory[AttitudeMemory.still_sum + axis] += value
        memory[AttitudeMemory.still_square + axis] += value * value
    memory[AttitudeMemory.still_count] += 1.0
    if memory[AttitudeMemory.still_count] >= STILL_SAMPLES:
        rest(memory, c)
        forget_window(memory)
