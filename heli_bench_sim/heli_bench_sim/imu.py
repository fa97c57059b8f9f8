"""IMU at the helicopter's head: three gyros and three accelerometers at 400 Hz (spec 2.3).

An accelerometer feels the specific force of its own place: acceleration less gravity, with the lever-arm
terms of the turning body, w' x d + w x (w x d). To it come the vibration of the rotor, bias and white noise;
range and quantisation follow last.

Vibration (D): an out-of-balance rotor pulls along one blade and so once per turn along x and along y, a
quarter turn apart; the two blades together give a vertical force twice per turn. Both are forces of inertia
or of the air and grow with the square of the rotor speed. The gyros do not feel them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.imu_parameters import ImuConstants
from heli_bench_sim.states import State
from heli_common.compiled import compiled, equation

Array = NDArray[np.float64]
Vector3 = tuple[float, float, float]


class ImuAxis(IntEnum):
    """Order of readings, biases and white noise, body FRD: [rad/s] and [m/s^2]."""

    gyro_x = 0
    gyro_y = 1
    gyro_z = 2
    accelerometer_x = 3
    accelerometer_y = 4
    accelerometer_z = 5


IMU_SIZE = len(ImuAxis)

GYROS = 3

IMU_NORMALS = IMU_SIZE + GYROS
"""Standard normal numbers per sample: white noise in the order of `ImuAxis`, then the walk of three gyros."""


@equation
def quantised(value: float, largest: float, step: float, top_code: float) -> float:
    """What a converter with a limited range makes of a value: the nearest whole number of steps.

    Mid-tread, so zero is a code; two's complement, so the last code below +largest is the highest one.

    Args:
        value: to be converted.
        largest: end of the range, both signs.
        step: distance of two codes.
        top_code: highest code.
    """
    if value > largest:
        value = largest
    elif value < -largest:
        value = -largest
    code = np.floor(value / step + 0.5)  # of numpy, because it lets a NaN through
    return step * (top_code if code > top_code else code)


@compiled
def imu_truth(state: Array, rate: Array, c: ImuConstants, out: Array) -> None:
    """Write what a perfect IMU would read into `out`; at rest and level (0, 0, 0, 0, 0, -g).

    Args:
        state: (18 or more,) of the helicopter in the order of `State`.
        rate: the same, its derivatives with respect to time; u', v', w' in the turning body frame.
        c: constants of the IMU.
        out: (6,) receives body rates [rad/s] and specific force at the IMU's place [m/s^2], body FRD.
    """
    theta, phi = state[State.theta], state[State.phi]
    u, v, w = state[State.u], state[State.v], state[State.w]
    p, q, r = state[State.p], state[State.q], state[State.r]
    p_rate, q_rate, r_rate = rate[State.p], rate[State.q], rate[State.r]
    cos_theta = math.cos(theta)
    along = p * c.x + q * c.y + r * c.z
    square = p * p + q * q + r * r
    out[ImuAxis.gyro_x], out[ImuAxis.gyro_y], out[ImuAxis.gyro_z] = p, q, r
    out[ImuAxis.accelerometer_x] = (
        (rate[State.u] + q * w - r * v)  # source eq. 2.14
        + (q_rate * c.z - r_rate * c.y)
        + (p * along - c.x * square)  # w x (w x d)
        + c.gravity * math.sin(theta)
    )
    out[ImuAxis.accelerometer_y] = (
        (rate[State.v] + r * u - p * w)
        + (r_rate * c.x - p_rate * c.z)
        + (q * along - c.y * square)
        - c.gravity * math.sin(phi) * cos_theta
    )
    out[ImuAxis.accelerometer_z] = (
        (rate[State.w] + p * v - q * u)
        + (p_rate * c.y - q_rate * c.x)
        + (r * along - c.z * square)
        - c.gravity * math.cos(phi) * cos_theta
    )


@compiled
def imu_sample(
    state: Array, rate: Array, azimuth: float, bias: Array, normals: Array, c: ImuConstants, out: Array
) -> None:
    """Write one reading of the IMU into `out`, then let the gyros' biases walk on by one sample of 2.5 ms.

    Args:
        state: (18 or more,) of the helicopter in the order of `State`.
        rate: the same, its derivatives with respect to time.
        azimuth: of the rotor, from the nose in its sense of rotation, anticlockwise from above [rad].
        bias: (6,) in the order of `ImuAxis`, of this sample on entry and of the next one on return; those of
            the accelerometers are constant.
        normals: (9,) standard normal numbers, see `IMU_NORMALS`.
        c: constants of the IMU.
        out: (6,) receives the reading in the order of `ImuAxis`, body FRD [rad/s], [m/s^2].
    """
    imu_truth(state, rate, c, out)
    ratio = state[State.Omega] / c.rotor_speed
    cosine, sine = math.cos(azimuth), math.sin(azimuth)
    once, twice = c.vibration_once * ratio * ratio, c.vibration_twice * ratio * ratio
    out[ImuAxis.accelerometer_x] += once * cosine
    out[ImuAxis.accelerometer_y] -= once * sine
    out[ImuAxis.accelerometer_z] += twice * (cosine * cosine - sine * sine)
    for axis in range(GYROS):
        value = out[axis] + bias[axis] + c.gyro_sigma * normals[axis]
        out[axis] = quantised(value, c.gyro_range, c.gyro_step, c.top_code)
        bias[axis] += c.gyro_walk_sigma * normals[IMU_SIZE + axis]
    for axis in range(GYROS, IMU_SIZE):
        value = out[axis] + bias[axis] + c.accelerometer_sigma * normals[axis]
        out[axis] = quantised(value, c.accelerometer_range, c.accelerometer_step, c.top_code)


@dataclass(frozen=True)
class ImuTruth:
    """What an IMU of one's own is told at each sample, body FRD."""

    rates: Vector3
    """p, q, r [rad/s]"""
    specific_force: Vector3
    """acceleration less gravity at the IMU's place, without vibration [m/s^2]; level at rest (0, 0, -g)"""
    azimuth: float
    """of the rotor, see `rotor_azimuth` [rad]"""
    rotor_speed: float
    """Omega [rad/s]"""
    stamp_ns: int
    """of the sample [ns]"""


@dataclass(frozen=True)
class ImuReading:
    """One sample of an IMU, body FRD."""

    gyro: Vector3
    """[rad/s]"""
    accelerometer: Vector3
    """specific force [m/s^2]"""
    valid: bool = True
    """whether both were measured at this sample"""


class Imu(Protocol):
    """An IMU of one's own; the one built in is `imu_sample`."""

    def sample(self, truth: ImuTruth) -> ImuReading:
        """The reading of this sample; called once every 2.5 ms, stamps ascending.

        Args:
            truth: what happens at the IMU's place.
        """
        ...
