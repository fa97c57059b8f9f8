"""Prediction, correction and output of the attitude filter; the equations stand in `imu_attitude`.

What the filter remembers, its covariance included, is one array: copy it and you have the filter.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled, equation
from heli_common.compiled_messages import write_imu_attitude
from heli_common.rotations import Euler
from heli_common.vehicle_state import UNKNOWN_VARIANCE
from heli_navigation.imu_attitude_parameters import ImuAttitudeConstants

Array = NDArray[np.float64]

ROWS = 9
"""Rows of the covariance: psi, theta, phi, biases of gyros x, y, z and of accelerometers x, y, z."""

STILL_AXES = 5
"""Readings that tell a standstill: three gyros, accelerometers x and y."""


class AttitudeMemory(IntEnum):
    """What the filter remembers: where each part begins; it reaches to the beginning of the next."""

    psi = 0
    """[rad]; this and what follows up to `known` in the order of the covariance's rows"""
    theta = 1
    phi = 2
    gyro_bias = 3
    """[rad/s]"""
    force_bias = 6
    """of the accelerometers [m/s^2]"""
    known = 9
    """1 while the attitude is known"""
    gyro = 10
    """latest valid reading [rad/s]"""
    fresh = 13
    """1 if that was the latest sample"""
    velocity = 14
    """summed up from unexplained specific force, body FRD [m/s]"""
    agitated = 17
    """for how long it has been more than motion explains [s]"""
    still_count = 18
    """samples in the window of standstill"""
    still_sum = 19
    """over these, of gyros and accelerometers x, y"""
    still_square = still_sum + STILL_AXES
    """of their squares"""
    standstills = still_square + STILL_AXES
    """windows of standstill so far"""
    product = standstills + 1
    """(9,) covariance times derivative of a measurement"""
    covariance = product + ROWS
    """(9, 9) row by row"""
    end = covariance + ROWS * ROWS


@equation
def cell(row: int, column: int) -> int:
    """Where an element of the covariance stands in the memory.

    Args:
        row: 0 .. 8.
        column: 0 .. 8.
    """
    return AttitudeMemory.covariance + ROWS * row + column


@equation
def euler_rates(theta: float, phi: float, p: float, q: float, r: float) -> tuple[float, float, float]:
    """psi', theta', phi' [rad/s] (source eq. 2.2, 2.3).

    Args:
        theta: pitch [rad].
        phi: roll [rad].
        p: rate about x, body FRD [rad/s].
        q: rate about y.
        r: rate about z.
    """
    sine, cosine = math.sin(phi), math.cos(phi)
    swing = q * sine + r * cosine
    return swing / math.cos(theta), q * cosine - r * sine, p + swing * math.tan(theta)


@compiled
def predict(memory: Array, p: float, q: float, r: float, seen: float, c: ImuAttitudeConstants) -> None:
    """Turn the attitude on by one sample and let the covariance grow.

    The rates act at the attitude half a sample on, so the error of a step is of third order.

    Args:
        memory: of the filter, in the parts of `AttitudeMemory`, overwritten.
        p: mean rate over the sample, bias taken off [rad/s].
        q: the same about y.
        r: the same about z.
        seen: 1 if they were measured, 0 if nothing is known of them.
        c: constants of the filter.
    """
    first, period = cell(0, 0), c.period
    theta, phi = memory[AttitudeMemory.theta], memory[AttitudeMemory.phi]
    _, theta_rate, phi_rate = euler_rates(theta, phi, p, q, r)
    theta += 0.5 * period * theta_rate
    phi += 0.5 * period * phi_rate
    sine, cosine, upright, slope = math.sin(phi), math.cos(phi), 1.0 / math.cos(theta), math.tan(theta)
    swing, pitching = q * sine + r * cosine, q * cosine - r * sine
    memory[AttitudeMemory.psi] += period * swing * upright
    memory[AttitudeMemory.theta] += period * pitching
    memory[AttitudeMemory.phi] += period * (p + swing * slope)
    # derivatives of the new angles less unity, by theta and phi
    psi_theta, psi_phi = period * swing * slope * upright, period * pitching * upright
    theta_phi = -period * swing
    phi_theta, phi_phi = period * swing * upright * upright, period * pitching * slope
    # and by the biases
    back = -period * seen
    psi_q, psi_r = back * sine * upright, back * cosine * upright
    theta_q, theta_r = back * cosine, -back * sine
    phi_q, phi_r = back * sine * slope, back * cosine * slope
    # F P, then the part of it that (F P) F' changes; biases stay, so that all other columns are done
    for side in range(2):
        stride, other, count = (ROWS, 1, ROWS) if side == 0 else (1, ROWS, 3)
        for line in range(count):
            k = first + other * line
            of_psi, of_theta, of_phi = memory[k], memory[k + stride], memory[k + 2 * stride]
            of_p, of_q, of_r = memory[k + 3 * stride], memory[k + 4 * stride], memory[k + 5 * stride]
            memory[k] = of_psi + psi_theta * of_theta + psi_phi * of_phi + psi_q * of_q + psi_r * of_r
            memory[k + stride] = of_theta + theta_phi * of_phi + theta_q * of_q + theta_r * of_r
            memory[k + 2 * stride] = (
                of_phi + phi_theta * of_theta + phi_phi * of_phi + back * of_p + phi_q * of_q + phi_r * of_r
            )
    noise = c.turn_variance if seen > 0.5 else c.blind_variance
    memory[cell(0, 0)] += noise * upright * upright
    memory[cell(1, 1)] += noise
    memory[cell(2, 2)] += noise * (1.0 + slope * slope)
    memory[cell(0, 2)] += noise * slope * upright
    for row in range(3):
        for column in range(row + 1, ROWS):
            memory[cell(column, row)] = memory[cell(row, column)]


