"""Covariance of the filter's errors: how it grows in one sample and how a measured number shrinks it.

The errors of `Estimate` follow, over one sample of length T,

    dp+ = dp + T dv
    dv+ = dv + T L de - T C db_f + noise
    de+ = de + T B de - T E db_g + E noise
    db+ = db + walk

with C from body to earth, L the derivative of C f by the angles, E from body rates to Euler rates and B the
derivative of E w by the angles. So P+ = F P F' + Q needs only the blocks that are not those of the unit
matrix. All matrices are stored row by row; P stays symmetric to the last bit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.filter_memory import SIZE, Estimate, Work

Array = NDArray[np.float64]

_BODY, _RATES, _BEND, _LEAN = int(Work.body), int(Work.rates), int(Work.bend), int(Work.lean)
_COLUMN, _CORRECTION = int(Work.column), int(Work.correction)
_P, _V, _E = int(Estimate.position), int(Estimate.velocity), int(Estimate.angle)
_G, _F = int(Estimate.gyro_bias), int(Estimate.force_bias)


@compiled
def grow(
    covariance: Array,
    work: Array,
    period: float,
    felt: float,
    force_noise: float,
    turn_noise: float,
    gyro_walk: float,
    force_walk: float,
) -> None:
    """P to the next sample, in place.

    Args:
        covariance: (225,) of the errors.
        work: scratch in the order of `Work`; body, rates, bend and lean are read.
        period: T [s].
        felt: 1 if the accelerometers are used, 0 if their bias does not matter.
        force_noise: variance that the velocity gains along each axis [m^2/s^2].
        turn_noise: variance that the angles gain, seen about the body's axes [rad^2].
        gyro_walk: variance that each gyro's bias gains [rad^2/s^2].
        force_walk: variance that each accelerometer's bias gains [m^2/s^4].
    """
    t, f = period, felt * period
    c0, c1, c2 = f * work[_BODY], f * work[_BODY + 1], f * work[_BODY + 2]
    c3, c4, c5 = f * work[_BODY + 3], f * work[_BODY + 4], f * work[_BODY + 5]
    c6, c7, c8 = f * work[_BODY + 6], f * work[_BODY + 7], f * work[_BODY + 8]
    l0, l1, l2 = t * work[_LEAN], t * work[_LEAN + 1], t * work[_LEAN + 2]
    l3, l4, l5 = t * work[_LEAN + 3], t * work[_LEAN + 4], t * work[_LEAN + 5]
    l6, l7, l8 = t * work[_LEAN + 6], t * work[_LEAN + 7], t * work[_LEAN + 8]
    # yaw itself turns nothing, and roll does not depend on p alone: columns and entries that are zero
    b1, b2 = t * work[_BEND + 1], t * work[_BEND + 2]
    b5 = t * work[_BEND + 5]
    b7, b8 = t * work[_BEND + 7], t * work[_BEND + 8]
    r1, r2 = t * work[_RATES + 1], t * work[_RATES + 2]
    r4, r5 = t * work[_RATES + 4], t * work[_RATES + 5]
    r6, r7, r8 = t * work[_RATES + 6], t * work[_RATES + 7], t * work[_RATES + 8]
    for sweep in range(2):
        # F P by columns, then (F P) F' by rows: the same sums, stepping through the matrix the other way
        step, stride = (SIZE, 1) if sweep == 0 else (1, SIZE)
        for other in range(SIZE):
            o = other * stride
            v, e, g, a = o + _V * step, o + _E * step, o + _G * step, o + _F * step
            v0, v1, v2 = covariance[v], covariance[v + step], covariance[v + 2 * step]
            e0, e1, e2 = covariance[e], covariance[e + step], covariance[e + 2 * step]
            g0, g1, g2 = covariance[g], covariance[g + step], covariance[g + 2 * step]
            a0, a1, a2 = covariance[a], covariance[a + step], covariance[a + 2 * step]
            covariance[o] += t * v0
            covariance[o + step] += t * v1
            covariance[o + 2 * step] += t * v2
            covariance[v] = v0 + l0 * e0 + l1 * e1 + l2 * e2 - c0 * a0 - c1 * a1 - c2 * a2
            covariance[v + step] = v1 + l3 * e0 + l4 * e1 + l5 * e2 - c3 * a0 - c4 * a1 - c5 * a2
            covariance[v + 2 * step] = v2 + l6 * e0 + l7 * e1 + l8 * e2 - c6 * a0 - c7 * a1 - c8 * a2
            covariance[e] = e0 + b1 * e1 + b2 * e2 - r1 * g1 - r2 * g2
            covariance[e + step] = e1 + b5 * e2 - r4 * g1 - r5 * g2
            covariance[e + 2 * step] = e2 + b7 * e1 + b8 * e2 - r6 * g0 - r7 * g1 - r8 * g2
    for row in range(SIZE):
        for column in range(row):
            covariance[SIZE * row + column] = covariance[SIZE * column + row]
    for axis in range(3):
        covariance[(SIZE + 1) * (_V + axis)] += force_noise
        covariance[(SIZE + 1) * (_G + axis)] += gyro_walk
        covariance[(SIZE + 1) * (_F + axis)] += force_walk
        for other in range(3):
            q = 0.0
            for k in range(3):
                q += work[_RATES + 3 * axis + k] * work[_RATES + 3 * other + k]
            covariance[SIZE * (_E + axis) + _E + other] += turn_noise * q


@compiled
def column_of_error(covariance: Array, index: int, work: Array) -> float:
    """For a measured estimate itself: its covariance with all errors, into the work; returns its variance.

    Args:
        covariance: (225,) of the errors.
        index: of the estimate in the order of `Estimate`.
        work: scratch in the order of `Work`; column is written.
    """
    for row in range(SIZE):
        work[_COLUMN + row] = covariance[SIZE * index + row]
    return float(covariance[(SIZE + 1) * index])


@compiled
def column_of_place(
    covariance: Array,
    h0: float,
    h1: float,
    h2: float,
    h6: float,
    h7: float,
    h8: float,
    work: Array,
) -> float:
    """The same for a quantity that depends on position and angles: P H' into the work; returns H P H'.

    Args:
        covariance: (225,) of the errors.
        h0: derivative by the position, north.
        h1: the same, east.
        h2: the same, down.
        h6: derivative by yaw.
        h7: derivative by pitch.
        h8: derivative by roll.
        work: scratch in the order of `Work`; column is written.
    """
    p, e = SIZE * _P, SIZE * _E
    for row in range(SIZE):
        work[_COLUMN + row] = (
            covariance[p + row] * h0
            + covariance[p + SIZE + row] * h1
            + covariance[p + 2 * SIZE + row] * h2
            + covariance[e + row] * h6
            + covariance[e + SIZE + row] * h7
            + covariance[e + 2 * SIZE + row] * h8
        )
    k = _COLUMN
    return float(
        work[k] * h0
        + work[k + 1] * h1
        + work[k + 2] * h2
        + work[k + _E] * h6
        + work[k + _E + 1] * h7
        + work[k + _E + 2] * h8
    )


@compiled
def shrink(covariance: Array, innovation: float, variance: float, work: Array) -> None:
    """Take in one measured number: P - K S K', and its share of the correction.

    Args:
        covariance: (225,) of the errors.
        innovation: measured less expected, the corrections of this sample so far included.
        variance: S of the innovation.
        work: scratch in the order of `Work`; column is read, correction is added to.
    """
    for row in range(SIZE):
        gain = work[_COLUMN + row] / variance
        work[_CORRECTION + row] += gain * innovation
        for column in range(row + 1):
            less = covariance[SIZE * row + column] - gain * work[_COLUMN + column]
            covariance[SIZE * row + column] = less
            covariance[SIZE * column + row] = less


@compiled
def hold(covariance: Array, innovation: float, variance: float, work: Array) -> None:
    """The same for position and angles alone: velocity and biases keep value and variance (Schmidt's filter).

    Args:
        covariance: (225,) of the errors.
        innovation: measured less expected, the corrections of this sample so far included.
        variance: S of the innovation.
        work: scratch in the order of `Work`; column is read, correction is added to.
    """
    for row in range(SIZE):
        gain = work[_COLUMN + row] / variance
        placed = row < _V or _E <= row < _G
        if placed:
            work[_CORRECTION + row] += gain * innovation
        for column in range(row + 1):
            if placed or column < _V or _E <= column < _G:
                less = covariance[SIZE * row + column] - gain * work[_COLUMN + column]
                covariance[SIZE * row + column] = less
                covariance[SIZE * column + row] = less


@compiled
def widen(covariance: Array, first: int, variance: float) -> None:
    """Add the same variance to three errors in a row.

    Args:
        covariance: (225,) of the errors.
        first: of the three in the order of `Estimate`.
        variance: to be added.
    """
    for axis in range(3):
        covariance[(SIZE + 1) * (first + axis)] += variance


@compiled
def keep_above(covariance: Array, first: int, least: float) -> None:
    """Raise the variances of three errors in a row where they are below the least there can be.

    Args:
        covariance: (225,) of the errors.
        first: of the three in the order of `Estimate`.
        least: variance.
    """
    for axis in range(3):
        place = (SIZE + 1) * (first + axis)
        if covariance[place] < least:
            covariance[place] = least


@compiled
def renew(covariance: Array, first: int, variance: float) -> None:
    """Give three errors in a row a variance of their own and no covariance with anything.

    Args:
        covariance: (225,) of the errors.
        first: of the three in the order of `Estimate`.
        variance: of each.
    """
    for axis in range(3):
        for other in range(SIZE):
            covariance[SIZE * (first + axis) + other] = 0.0
            covariance[SIZE * other + first + axis] = 0.0
        covariance[(SIZE + 1) * (first + axis)] = variance
