"""Dead reckoning from gyros and accelerometers: attitude, velocity and position of the IMU over one sample.

Rates and specific force are the means of the readings at both ends of the sample, turned by the attitude in
its middle, which leaves errors of third order in the length of the sample:

    e' = E(e) w,   v' = C(e) f + (0, 0, g),   p' = v        (source app. A.2, eq. 2.14)

with e = yaw psi, pitch theta, roll phi and

        [ 0   sin phi / cos theta   cos phi / cos theta ]
    E = [ 0   cos phi               -sin phi            ]
        [ 1   tan theta sin phi     tan theta cos phi   ]
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.filter_memory import Estimate, Work

Array = NDArray[np.float64]

_BODY, _RATES, _BEND, _LEAN = int(Work.body), int(Work.rates), int(Work.bend), int(Work.lean)
_RATE, _PUSH = int(Work.rate), int(Work.push)
_P, _V, _E = int(Estimate.position), int(Estimate.velocity), int(Estimate.angle)


@compiled
def orient(psi: float, theta: float, phi: float, work: Array) -> None:
    """Write C and E of an attitude.

    Args:
        psi: yaw [rad].
        theta: pitch [rad], within a right angle.
        phi: roll [rad].
        work: scratch in the order of `Work`; body and rates are written.
    """
    spsi, cpsi = math.sin(psi), math.cos(psi)
    sth, cth = math.sin(theta), math.cos(theta)
    sphi, cphi = math.sin(phi), math.cos(phi)
    b = _BODY
    work[b], work[b + 1], work[b + 2] = (
        cpsi * cth,
        cpsi * sth * sphi - spsi * cphi,
        cpsi * sth * cphi + spsi * sphi,
    )
    work[b + 3], work[b + 4], work[b + 5] = (
        spsi * cth,
        spsi * sth * sphi + cpsi * cphi,
        spsi * sth * cphi - cpsi * sphi,
    )
    work[b + 6], work[b + 7], work[b + 8] = -sth, cth * sphi, cth * cphi
    e, tan = _RATES, sth / cth
    work[e], work[e + 1], work[e + 2] = 0.0, sphi / cth, cphi / cth
    work[e + 3], work[e + 4], work[e + 5] = 0.0, cphi, -sphi
    work[e + 6], work[e + 7], work[e + 8] = 1.0, tan * sphi, tan * cphi


@compiled
def reckon(estimate: Array, period: float, gravity: float, work: Array) -> None:
    """Move position, velocity and angles on by one sample, and write the derivatives the covariance needs.

    Args:
        estimate: (15,) in the order of `Estimate`, overwritten.
        period: of the sample [s].
        gravity: [m/s^2].
        work: scratch in the order of `Work`; rate and push, the means over the sample with the biases taken
            off, are read; body, rates, bend and lean, of the middle of the sample, are written.
    """
    p, q, r = work[_RATE], work[_RATE + 1], work[_RATE + 2]
    fx, fy, fz = work[_PUSH], work[_PUSH + 1], work[_PUSH + 2]
    psi, theta, phi = estimate[_E], estimate[_E + 1], estimate[_E + 2]
    sth, cth, sphi, cphi = math.sin(theta), math.cos(theta), math.sin(phi), math.cos(phi)
    swing = q * sphi + r * cphi
    half = 0.5 * period
    orient(
        psi + half * swing / cth,
        theta + half * (q * cphi - r * sphi),
        phi + half * (p + swing * sth / cth),
        work,
    )
    e, b = _RATES, _BODY
    turn_psi = work[e + 1] * q + work[e + 2] * r
    turn_theta = work[e + 4] * q + work[e + 5] * r
    turn_phi = p + work[e + 7] * q + work[e + 8] * r
    estimate[_E] = psi + period * turn_psi
    estimate[_E + 1] = theta + period * turn_theta
    estimate[_E + 2] = phi + period * turn_phi
    north = work[b] * fx + work[b + 1] * fy + work[b + 2] * fz
    east = work[b + 3] * fx + work[b + 4] * fy + work[b + 5] * fz
    down = work[b + 6] * fx + work[b + 7] * fy + work[b + 8] * fz
    bend(turn_psi, turn_theta, work)
    lean(north, east, down, work)
    _step(estimate, 0, north, period)
    _step(estimate, 1, east, period)
    _step(estimate, 2, down + gravity, period)


@compiled
def _step(estimate: Array, axis: int, acceleration: float, period: float) -> None:
    velocity = estimate[_V + axis]
    estimate[_P + axis] += period * (velocity + 0.5 * period * acceleration)
    estimate[_V + axis] = velocity + period * acceleration


@compiled
def bend(turn_psi: float, turn_theta: float, work: Array) -> None:
    """Write d (E w) / d (psi, theta, phi) [1/s].

    Args:
        turn_psi: rate of yaw [rad/s].
        turn_theta: rate of pitch [rad/s].
        work: scratch in the order of `Work`; body and rates are read, bend is written.
    """
    e, k = _RATES, _BEND
    sth, cth = -work[_BODY + 6], work[_BODY + 8] / work[e + 4]
    tan = sth / cth
    work[k], work[k + 3], work[k + 6] = 0.0, 0.0, 0.0
    work[k + 1], work[k + 2] = turn_psi * tan, turn_theta / cth
    work[k + 4], work[k + 5] = 0.0, -turn_psi * cth
    work[k + 7], work[k + 8] = turn_psi / cth, turn_theta * tan


@compiled
def lean(north: float, east: float, down: float, work: Array) -> None:
    """Write how a vector fixed in the body turns with the angles: gimbal axis x vector, axis by axis.

    Args:
        north: of the vector in NED.
        east: the same.
        down: the same.
        work: scratch in the order of `Work`; body and rates are read, lean is written,
            rows NED, columns yaw, pitch, roll.
    """
    k = _LEAN
    x, y, z = work[_BODY], work[_BODY + 3], work[_BODY + 6]  # nose: the axis of roll
    cth = work[_BODY + 8] / work[_RATES + 4]
    cpsi, spsi = x / cth, y / cth
    work[k], work[k + 3], work[k + 6] = -east, north, 0.0
    work[k + 1], work[k + 4], work[k + 7] = cpsi * down, spsi * down, -spsi * east - cpsi * north
    work[k + 2], work[k + 5], work[k + 8] = y * down - z * east, z * north - x * down, x * east - y * north
