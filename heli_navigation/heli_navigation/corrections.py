"""What the six encoders correct: each number is taken in by itself (sequential scalar updates).

Three arm angles through the derivative of one arm each, three angles of the gimbal directly; one that is
missing or not believed is simply left out.

The arms measure the platform, which is the helicopter's centre of gravity; the IMU is at d from it. With the
motion of the IMU's place as what is estimated, p = p_IMU - C d and v = v_IMU - C (w x d) need no angular
acceleration.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.arm_angle import OUT_OF_REACH, arm_angle
from heli_navigation.encoder_cells import beyond_cell, cell_innovation_variance, line_of, passed
from heli_navigation.error_covariance import column_of_error, column_of_place, hold, shrink
from heli_navigation.filter_memory import ARMS, ENCODERS, SIZE, Estimate, Memory, Work
from heli_navigation.filter_parameters import FilterConstants
from heli_navigation.gates import CALM, believable, confirm_line, doubt_line, trust_line
from heli_navigation.strapdown import lean, orient

Array = NDArray[np.float64]

_LINE, _AGE, _LOST, _GYRO = int(Memory.line), int(Memory.age), int(Memory.lost), int(Memory.gyro)
_P, _V, _E = int(Estimate.position), int(Estimate.velocity), int(Estimate.angle)
_G = int(Estimate.gyro_bias)
_BODY, _RATES, _LEAN, _RATE = int(Work.body), int(Work.rates), int(Work.lean), int(Work.rate)
_CORRECTION, _SLOPE, _ANGLE = int(Work.correction), int(Work.slope), int(Work.angle)
_PLACE, _SPEED, _TURNING = int(Work.place), int(Work.speed), int(Work.turning)

CURVATURE = 7.0
"""Second derivative of an arm's angle by the position [rad/m^2]: 1.5 at the top, 6 at the bottom.

What the derivative leaves out, half of this times the square of the error, does not matter while three arms
hold the position to a millimetre; with two, it keeps them from telling what they cannot see. Rather more than
less, because it recurs line after line and is no noise.
"""

OUTSIDE = 1.25
"""How far from the middle of a cell [counts] what is expected speaks against the cell that bounds it.

That is three deviations of two numbers both known to count / sqrt(12); a stuck encoder would else hold the
filter while the helicopter drifts.
"""


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
def correct(memory: Array, c: FilterConstants, work: Array) -> bool:
    """Take in the six encoders one after the other; False if the estimate is meaningless.

    Args:
        memory: of the filter, in the parts of `Memory`, overwritten.
        c: constants of the filter.
        work: scratch in the order of `Work`; angle, the readings, is read, NaN where nothing came.
    """
    covariance = memory[Memory.covariance : Memory.gyro]
    locate(memory, c, work)
    for index in range(SIZE):
        work[_CORRECTION + index] = 0.0
    for encoder in range(ENCODERS):
        memory[_AGE + encoder] += 1.0
        if math.isnan(work[_ANGLE + encoder]):
            continue
        if encoder < ARMS:
            expected = arm_angle(encoder, work[_PLACE], work[_PLACE + 1], work[_PLACE + 2], c, work)
            if expected == OUT_OF_REACH:
                return False
            s, k, d = _SLOPE, _LEAN, _CORRECTION
            h6 = -(work[s] * work[k] + work[s + 1] * work[k + 3] + work[s + 2] * work[k + 6])
            h7 = -(work[s] * work[k + 1] + work[s + 1] * work[k + 4] + work[s + 2] * work[k + 7])
            h8 = -(work[s] * work[k + 2] + work[s + 1] * work[k + 5] + work[s + 2] * work[k + 8])
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
def _needs_cells(memory: Array) -> bool:
    """Whether cells shall tell of velocity and biases too.

    They shall if an arm's encoder is lost, if there is no IMU, or soon after its accelerometers have jumped.
    Otherwise they do not: the cell of an encoder that is stuck, and not yet found out, would mislead them.
    """
    missing = memory[_LOST] + memory[_LOST + 1] + memory[_LOST + 2] + memory[Memory.coasting]
    return bool(missing > 0.0 or memory[Memory.calm] < CALM)


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
    undecided = memory[Memory.silent + encoder] > 0.0
    memory[_LINE + encoder], memory[_AGE + encoder] = line, 0.0
    if line != before:
        if age > 1.0:  # passed some time ago, nobody knows when
            measured, noise = line * c.cell, c.cell_variance
        else:
            measured, noise = passed(line, before, rate, c)
        innovation, total = measured - expected, variance + noise + bent
        inside = believable(innovation, total, c)
        memory[Memory.innovation + encoder] = innovation / math.sqrt(total)
        if lost:
            trust_line(memory, encoder, line - before, innovation, inside, c)
        elif inside:
            confirm_line(memory, encoder)
            shrink(covariance, innovation, total, work)
        else:
            doubt_line(memory, encoder, line - before, c)
    elif not lost:
        off = beyond_cell(expected, line, c)
        if not believable(off, variance + c.line_variance + bent, c):
            memory[Memory.doubt + encoder] += c.period
        elif variance > c.cell_variance and not undecided:
            innovation = line * c.cell - expected
            if abs(innovation) > OUTSIDE * c.cell:
                memory[Memory.doubt + encoder] += c.period
            total = cell_innovation_variance(variance, c) + bent
            if _needs_cells(memory):
                shrink(covariance, innovation, total, work)
            else:
                hold(covariance, innovation, total, work)
