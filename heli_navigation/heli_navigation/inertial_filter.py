"""The filter: one sample of encoders and IMU taken into position, velocity, attitude and biases.

Dead reckoning from the IMU, corrected by each encoder on its own. While the helicopter stands on its stop,
the biases are learnt instead; while there is no IMU, the helicopter goes on as it went.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_common.rig_geometry import RADIAN_PER_COUNT
from heli_navigation.alignment import leave_stand, stand
from heli_navigation.coasting import begin_coast, end_coast
from heli_navigation.corrections import correct
from heli_navigation.encoder_cells import line_of
from heli_navigation.error_covariance import grow
from heli_navigation.filter_memory import ENCODERS, Estimate, Memory, Work
from heli_navigation.filter_parameters import FilterConstants
from heli_navigation.gates import judge
from heli_navigation.strapdown import reckon

Array = NDArray[np.float64]

_GYRO, _FORCE, _LINE = int(Memory.gyro), int(Memory.force), int(Memory.line)
_G, _F = int(Estimate.gyro_bias), int(Estimate.force_bias)
_RATE, _PUSH, _ANGLE = int(Work.rate), int(Work.push), int(Work.angle)
_PLACE = int(Work.place)


@compiled
def filter_step(
    memory: Array,
    arm_1: float,
    arm_2: float,
    arm_3: float,
    yaw: float,
    pitch: float,
    roll: float,
    gyro_x: float,
    gyro_y: float,
    gyro_z: float,
    force_x: float,
    force_y: float,
    force_z: float,
    imu_valid: bool,
    box: Sequence[FilterConstants],
    work: Array,
) -> bool:
    """Take in one sample of all sensors, one period after the latest one.

    Args:
        memory: of the filter, in the parts of `Memory`, overwritten; begun by `first_memory`.
        arm_1: angle of the first arm [rad]; NaN for an encoder of which nothing came.
        arm_2: the same of the second.
        arm_3: the same of the third.
        yaw: angle of the gimbal [rad], or NaN.
        pitch: the same.
        roll: the same.
        gyro_x: body rate, FRD [rad/s].
        gyro_y: the same.
        gyro_z: the same.
        force_x: specific force at the IMU, FRD [m/s^2].
        force_y: the same.
        force_z: the same.
        imu_valid: whether the IMU's six numbers were measured at this sample.
        box: constants of the filter, boxed.
        work: scratch in the order of `Work`.

    Returns:
        False if the estimate has become meaningless: not finite, or where no arm reaches.
    """
    c = box[0]
    a = _ANGLE
    work[a], work[a + 1], work[a + 2], work[a + 3], work[a + 4], work[a + 5] = (
        arm_1,
        arm_2,
        arm_3,
        yaw,
        pitch,
        roll,
    )
    _watch(memory, work, c)
    if (
        memory[Memory.unchanged] >= c.still_time
        and imu_valid
        and stand(memory, gyro_x, gyro_y, gyro_z, force_x, force_y, force_z, c, work)
    ):
        return True
    if memory[Memory.standing] > 0.0:
        leave_stand(memory)
    _predict(memory, gyro_x, gyro_y, gyro_z, force_x, force_y, force_z, imu_valid, c, work)
    return correct(memory, c, work) and judge(memory, work[_PLACE + 2], work, c)


@compiled
def filter_run(memory: Array, samples: Array, box: Sequence[FilterConstants], work: Array) -> int:
    """Take in samples one after the other while all encoders are indexed and the estimate means something.

    Args:
        memory: of the filter, in the parts of `Memory`, overwritten; begun by `first_memory`.
        samples: (n, 18 or more) six counts, six flags of the index pulses, three rates [rad/s] and three
            specific forces [m/s^2], all of them measured.
        box: constants of the filter, boxed.
        work: scratch in the order of `Work`.

    Returns:
        how many samples were taken; -1 less the index of the one at which the estimate became meaningless.
    """
    for index in range(len(samples)):
        s = samples[index]
        for encoder in range(ENCODERS):
            if s[ENCODERS + encoder] < 0.5:
                return index
        if not filter_step(
            memory,
            s[0] * RADIAN_PER_COUNT,
            s[1] * RADIAN_PER_COUNT,
            s[2] * RADIAN_PER_COUNT,
            s[3] * RADIAN_PER_COUNT,
            s[4] * RADIAN_PER_COUNT,
            s[5] * RADIAN_PER_COUNT,
            s[12],
            s[13],
            s[14],
            s[15],
            s[16],
            s[17],
            True,
            box,
            work,
        ):
            return -1 - index
    return len(samples)


@compiled
def _watch(memory: Array, work: Array, c: FilterConstants) -> None:
    """Note for how long no count has changed."""
    memory[Memory.unchanged] += c.period
    for encoder in range(ENCODERS):
        angle = work[_ANGLE + encoder]
        if line_of(angle, c) != memory[_LINE + encoder]:  # true for NaN as well
            memory[Memory.unchanged] = 0.0


@compiled
def _predict(
    memory: Array,
    gyro_x: float,
    gyro_y: float,
    gyro_z: float,
    force_x: float,
    force_y: float,
    force_z: float,
    imu_valid: bool,
    c: FilterConstants,
    work: Array,
) -> None:
    """Dead reckoning and growth of the covariance over one sample."""
    estimate = memory[Memory.estimate : Memory.covariance]
    covariance = memory[Memory.covariance : Memory.gyro]
    t = c.period
    if not imu_valid:
        if memory[Memory.coasting] == 0.0:
            begin_coast(memory, c)
        memory[Memory.coasted] += t
        for axis in range(3):
            work[_RATE + axis] = -memory[_G + axis]
            work[_PUSH + axis] = 0.0
        work[_PUSH + 2] = -c.gravity
        reckon(estimate, t, c.gravity, work)
        grow(covariance, work, t, 0.0, c.coast_force * t, 0.0, c.coast_turn * t, c.accelerometer_walk * t)
        return
    if memory[Memory.coasting] > 0.0:
        end_coast(memory, gyro_x, gyro_y, gyro_z, force_x, force_y, force_z, c)
    g, f, r, s = _GYRO, _FORCE, _RATE, _PUSH
    work[r] = 0.5 * (memory[g] + gyro_x) - memory[_G]
    work[r + 1] = 0.5 * (memory[g + 1] + gyro_y) - memory[_G + 1]
    work[r + 2] = 0.5 * (memory[g + 2] + gyro_z) - memory[_G + 2]
    work[s] = 0.5 * (memory[f] + force_x) - memory[_F]
    work[s + 1] = 0.5 * (memory[f + 1] + force_y) - memory[_F + 1]
    work[s + 2] = 0.5 * (memory[f + 2] + force_z) - memory[_F + 2]
    memory[g], memory[g + 1], memory[g + 2] = gyro_x, gyro_y, gyro_z
    memory[f], memory[f + 1], memory[f + 2] = force_x, force_y, force_z
    reckon(estimate, t, c.gravity, work)
    grow(
        covariance,
        work,
        t,
        1.0,
        c.accelerometer_density * t,
        c.gyro_density * t,
        c.gyro_walk * t,
        c.accelerometer_walk * t,
    )
