"""What the filter says of the helicopter at its centre of gravity, and how well it knows it.

    p = p_IMU - C d,   v_body = C' v_IMU - w x d,   w = gyro - b_g

The covariances are those of the errors of `Estimate` through the derivatives of these, with the noise of the
gyros' sample and the velocity that rotor vibration makes of the accelerometers added. Attitude errors are
given as small rotations about north, east and down, as a message has them: the gimbal's axes times the errors
of its angles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled, equation
from heli_common.compiled_messages import read_pose, write_odometry, write_pose
from heli_common.rotations import Euler
from heli_common.vehicle_state import swap_body
from heli_navigation.corrections import locate
from heli_navigation.filter_memory import ENCODERS, SIZE, Estimate, Memory, Work
from heli_navigation.filter_parameters import FilterConstants
from heli_navigation.strapdown import lean

Array = NDArray[np.float64]

_P, _V, _E = int(Estimate.position), int(Estimate.velocity), int(Estimate.angle)
_G, _F = int(Estimate.gyro_bias), int(Estimate.force_bias)
_KEPT = int(Memory.kept_bias)
_BODY, _RATES, _LEAN, _RATE = int(Work.body), int(Work.rates), int(Work.lean), int(Work.rate)
_PLACE, _SPEED = int(Work.place), int(Work.speed)

TWIST = 6
"""Size of a pose's and of a twist's covariance."""


class Output(IntEnum):
    """Where each part of what is said begins."""

    position = 0
    """of the centre of gravity, earth NED [m]"""
    attitude = 3
    """yaw, pitch, roll [rad]"""
    velocity = 6
    """of the centre of gravity, body FRD [m/s]"""
    rates = 9
    """body FRD [rad/s]"""
    pose = 12
    """(36) covariance of position and of rotations about north, east, down, row by row"""
    twist = pose + TWIST * TWIST
    """(36) covariance of velocity and rates in body FRD, row by row"""
    end = twist + TWIST * TWIST


_POSE, _TWIST = int(Output.pose), int(Output.twist)


class BiasMessage(IntEnum):
    """Where each part of the message on the IMU begins: gyros x, y, z, then accelerometers, body FLU."""

    bias = 0
    """[rad/s], [m/s^2]"""
    noise = 6
    """measured densities [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)]"""
    deviation = 12
    """of the biases [rad/s], [m/s^2]"""
    end = 18


@compiled
def read_motion(memory: Array, box: Sequence[FilterConstants], work: Array, out: Array) -> None:
    """Write position, attitude, velocity and rates.

    Args:
        memory: of the filter, in the parts of `Memory`.
        box: constants of the filter, boxed.
        work: scratch in the order of `Work`.
        out: (84,) in the parts of `Output`; the covariances are left as they are.
    """
    locate(memory, box[0], work)
    for axis in range(3):
        b = _BODY + axis
        out[Output.position + axis] = work[_PLACE + axis]
        out[Output.attitude + axis] = memory[_E + axis]
        out[Output.velocity + axis] = (
            work[b] * work[_SPEED] + work[b + 3] * work[_SPEED + 1] + work[b + 6] * work[_SPEED + 2]
        )
        out[Output.rates + axis] = work[_RATE + axis]


@compiled
def read_covariance(
    memory: Array, box: Sequence[FilterConstants], work: Array, rows: Array, out: Array
) -> None:
    """Write both covariances.

    Args:
        memory: of the filter, in the parts of `Memory`.
        box: constants of the filter, boxed.
        work: scratch in the order of `Work`.
        rows: (90,) scratch.
        out: (84,) in the parts of `Output`; the covariances are written.
    """
    c = box[0]
    covariance = memory[Memory.covariance : Memory.gyro]
    locate(memory, c, work)
    _pose_rows(work, rows)
    _through(covariance, rows, out, _POSE)
    _twist_rows(memory, c, work, rows)
    _through(covariance, rows, out, _TWIST)
    t = _TWIST
    out[t] += c.shake_once
    out[t + 7] += c.shake_once
    out[t + 14] += c.shake_twice
    if memory[Memory.coasting] == 0.0:
        _gyro_noise(c.gyro_density / c.period, c, out)


@compiled
def read_odometry(
    memory: Array, box: Sequence[FilterConstants], work: Array, rows: Array, out: Array, values: Array
) -> None:
    """All of that as the numbers of an Odometry in ENU/FLU.

    Args:
        memory: of the filter, in the parts of `Memory`.
        box: constants of the filter, boxed.
        work: scratch in the order of `Work`.
        rows: (90,) scratch.
        out: (84,) in the parts of `Output`, written.
        values: (85,) in the order of the layout, written.
    """
    read_motion(memory, box, work, out)
    read_covariance(memory, box, work, rows, out)
    write_odometry(out, values)


@compiled
def read_vehicle(
    memory: Array, box: Sequence[FilterConstants], work: Array, rows: Array, out: Array, state: Array
) -> bool:
    """What an Odometry tells a supervisor, without its other numbers: bit for bit what comes out of one.

    Args:
        memory: of the filter, in the parts of `Memory`.
        box: constants of the filter, boxed.
        work: scratch in the order of `Work`.
        rows: (90,) scratch.
        out: (84,) in the parts of `Output`, written but for the covariances.
        state: (15,) receives position [m], yaw, pitch, roll [rad], velocity [m/s], rates [rad/s], variances
            of the position north, east, down [m^2].

    Returns:
        False if the attitude is not finite.
    """
    read_motion(memory, box, work, out)
    _pose_rows(work, rows)
    covariance = memory[Memory.covariance : Memory.gyro]
    for axis in range(3):
        state[12 + axis] = _entry(covariance, rows, axis, axis)
    for index in range(12):
        state[index] = out[index]
    pose = rows[:7]
    write_pose((out[0], out[1], out[2]), Euler(out[3], out[4], out[5]), pose)
    return read_pose(pose, state)


@compiled
def read_biases(memory: Array, box: Sequence[FilterConstants], values: Array) -> None:
    """Biases of the IMU and how well they are known; without IMU the gyros' are those from before, and walk.

    Args:
        memory: of the filter, in the parts of `Memory`.
        box: constants of the filter, boxed.
        values: (18,) in the parts of `BiasMessage`; the noise is left as it is.
    """
    coasting = memory[Memory.coasting] > 0.0
    g = _KEPT if coasting else _G
    values[0], values[1], values[2] = swap_body((memory[g], memory[g + 1], memory[g + 2]))
    values[3], values[4], values[5] = swap_body((memory[_F], memory[_F + 1], memory[_F + 2]))
    for axis in range(6):
        variance = memory[Memory.covariance + (SIZE + 1) * (_G + axis)]
        if coasting and axis < 3:
            variance = memory[Memory.kept_variance + axis] + box[0].gyro_walk * memory[Memory.coasted]
        values[BiasMessage.deviation + axis] = math.sqrt(variance)


@compiled
def read_alarms(memory: Array) -> int:
    """One number for all that people must be told, 0 for nothing; it changes whenever that does.

    Args:
        memory: of the filter, in the parts of `Memory`.
    """
    jumps = memory[Memory.jumps] + memory[Memory.jumps + 1] + memory[Memory.jumps + 2]
    alarms = 2 * int(jumps) + (1 if memory[Memory.coasting] > 0.0 else 0)
    for encoder in range(ENCODERS):
        alarms = 2 * alarms + (1 if memory[Memory.lost + encoder] > 0.0 else 0)
    return alarms


@compiled
def _clear(rows: Array) -> None:
    for index in range(TWIST * SIZE):
        rows[index] = 0.0


@compiled
def _pose_rows(work: Array, rows: Array) -> None:
    """d (position, rotation) / d errors; lean is that of the lever C d."""
    _clear(rows)
    for axis in range(3):
        row = SIZE * axis
        rows[row + _P + axis] = 1.0
        for angle in range(3):
            rows[row + _E + angle] = -work[_LEAN + 3 * axis + angle]
    # the gimbal's axes in NED: down, the level one to the right of the nose, the nose
    cth = work[_BODY + 8] / work[_RATES + 4]
    r = SIZE * 3
    rows[r + _E + 1], rows[r + _E + 2] = -work[_BODY + 3] / cth, work[_BODY]
    rows[r + SIZE + _E + 1], rows[r + SIZE + _E + 2] = work[_BODY] / cth, work[_BODY + 3]
    rows[r + 2 * SIZE + _E], rows[r + 2 * SIZE + _E + 2] = 1.0, work[_BODY + 6]


@compiled
def _twist_rows(memory: Array, c: FilterConstants, work: Array, rows: Array) -> None:
    """d (velocity, rates) / d errors.

    The velocity of the IMU in the body is C' v: its derivative by an angle is -C' (axis x v). The rates'
    errors are those of the biases with the sign turned, and -w x d makes of them d x (-db).
    """
    _clear(rows)
    lean(memory[_V], memory[_V + 1], memory[_V + 2], work)
    b, k = _BODY, _LEAN
    for axis in range(3):
        row = SIZE * axis
        for j in range(3):
            rows[row + _V + j] = work[b + 3 * j + axis]
            rows[row + _E + j] = -(
                work[b + axis] * work[k + j]
                + work[b + 3 + axis] * work[k + 3 + j]
                + work[b + 6 + axis] * work[k + 6 + j]
            )
        rows[SIZE * (3 + axis) + _G + axis] = -1.0
    rows[_G + 1], rows[_G + 2] = c.z, -c.y
    rows[SIZE + _G], rows[SIZE + _G + 2] = -c.z, c.x
    rows[2 * SIZE + _G], rows[2 * SIZE + _G + 1] = c.y, -c.x


@compiled
def _gyro_noise(variance: float, c: FilterConstants, out: Array) -> None:
    """Add a gyro sample's noise n: n to the rates, d x n to the velocity."""
    t = _TWIST
    square = c.x * c.x + c.y * c.y + c.z * c.z
    d = (c.x, c.y, c.z)
    for row in range(3):
        for column in range(3):
            out[t + 6 * row + column] += variance * ((square if row == column else 0.0) - d[row] * d[column])
        out[t + 6 * (3 + row) + 3 + row] += variance
    # d x n: the matrix of the cross product, and its transpose
    for row, column, share in (
        (0, 1, -c.z),
        (0, 2, c.y),
        (1, 0, c.z),
        (1, 2, -c.x),
        (2, 0, -c.y),
        (2, 1, c.x),
    ):
        out[t + 6 * row + 3 + column] += variance * share
        out[t + 6 * (3 + column) + row] += variance * share


@compiled
def _through(covariance: Array, rows: Array, out: Array, first: int) -> None:
    """T P T', 6 x 6, of six rows of which most entries are zero."""
    for row in range(TWIST):
        for column in range(row + 1):
            total = _entry(covariance, rows, row, column)
            out[first + TWIST * row + column] = total
            out[first + TWIST * column + row] = total


@equation
def _entry(covariance: Array, rows: Array, row: int, column: int) -> float:
    total = 0.0
    for i in range(SIZE):
        left = rows[SIZE * row + i]
        if left != 0.0:
            part = 0.0
            for j in range(SIZE):
                part += covariance[SIZE * i + j] * rows[SIZE * column + j]
            total += left * part
    return total
