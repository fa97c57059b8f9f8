"""What is known of the IMU at the helicopter's head (spec 2.3): place, noise, bias, vibration, range.

Noise densities are those of data sheets and of IEEE 952: a density N means white noise of two-sided spectrum
N^2 (the one-sided spectrum of the samples is 2 N^2). A sample of 1 / f_s then has the standard deviation
N sqrt(f_s), the mean over a time tau has N / sqrt(tau), and so has the Allan deviation: N is its value at
1 s, the angle or velocity random walk coefficient. Likewise the random walk of a bias has a coefficient K:
its standard deviation grows from zero as K sqrt(t).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_common.quantities import quantity
from heli_common.timing import SENSOR_PERIOD

Array = NDArray[np.float64]

STANDARD_GRAVITY = 9.80665
"""The unit g in which ranges of accelerometers are given [m/s^2]."""


@dataclass(frozen=True)
class ImuParameters:
    """The IMU; noise, biases and vibration may each be zero. Vibration is the peak at nominal rotor speed."""

    x: float = quantity(0.10, "m", "D", "place ahead of the centre of gravity", -2.0, 2.0)
    y: float = quantity(0.0, "m", "D", "place to the right of it", -2.0, 2.0)
    z: float = quantity(-0.05, "m", "D", "place below it", -2.0, 2.0)
    gyro_noise: float = quantity(
        math.radians(0.02), "rad/s/sqrt(Hz)", "D", "noise density of a gyro", 0.0, 1.0
    )
    gyro_bias: float = quantity(
        math.radians(0.5), "rad/s", "D", "standard deviation of a gyro's bias at power-up", 0.0, 1.0
    )
    gyro_walk: float = quantity(
        math.radians(0.01), "rad/s/sqrt(s)", "D", "random walk of a gyro's bias", 0.0, 1.0
    )
    accelerometer_noise: float = quantity(
        0.003, "m/s^2/sqrt(Hz)", "D", "noise density of an accelerometer", 0.0, 10.0
    )
    accelerometer_bias: float = quantity(
        0.05, "m/s^2", "D", "standard deviation of an accelerometer's bias at power-up", 0.0, 10.0
    )
    vibration_once: float = quantity(0.5, "m/s^2", "D", "rotor vibration at 1/rev, x and y", 0.0, 100.0)
    vibration_twice: float = quantity(0.8, "m/s^2", "D", "rotor vibration at 2/rev, z", 0.0, 100.0)
    gyro_range: float = quantity(math.radians(300.0), "rad/s", "D", "largest rate of a gyro", 0.01, 100.0)
    accelerometer_range: float = quantity(
        5.0 * STANDARD_GRAVITY, "m/s^2", "D", "largest specific force of an accelerometer", 1.0, 10000.0
    )
    bits: float = quantity(12.0, "bit", "D", "resolution over the whole range, both signs", 2.0, 32.0)


class ImuConstants(NamedTuple):
    """What the compiled IMU needs; every field a float, SI, noise per sample."""

    x: float
    """place from the centre of gravity, body FRD [m]"""
    y: float
    z: float
    gravity: float
    rotor_speed: float
    """at which vibration has its nominal amplitude [rad/s]"""
    vibration_once: float
    vibration_twice: float
    gyro_sigma: float
    """standard deviation of one sample's white noise [rad/s]"""
    gyro_walk_sigma: float
    """of one sample's step of the bias [rad/s]"""
    accelerometer_sigma: float
    """of one sample's white noise [m/s^2]"""
    gyro_range: float
    gyro_step: float
    """of the quantisation [rad/s]"""
    accelerometer_range: float
    accelerometer_step: float
    """of the quantisation [m/s^2]"""
    top_code: float
    """largest code of the quantisation; the smallest is one further from zero"""


def imu_constants(parameters: ImuParameters, gravity: float, rotor_speed: float) -> ImuConstants:
    """Constants of the compiled IMU, which samples at 400 Hz.

    Args:
        parameters: of the IMU.
        gravity: acceleration of gravity [m/s^2].
        rotor_speed: nominal rotor speed Omega_0 [rad/s].

    Raises:
        ValueError: a resolution that is no whole number of bits, a rotor speed that is not positive.
    """
    if not parameters.bits.is_integer():
        raise ValueError(f"bits {parameters.bits!r} is no whole number (allowed: 2 .. 32)")
    if not 0.0 < rotor_speed < math.inf:
        raise ValueError(f"rotor_speed {rotor_speed!r} rad/s must be positive and finite")
    codes = 2.0 ** (parameters.bits - 1.0)
    return ImuConstants(
        x=parameters.x,
        y=parameters.y,
        z=parameters.z,
        gravity=gravity,
        rotor_speed=rotor_speed,
        vibration_once=parameters.vibration_once,
        vibration_twice=parameters.vibration_twice,
        gyro_sigma=parameters.gyro_noise / math.sqrt(SENSOR_PERIOD),
        gyro_walk_sigma=parameters.gyro_walk * math.sqrt(SENSOR_PERIOD),
        accelerometer_sigma=parameters.accelerometer_noise / math.sqrt(SENSOR_PERIOD),
        gyro_range=parameters.gyro_range,
        gyro_step=parameters.gyro_range / codes,
        accelerometer_range=parameters.accelerometer_range,
        accelerometer_step=parameters.accelerometer_range / codes,
        top_code=codes - 1.0,
    )


def initial_bias(parameters: ImuParameters, generator: np.random.Generator) -> Array:
    """(6,) biases at power-up: gyro x, y, z [rad/s], accelerometer x, y, z [m/s^2].

    The bias that the specification names (0.5 deg/s, 0.05 m/s^2) is taken as the standard deviation of what
    differs from one power-up to the next: each axis is drawn on its own from N(0, bias^2).

    Args:
        parameters: of the IMU.
        generator: of the IMU's random numbers.
    """
    size = np.repeat([parameters.gyro_bias, parameters.accelerometer_bias], 3)
    return size * generator.standard_normal(len(size))


def imu_variances(c: ImuConstants) -> tuple[float, float]:
    """Variance of one sample of a gyro [rad^2/s^2] and of an accelerometer [m^2/s^4]: noise and quantisation.

    Args:
        c: constants of the IMU.
    """
    return (
        c.gyro_sigma**2 + c.gyro_step**2 / 12.0,
        c.accelerometer_sigma**2 + c.accelerometer_step**2 / 12.0,
    )
