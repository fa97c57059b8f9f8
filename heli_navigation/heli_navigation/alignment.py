"""Alignment: what the IMU reads while the helicopter stands is known, so its biases can be learnt.

It stands if it is at the lower stop and no count of any encoder has changed for a while. Then its rates are
zero, its velocity is zero, and the accelerometers feel nothing but the stop:

    gyro = b_g + noise,   force = b_f - C' (0, 0, g) + noise

What the gyros say is not used for the attitude at the same time, so their noise does not count twice.
Attitude and position are never taken for better known than a cell of the encoders tells: so far anything may
creep unseen. A gyro that says otherwise ends the standing before a count does.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.error_covariance import keep_above, renew, shrink, widen
from heli_navigation.filter_memory import SIZE, Estimate, Memory, Work
from heli_navigation.filter_parameters import FilterConstants
from heli_navigation.strapdown import lean, orient

Array = NDArray[np.float64]

_COVARIANCE, _GYRO, _FORCE = int(Memory.covariance), int(Memory.gyro), int(Memory.force)
_P, _V, _E = int(Estimate.position), int(Estimate.velocity), int(Estimate.angle)
_G, _F = int(Estimate.gyro_bias), int(Estimate.force_bias)
_BODY, _LEAN = int(Work.body), int(Work.lean)
_COLUMN, _CORRECTION = int(Work.column), int(Work.correction)

STILL_SPEED = 1e-3
"""Deviation of the velocity of a helicopter that stands [m/s]."""

PUSHED_SPEED = 0.02
"""Deviation of the velocity with which it may leave [m/s]."""

UNSEEN = 1e-3
"""Deviation of how far it may have moved without a change of count [m]: up to 8 mm a count at the stop."""

SMOOTHING = 0.1
"""Time constant over which the gyros are smoothed to see whether it moves [s]."""

MOVING = 25.0
"""Square of the smoothed rate beyond which it does not stand, in its deviations."""

DISPUTE = 2.0
"""For which it then does not stand in any case [s]: if no count changes, a bias has jumped."""

GYRO_FLOOR = math.radians(0.01)
"""Creeping that no encoder sees: no bias is learnt more exactly than this while standing [rad/s]."""


@compiled
def stand(
    memory: Array,
    gyro_x: float,
    gyro_y: float,
    gyro_z: float,
    force_x: float,
    force_y: float,
    force_z: float,
    c: FilterConstants,
    work: Array,
) -> bool:
    """Learn the biases from one sample at rest; False, and nothing learnt, if this is not the stop.

    Args:
        memory: of the filter, in the parts of `Memory`.
        gyro_x: reading, body FRD [rad/s].
        gyro_y: the same.
        gyro_z: the same.
        force_x: reading, body FRD [m/s^2].
        force_y: the same.
        force_z: the same.
        c: constants of the filter.
        work: scratch in the order of `Work`.
    """
    orient(memory[_E], memory[_E + 1], memory[_E + 2], work)
    b = _BODY + 6
    depth = memory[_P + 2] - work[b] * c.x - work[b + 1] * c.y - work[b + 2] * c.z
    if depth < c.still_depth or memory[Memory.coasting] > 0.0:
        return False
    covariance = memory[Memory.covariance : Memory.gyro]
    if memory[Memory.standing] == 0.0:
        memory[Memory.standing] = 1.0
        renew(covariance, _V, STILL_SPEED * STILL_SPEED)
        for axis in range(3):
            memory[_V + axis] = 0.0
            memory[Memory.drift + axis] = 0.0
    if _moves(memory, gyro_x, gyro_y, gyro_z, c):
        memory[Memory.unchanged] = -DISPUTE
        return False
    g, f = _GYRO, _FORCE
    memory[g], memory[g + 1], memory[g + 2] = gyro_x, gyro_y, gyro_z
    memory[f], memory[f + 1], memory[f + 2] = force_x, force_y, force_z
    widen(covariance, _G, c.gyro_walk * c.period)
    widen(covariance, _F, c.accelerometer_walk * c.period)
    keep_above(covariance, _E, c.cell_variance)
    keep_above(covariance, _P, UNSEEN * UNSEEN)
    for index in range(SIZE):
        work[_CORRECTION + index] = 0.0
    lean(0.0, 0.0, -c.gravity, work)
    for axis in range(3):
        if covariance[(SIZE + 1) * (_G + axis)] > GYRO_FLOOR * GYRO_FLOOR:
            _learn_rate(memory, axis, c, work)
        _learn_force(memory, axis, c, work)
    for index in range(SIZE):
        memory[index] += work[_CORRECTION + index]
    return True


@compiled
def _moves(memory: Array, gyro_x: float, gyro_y: float, gyro_z: float, c: FilterConstants) -> bool:
    """Whether the gyros, smoothed, say more than their biases may; so does a jump of a bias."""
    share, moves = c.period / SMOOTHING, False
    noise = 0.5 * share * c.gyro_density / c.period
    for axis in range(3):
        reading = gyro_x if axis == 0 else (gyro_y if axis == 1 else gyro_z)
        at = Memory.drift + axis
        memory[at] += share * (reading - memory[_G + axis] - memory[at])
        if memory[at] * memory[at] > MOVING * (noise + memory[_COVARIANCE + (SIZE + 1) * (_G + axis)]):
            moves = True
    return moves


@compiled
def _learn_rate(memory: Array, axis: int, c: FilterConstants, work: Array) -> None:
    covariance = memory[Memory.covariance : Memory.gyro]
    for row in range(SIZE):
        work[_COLUMN + row] = covariance[SIZE * (_G + axis) + row]
    innovation = memory[_GYRO + axis] - memory[_G + axis] - work[_CORRECTION + _G + axis]
    shrink(covariance, innovation, work[_COLUMN + _G + axis] + c.gyro_density / c.period, work)


@compiled
def _learn_force(memory: Array, axis: int, c: FilterConstants, work: Array) -> None:
    """What is felt along a body axis.

    With a = (0, 0, -g) fixed in the earth, f = C' a has the derivatives -C' (gimbal axis x a) by the angles.
    """
    covariance = memory[Memory.covariance : Memory.gyro]
    b, k = _BODY + axis, _LEAN
    h6 = -(work[b] * work[k] + work[b + 3] * work[k + 3] + work[b + 6] * work[k + 6])
    h7 = -(work[b] * work[k + 1] + work[b + 3] * work[k + 4] + work[b + 6] * work[k + 7])
    h8 = -(work[b] * work[k + 2] + work[b + 3] * work[k + 5] + work[b + 6] * work[k + 8])
    e, f = SIZE * _E, SIZE * (_F + axis)
    for row in range(SIZE):
        work[_COLUMN + row] = (
            covariance[f + row]
            + covariance[e + row] * h6
            + covariance[e + SIZE + row] * h7
            + covariance[e + 2 * SIZE + row] * h8
        )
    d = _CORRECTION
    expected = -c.gravity * work[_BODY + 6 + axis] + memory[_F + axis] + work[d + _F + axis]
    expected += h6 * work[d + _E] + h7 * work[d + _E + 1] + h8 * work[d + _E + 2]
    variance = (
        work[_COLUMN + _F + axis]
        + h6 * work[_COLUMN + _E]
        + h7 * work[_COLUMN + _E + 1]
        + h8 * work[_COLUMN + _E + 2]
    )
    noise = c.accelerometer_density / c.period + (c.force_twice if axis == 2 else c.force_once)
    shrink(covariance, memory[_FORCE + axis] - expected, variance + noise, work)


@compiled
def leave_stand(memory: Array) -> None:
    """The helicopter begins to move: allow for the speed that it may have already.

    Args:
        memory: of the filter, in the parts of `Memory`.
    """
    widen(memory[Memory.covariance : Memory.gyro], _V, PUSHED_SPEED * PUSHED_SPEED)
    memory[Memory.standing] = 0.0
