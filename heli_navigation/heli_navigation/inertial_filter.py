"""The filter: one sample of encoders and IMU taken into position, velocity, attitude and biases.

Dead reckoning from the IMU, corrected by each encoder on its own: three arm angles through the derivative of
one arm, three angles of the gimbal. Every number is taken in by itself (sequential scalar updates), so one
that is missing or not believed is simply left out.

The arms measure the platform, which is the helicopter's centre of gravity; the IMU is at d from it. With the
motion of the IMU's place as what is estimated, p = p_IMU - C d and v = v_IMU - C (w x d) need no angular
acceleration.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.alignment import leave_stand, stand
from heli_navigation.arm_angle import OUT_OF_REACH, arm_angle
from heli_navigation.coasting import begin_coast, end_coast
from heli_navigation.encoder_cells import beyond_cell, cell_innovation_variance, line_of, passed
from heli_navigation.error_covariance import column_of_error, column_of_place, grow, hold, shrink, widen
from heli_navigation.filter_memory import ARMS, ENCODERS, SIZE, Estimate, Memory, Work
from heli_navigation.filter_parameters import FilterConstants
from heli_navigation.gates import believable, confirm_line, doubt_line, judge, trust_line
from heli_navigation.strapdown import lean, orient, reckon

Array = NDArray[np.float64]

_COVARIANCE = int(Memory.covariance)
_GYRO, _FORCE = int(Memory.gyro), int(Memory.force)
_LINE, _AGE, _LOST = int(Memory.line), int(Memory.age), int(Memory.lost)
_P, _V, _E = int(Estimate.position), int(Estimate.velocity), int(Estimate.angle)
_G, _F = int(Estimate.gyro_bias), int(Estimate.force_bias)
_BODY, _RATES, _LEAN = int(Work.body), int(Work.rates), int(Work.lean)
_RATE, _PUSH, _CORRECTION = int(Work.rate), int(Work.push), int(Work.correction)
_SLOPE, _ANGLE = int(Work.slope), int(Work.angle)
_PLACE, _SPEED, _TURNING = int(Work.place), int(Work.speed), int(Work.turning)

CURVATURE = 7.0
"""Second derivative of an arm's angle by the position [rad/m^2], 1.5 at the top and 6 at the bottom.

What the derivative leaves out, half of this times the square of the error, does not matter while three arms
hold the position to a millimetre; with two, it keeps them from telling what they cannot see.
"""

TWO_ARM_WALK = 0.0
"""Random walk [m/sqrt(s)] by which two arms alone lose the position: their curvature misleads a linear filter."""

OUTSIDE = 1.25
"""How far from the middle of a cell [counts] what is expected speaks against the cell that bounds it.