@compiled
def absorb(memory: Array, variance: float, innovation: float) -> None:
    """Take in one number that was measured, whose P H' stands in the memory as `product`.

    Args:
        memory: of the filter, overwritten.
        variance: of the innovation, H P H' + R.
        innovation: measured less expected.
    """
    for row in range(ROWS):
        gain = memory[AttitudeMemory.product + row] / variance
        memory[AttitudeMemory.psi + row] += gain * innovation
        for column in range(row, ROWS):
            value = memory[cell(row, column)] - gain * memory[AttitudeMemory.product + column]
            memory[cell(row, column)] = value
            memory[cell(column, row)] = value


@compiled
def correct(memory: Array, fx: float, fy: float, fz: float, c: ImuAttitudeConstants) -> None:
    """Let the accelerometers correct the attitude, one after the other.

    Args:
        memory: of the filter, overwritten.
        fx: reading less the terms of the lever arm, body FRD [m/s^2].
        fy: the same along y.
        fz: the same along z.
        c: constants of the filter.
    """
    g, at, bias = c.gravity, AttitudeMemory.velocity, AttitudeMemory.force_bias
    theta, phi = memory[AttitudeMemory.theta], memory[AttitudeMemory.phi]
    sin_theta, cos_theta, sin_phi, cos_phi = math.sin(theta), math.cos(theta), math.sin(phi), math.cos(phi)
    x, y, z = fx - g * sin_theta, fy + g * cos_theta * sin_phi, fz + g * cos_theta * cos_phi
    u = c.velocity_kept * memory[at] + c.period * (x - memory[bias])
    v = c.velocity_kept * memory[at + 1] + c.period * (y - memory[bias + 1])
    w = c.velocity_kept * memory[at + 2] + c.period * (z - memory[bias + 2])
    memory[at], memory[at + 1], memory[at + 2] = u, v, w
    # as much velocity as the filter's own doubt of the tilt explains tells nothing of the helicopter
    doubt = c.tilt_velocity * (memory[cell(1, 1)] + memory[cell(2, 2)])
    agitation = (u * u + v * v + w * w) / (c.velocity_variance + doubt)
    noise = c.force_variance * (1.0 + min(agitation, c.agitation_limit))
    if agitation < c.agitation_limit:
        memory[AttitudeMemory.agitated] = 0.0
    else:
        memory[AttitudeMemory.agitated] += c.period
        if memory[AttitudeMemory.agitated] > c.patience:
            for row in range(3, 6):
                memory[cell(row, row)] += c.jump_variance
    for axis in range(3):
        if axis == 0:
            by_theta, by_phi, beyond = g * cos_theta, 0.0, x
        elif axis == 1:
            by_theta, by_phi, beyond = g * sin_theta * sin_phi, -g * cos_theta * cos_phi, y
        else:
            by_theta, by_phi, beyond = g * sin_theta * cos_phi, g * cos_theta * sin_phi, z
        own, product = bias + axis, AttitudeMemory.product
        for row in range(ROWS):
            memory[product + row] = (
                by_theta * memory[cell(1, row)] + by_phi * memory[cell(2, row)] + memory[cell(own, row)]
            )
        variance = (
            by_theta * memory[product + 1] + by_phi * memory[product + 2] + memory[product + own] + noise
        )
        # the axes before have moved the angles
        tilted = by_theta * (memory[AttitudeMemory.theta] - theta) + by_phi * (
            memory[AttitudeMemory.phi] - phi
        )
        absorb(memory, variance, beyond - tilted - memory[own])


@compiled
def read_attitude(memory: Array, values: Array) -> None:
    """Attitude, rates less their biases and variances as the numbers of an Imu in ENU/FLU.

    Without a valid reading the rates are zero.

    Args:
        memory: of the filter, in the parts of `AttitudeMemory`.
        values: (37,) in the order of the layout, written.
    """
    at, bias = AttitudeMemory.gyro, AttitudeMemory.gyro_bias
    p, q, r = 0.0, 0.0, 0.0
    if memory[AttitudeMemory.fresh] > 0.5:
        p, q, r = (
            memory[at] - memory[bias],
            memory[at + 1] - memory[bias + 1],
            memory[at + 2] - memory[bias + 2],
        )
    variances = (UNKNOWN_VARIANCE, UNKNOWN_VARIANCE, UNKNOWN_VARIANCE)
    if memory[AttitudeMemory.known] > 0.5:
        # the gimbal's axes are near those of the earth while tilt is small: roll about north, yaw about down
        variances = (memory[cell(2, 2)], memory[cell(1, 1)], memory[cell(0, 0)])
    psi, theta, phi = (
        memory[AttitudeMemory.psi],
        memory[AttitudeMemory.theta],
        memory[AttitudeMemory.phi],
    )
    write_imu_attitude(Euler(psi, theta, phi), variances, (p, q, r), memory[cell(3, 3)], values)
