"""What is summed up of IMU and encoders from sample to sample; what comes of it stands in `imu_monitor`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.imu_attitude_parameters import ImuAttitudeConstants

Array = NDArray[np.float64]

AXES = 6
"""Gyros x, y, z [rad/s], accelerometers x, y, z [m/s^2], body FRD."""

DIFFERENCES = 6
"""How often a reading is differenced to leave its noise."""

DIFFERENCE_GAIN = math.comb(2 * DIFFERENCES, DIFFERENCES)
"""Variance of white noise after so many differences, over that before."""

SPREAD_SAMPLES = 40
"""Length of the windows in which vibration is looked for; 0.1 s."""

SHORT_SAMPLES, LONG_SAMPLES = 400, 4000
"""Lengths of the windows of the Allan deviation; 1 s and 10 s."""


class AllanPart(IntEnum):
    """Where each part of an Allan deviation begins."""

    count = 0
    """samples in the window"""
    total = 1
    """(6,) over them"""
    windows = 7
    """that followed each other without a gap, so far"""
    mean = 8
    """(6,) of the window before"""
    pairs = 14
    """of neighbouring windows"""
    square = 15
    """(6,) of the differences of their means"""
    end = 21


class MonitorMemory(IntEnum):
    """What the monitor remembers: where each part begins; it reaches to the beginning of the next."""

    run = 0
    """valid samples since the last gap"""
    reading = 1
    """(6,) of the IMU, this sample [rad/s], [m/s^2]"""
    angles = reading + AXES
    """(3,) psi, theta, phi of the encoders, this sample [rad]"""
    before = angles + 3
    """(6,) gyros [rad/s] and angles [rad] of the sample before"""
    beyond = before + 6
    """(6,) what the IMU reads beyond the encoders since then"""
    differences = beyond + AXES
    """(6, 6) latest reading of every axis and its differences"""
    samples = differences + AXES * DIFFERENCES
    """that the sums are taken over"""
    total = samples + 1
    """(6,) of what the IMU reads beyond the encoders"""
    noise_samples = total + AXES
    noise_square = noise_samples + 1
    """(6,) of the sixth differences"""
    spread_count = noise_square + AXES
    """samples in the window of the spread"""
    spread_total = spread_count + 1
    spread_square = spread_total + AXES
    spreads = spread_square + AXES
    """windows of the spread"""
    variance = spreads + 1
    """(6,) of the readings, summed up over the windows"""
    short = variance + AXES
    """Allan deviation over 1 s, in the parts of `AllanPart`"""
    long = short + AllanPart.end
    """the same over 10 s"""
    end = long + AllanPart.end


@compiled
def compare(memory: Array, c: ImuAttitudeConstants) -> None:
    """What the IMU reads beyond the encoders since the sample before, which was valid.

    Args:
        memory: of the monitor, in the parts of `MonitorMemory`, overwritten.
        c: constants of the filter.
    """
    new, now, old, out = (
        MonitorMemory.reading,
        MonitorMemory.angles,
        MonitorMemory.before,
        MonitorMemory.beyond,
    )
    yaw = memory[now] - memory[old + 3]
    if yaw > math.pi:
        yaw -= 2.0 * math.pi
    elif yaw < -math.pi:
        yaw += 2.0 * math.pi
    pitch, roll = memory[now + 1] - memory[old + 4], memory[now + 2] - memory[old + 5]
    theta, phi = memory[now + 1] - 0.5 * pitch, memory[now + 2] - 0.5 * roll
    sin_theta, cos_theta, sin_phi, cos_phi = math.sin(theta), math.cos(theta), math.sin(phi), math.cos(phi)
    turns = (
        roll - yaw * sin_theta,
        pitch * cos_phi + yaw * cos_theta * sin_phi,
        -pitch * sin_phi + yaw * cos_theta * cos_phi,
    )
    for axis in range(3):
        memory[out + axis] = 0.5 * (memory[new + axis] + memory[old + axis]) - turns[axis] / c.period
    p, q, r = memory[new], memory[new + 1], memory[new + 2]
    p_rate = (p - memory[old]) / c.period
    q_rate = (q - memory[old + 1]) / c.period
    r_rate = (r - memory[old + 2]) / c.period
    along, square = p * c.x + q * c.y + r * c.z, p * p + q * q + r * r
    theta, phi = memory[now + 1], memory[now + 2]
    level = c.gravity * math.cos(theta)
    expected = (
        (p * along - c.x * square) + (q_rate * c.z - r_rate * c.y) + c.gravity * math.sin(theta),
        (q * along - c.y * square) + (r_rate * c.x - p_rate * c.z) - level * math.sin(phi),
        (r * along - c.z * square) + (p_rate * c.y - q_rate * c.x) - level * math.cos(phi),
    )
    for axis in range(3):
        memory[out + 3 + axis] = memory[new + 3 + axis] - expected[axis]


@compiled
def allan_step(memory: Array, first: int, length: int) -> None:
    """Take into an Allan deviation what the IMU reads beyond the encoders.

    Args:
        memory: of the monitor, overwritten.
        first: where the deviation begins in it.
        length: of its windows, in samples.
    """
    for axis in range(AXES):
        memory[first + AllanPart.total + axis] += memory[MonitorMemory.beyond + axis]
    memory[first + AllanPart.count] += 1.0
    if memory[first + AllanPart.count] < length:
        return
    paired = memory[first + AllanPart.windows] > 0.5
    for axis in range(AXES):
        mean = memory[first + AllanPart.total + axis] / length
        if paired:
            step = mean - memory[first + AllanPart.mean + axis]
            memory[first + AllanPart.square + axis] += step * step
        memory[first + AllanPart.mean + axis] = mean
        memory[first + AllanPart.total + axis] = 0.0
    memory[first + AllanPart.count] = 0.0
    memory[first + AllanPart.windows] += 1.0
    memory[first + AllanPart.pairs] += 1.0 if paired else 0.0


@compiled
def spread_step(memory: Array) -> None:
    """Take the reading into the window of the spread.

    Args:
        memory: of the monitor, overwritten.
    """
    count = memory[MonitorMemory.spread_count] + 1.0
    full = count >= SPREAD_SAMPLES
    for axis in range(AXES):
        value = memory[MonitorMemory.reading + axis]
        total = memory[MonitorMemory.spread_total + axis] + value
        square = memory[MonitorMemory.spread_square + axis] + value * value
        if full:
            memory[MonitorMemory.variance + axis] += (square - total * total / count) / (count - 1.0)
        memory[MonitorMemory.spread_total + axis] = 0.0 if full else total
        memory[MonitorMemory.spread_square + axis] = 0.0 if full else square
    memory[MonitorMemory.spread_count] = 0.0 if full else count
    memory[MonitorMemory.spreads] += 1.0 if full else 0.0


@compiled
def noise_step(memory: Array) -> None:
    """Difference the reading six times.

    Args:
        memory: of the monitor, overwritten.
    """
    complete = memory[MonitorMemory.run] >= DIFFERENCES
    for axis in range(AXES):
        value = memory[MonitorMemory.reading + axis]
        for order in range(DIFFERENCES):
            at = MonitorMemory.differences + DIFFERENCES * axis + order
            value, memory[at] = value - memory[at], value
        if complete:
            memory[MonitorMemory.noise_square + axis] += value * value
    memory[MonitorMemory.noise_samples] += 1.0 if complete else 0.0


@compiled
def begin_run(memory: Array) -> None:
    """Forget what would reach across a gap.

    Args:
        memory: of the monitor, overwritten.
    """
    memory[MonitorMemory.run] = 0.0
    for index in range(MonitorMemory.spread_count, MonitorMemory.spreads):
        memory[index] = 0.0
    for first in (MonitorMemory.short, MonitorMemory.long):
        for index in range(first, first + AllanPart.mean):
            memory[index] = 0.0


@compiled
def monitor_step(
    memory: Array,
    psi: float,
    theta: float,
    phi: float,
    gx: float,
    gy: float,
    gz: float,
    fx: float,
    fy: float,
    fz: float,
    valid: bool,
    box: Sequence[ImuAttitudeConstants],
) -> bool:
    """Take in one sample; False, and nothing changed, if a valid one is not finite.

    Args:
        memory: of the monitor, in the parts of `MonitorMemory`, overwritten.
        psi: yaw of the encoders [rad].
        theta: pitch of the encoders.
        phi: roll of the encoders.
        gx: gyro x, body FRD [rad/s].
        gy: gyro y.
        gz: gyro z.
        fx: accelerometer x, body FRD [m/s^2].
        fy: accelerometer y.
        fz: accelerometer z.
        valid: whether all were measured; if not they are not looked at.
        box: constants of the filter, boxed.
    """
    if not valid:
        begin_run(memory)
        return True
    if not math.isfinite(psi + theta + phi + gx + gy + gz + fx + fy + fz):
        return False
    at = MonitorMemory.reading
    for axis in range(3):
        memory[MonitorMemory.before + axis] = memory[at + axis]
        memory[MonitorMemory.before + 3 + axis] = memory[MonitorMemory.angles + axis]
    memory[at], memory[at + 1], memory[at + 2] = gx, gy, gz
    memory[at + 3], memory[at + 4], memory[at + 5] = fx, fy, fz
    at = MonitorMemory.angles
    memory[at], memory[at + 1], memory[at + 2] = psi, theta, phi
    if memory[MonitorMemory.run] > 0.5:
        compare(memory, box[0])
        for axis in range(AXES):
            memory[MonitorMemory.total + axis] += memory[MonitorMemory.beyond + axis]
        memory[MonitorMemory.samples] += 1.0
        allan_step(memory, MonitorMemory.short, SHORT_SAMPLES)
        allan_step(memory, MonitorMemory.long, LONG_SAMPLES)
    spread_step(memory)
    noise_step(memory)
    memory[MonitorMemory.run] += 1.0
    return True