That is three deviations of two numbers both known to count / sqrt(12); a stuck encoder would else hold the
filter while the helicopter drifts.
"""


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
        memory: of the filter, in the parts of `Memory`, overwritten; begun by `begin`.
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
    if memory[_LOST] + memory[_LOST + 1] + memory[_LOST + 2] > 0.0:
        widen(memory[Memory.covariance : Memory.gyro], _P, TWO_ARM_WALK * TWO_ARM_WALK * c.period)
    return _correct(memory, c, work) and judge(memory, work[_PLACE + 2], work, c)


@compiled
def _watch(memory: Array, work: Array, c: FilterConstants) -> None:
    """Note for how long no count has changed."""
    memory[Memory.unchanged] += c.period
    for encoder in range(ENCODERS):
        angle = work[_ANGLE + encoder]
        if not line_of(angle, c) == memory[_LINE + encoder]:  # true for NaN as well
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


@compiled
def locate(memory: Array, c: FilterConstants, work: Array) -> None:
    """Write platform, its velocity and the gimbal's rates as they are now estimated, and what they turn with.

    Args:
        memory: of the filter, in the parts of `Memory`.
        c: constants of the filter.
        work: scratch in the order of `Work`; body, rates, lean (of the lever C d), rate, place, speed and
            turning are written.
    """
    orient(memory[_E], memory[_E + 1], memory[_E + 2], work)
    for axis in range(3):
        work[_RATE + axis] = memory[_GYRO + axis] - memory[_G + axis]
    p, q, r = work[_RATE], work[_RATE + 1], work[_RATE + 2]
    swing_x, swing_y, swing_z = q * c.z - r * c.y, r * c.x - p * c.z, p * c.y - q * c.x
    for axis in range(3):
        b, e = _BODY + 3 * axis, _RATES + 3 * axis
        lever = work[b] * c.x + work[b + 1] * c.y + work[b + 2] * c.z
        work[_PLACE + axis] = memory[_P + axis] - lever
        swing = work[b] * swing_x + work[b + 1] * swing_y + work[b + 2] * swing_z
        work[_SPEED + axis] = memory[_V + axis] - swing
        work[_TURNING + axis] = work[e] * p + work[e + 1] * q + work[e + 2] * r
    north, east, down = (
        memory[_P] - work[_PLACE],
        memory[_P + 1] - work[_PLACE + 1],
        memory[_P + 2] - work[_PLACE + 2],
    )
    lean(north, east, down, work)


@compiled
def _correct(memory: Array, c: FilterConstants, work: Array) -> bool:
    """Take in the six encoders one after the other; False if the estimate is meaningless."""
    covariance = memory[Memory.covariance : Memory.gyro]
    locate(memory, c, work)
    for index in range(SIZE):
        work[_CORRECTION + index] = 0.0
    for encoder in range(ENCODERS):
        memory[_AGE + encoder] += 1.0
        if not work[_ANGLE + encoder] == work[_ANGLE + encoder]:
            continue
        if encoder < ARMS:
            expected = arm_angle(encoder, work[_PLACE], work[_PLACE + 1], work[_PLACE + 2], c, work)
            if expected == OUT_OF_REACH:
                return False
            s, l, d = _SLOPE, _LEAN, _CORRECTION
            h6 = -(work[s] * work[l] + work[s + 1] * work[l + 3] + work[s + 2] * work[l + 6])
            h7 = -(work[s] * work[l + 1] + work[s + 1] * work[l + 4] + work[s + 2] * work[l + 7])
            h8 = -(work[s] * work[l + 2] + work[s + 1] * work[l + 5] + work[s + 2] * work[l + 8])
            rate = work[s] * work[_SPEED] + work[s + 1] * work[_SPEED + 1] + work[s + 2] * work[_SPEED + 2]
            expected += work[s] * work[d] + work[s + 1] * work[d + 1] + work[s + 2] * work[d + 2]
            expected += h6 * work[d + _E] + h7 * work[d + _E + 1] + h8 * work[d + _E + 2]
            variance = column_of_place(covariance, work[s], work[s + 1], work[s + 2], h6, h7, h8, work)
            spread = CURVATURE * (covariance[0] + covariance[SIZE + 1] + covariance[2 * SIZE + 2])
            bent = 0.75 * spread * spread
        else:
            index = _E + encoder - ARMS
            rate = work[_TURNING + encoder - ARMS]
            expected = memory[index] + work[_CORRECTION + index]
            variance, bent = column_of_error(covariance, index, work), 0.0
        _weigh(memory, encoder, expected, rate, variance, bent, c, work)
    total = 0.0
    for index in range(SIZE):
        memory[index] += work[_CORRECTION + index]
        total += memory[index]
    return bool(abs(total) < 1e6)  # False for NaN


@compiled
def _weigh(
    memory: Array,
    encoder: int,
    expected: float,
    rate: float,
    variance: float,
    bent: float,
    c: FilterConstants,
    work: Array,
) -> None:
    """Decide what one encoder's count says beside what is expected, and take it in."""
    covariance = memory[Memory.covariance : Memory.gyro]
    line, before, age = line_of(work[_ANGLE + encoder], c), memory[_LINE + encoder], memory[_AGE + encoder]
    lost = memory[Memory.lost + encoder] > 0.0
    undecided = encoder >= ARMS and memory[Memory.silent + encoder - ARMS] > 0.0
    memory[_LINE + encoder], memory[_AGE + encoder] = line, 0.0
    if line != before:
        if age > 1.0:  # passed some time ago, nobody knows when
            measured, noise = line * c.count, c.cell_variance
        else:
            measured, noise = passed(line, before, rate, c)
        innovation, total = measured - expected, variance + noise + bent
        inside = believable(innovation, total, c)
        memory[Memory.innovation + encoder] = innovation / np.sqrt(total)
        if lost:
            trust_line(memory, encoder, line - before, innovation, inside, c)
        elif inside:
            confirm_line(memory, encoder)
            shrink(covariance, innovation, total, work)
        else:
            doubt_line(memory, encoder, c)
    elif not lost:
        off = beyond_cell(expected, line, c)
        if not believable(off, variance + c.line_variance + bent, c):
            memory[Memory.doubt + encoder] += c.period
        elif variance > c.cell_variance and not undecided:
            innovation = line * c.count - expected
            if abs(innovation) > OUTSIDE * c.count:
                memory[Memory.doubt + encoder] += c.period
            (shrink if memory[_LOST] + memory[_LOST + 1] + memory[_LOST + 2] > 0.0 else hold)(covariance, innovation, cell_innovation_variance(variance, c) + bent, work)
