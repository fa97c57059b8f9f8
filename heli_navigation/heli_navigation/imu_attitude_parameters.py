"""What the attitude filter without encoders must know of its IMU and of the way the helicopter moves.

Noise densities are those of data sheets: a density N means white noise whose mean over a time tau has the
standard deviation N / sqrt(tau); a random walk K has grown to K sqrt(t) after a time t.

How much the accelerometers are believed (D). An accelerometer cannot tell acceleration from tilt. But a
helicopter that stays in its place has a bounded velocity: with a deviation sigma_v, a filter that follows the
accelerometers with the bandwidth K_1 is wrong by K_1 sigma_v / g. White noise of density S in the place of
the acceleration makes, in the filter of second order that is the best for gyros whose bias walks with K,

    K_1 = sqrt(2) omega,    omega^4 = K^2 g^2 / S,    variance of the tilt 3/4 K_1 S / g^2.

Both errors are equal for S = 4/3 K_1 sigma_v^2, hence omega^5 = 3 K^2 g^2 / (4 sqrt(2) sigma_v^2). That S is
the measurement noise: what the filter says of its tilt holds, though acceleration is far from white.
Vibration of the rotor needs no allowance: at 26 Hz a filter of K_1 = 0.25 rad/s lets 1/650 of it through.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from heli_common.quantities import quantity
from heli_common.rig_geometry import RADIAN_PER_COUNT
from heli_common.timing import SENSOR_PERIOD

SLOWEST_CORRECTION = 0.02
"""Least omega of the correction by the accelerometers, for gyros whose bias does not walk [rad/s]."""


@dataclass(frozen=True)
class ImuAttitudeParameters:
    """IMU, motion and standstill as the attitude filter takes them; the text of each says what it acts on."""

    imu_x: float = quantity(0.10, "m", "D", "place of the IMU ahead of the centre of gravity", -2.0, 2.0)
    imu_y: float = quantity(0.0, "m", "D", "place of the IMU to the right of it", -2.0, 2.0)
    imu_z: float = quantity(-0.05, "m", "D", "place of the IMU below it", -2.0, 2.0)
    gravity: float = quantity(9.81, "m/s^2", "T", "acceleration of gravity", 9.0, 10.0)
    gyro_noise: float = quantity(math.radians(0.02), "rad/s/sqrt(Hz)", "D", "noise of a gyro", 1e-6, 0.1)
    gyro_bias: float = quantity(
        math.radians(0.5), "rad/s", "D", "deviation of a gyro's bias at power-up", 1e-5, 1.0
    )
    gyro_walk: float = quantity(math.radians(0.01), "rad/s/sqrt(s)", "D", "walk of a gyro's bias", 0.0, 0.1)
    accelerometer_noise: float = quantity(
        0.003, "m/s^2/sqrt(Hz)", "D", "noise of an accelerometer", 1e-5, 10.0
    )
    accelerometer_bias: float = quantity(
        0.05, "m/s^2", "D", "deviation of an accelerometer's constant bias", 0.0, 10.0
    )
    alignment: float = quantity(
        RADIAN_PER_COUNT / math.sqrt(12.0),
        "rad",
        "D",
        "deviation of the angles given to start from",
        1e-5,
        1.0,
    )
    velocity_spread: float = quantity(
        0.1, "m/s", "D", "deviation of the helicopter's velocity while it stays in its place", 0.001, 10.0
    )
    agitation_time: float = quantity(
        1.0, "s", "D", "over which velocity is summed up to see whether it exceeds its spread", 0.05, 60.0
    )
    agitation_limit: float = quantity(
        3.0, "-", "D", "largest share by which agitation adds to the noise of accelerometers", 0.0, 1000.0
    )
    patience: float = quantity(
        2.0,
        "s",
        "D",
        "agitation at its limit for longer is no motion but the jump of a gyro's bias",
        0.1,
        60.0,
    )
    jump_walk: float = quantity(
        math.radians(0.5), "rad/s/sqrt(s)", "D", "walk of the gyros' biases while that lasts", 0.0, 1.0
    )
    blind_noise: float = quantity(
        math.radians(4.0),
        "rad/s/sqrt(Hz)",
        "D",
        "density of the unknown rate while there is no IMU",
        1e-3,
        10.0,
    )
    still_margin: float = quantity(
        1.3,
        "-",
        "D",
        "standing if no reading spreads more, in deviations of the IMU's noise; 0: never",
        0.0,
        10.0,
    )
    still_rate: float = quantity(
        math.radians(0.01), "rad/s", "D", "deviation of the rate that may hide in a standstill", 1e-6, 0.1
    )
    still_gate: float = quantity(
        4.0, "-", "D", "a mean rate so many deviations off is no standstill but a turn", 1.0, 100.0
    )


class ImuAttitudeConstants(NamedTuple):
    """What the compiled filter needs; every field a float, SI, noise per sample."""

    period: float
    """of the samples [s]"""
    x: float
    """place of the IMU from the centre of gravity, body FRD [m]"""
    y: float
    z: float
    gravity: float
    turn_variance: float
    """of the angle by the gyros' noise in one sample [rad^2]"""
    blind_variance: float
    """of the angle by the unknown rate in one sample without IMU [rad^2]"""
    walk_variance: float
    """of one sample's step of a gyro's bias [rad^2/s^2]"""
    gyro_bias: float
    """variance at power-up [rad^2/s^2]"""
    accelerometer_bias: float
    """variance [m^2/s^4]"""
    force_variance: float
    """of one accelerometer sample in calm flight, acceleration of the helicopter included [m^2/s^4]"""
    alignment: float
    """variance [rad^2]"""
    velocity_variance: float
    """of the helicopter in calm flight [m^2/s^2]"""
    tilt_velocity: float
    """square of what velocity a tilt of 1 rad feigns [m^2/s^2]"""
    velocity_kept: float
    """share of the summed-up velocity that is left after one sample"""
    agitation_limit: float
    patience: float
    jump_variance: float
    """of one sample's step of a gyro's bias while it is taken to have jumped [rad^2/s^2]"""
    still_gyro: float
    """largest variance of gyro readings in a standstill [rad^2/s^2]"""
    still_force: float
    """the same of accelerometers [m^2/s^4]"""
    still_variance: float
    """of the mean rate over a window of standstill [rad^2/s^2]"""
    still_gate: float
    """square of the largest mean rate, in its deviations"""


STILL_SAMPLES = 200
"""Length of the windows in which a standstill is looked for; 0.5 s."""


def imu_attitude_constants(parameters: ImuAttitudeParameters) -> ImuAttitudeConstants:
    """Constants of the compiled filter, which takes samples at 400 Hz.

    Args:
        parameters: of the filter.
    """
    p = parameters
    sample_gyro = p.gyro_noise**2 / SENSOR_PERIOD
    sample_force = p.accelerometer_noise**2 / SENSOR_PERIOD
    return ImuAttitudeConstants(
        period=SENSOR_PERIOD,
        x=p.imu_x,
        y=p.imu_y,
        z=p.imu_z,
        gravity=p.gravity,
        turn_variance=p.gyro_noise**2 * SENSOR_PERIOD,
        blind_variance=p.blind_noise**2 * SENSOR_PERIOD,
        walk_variance=p.gyro_walk**2 * SENSOR_PERIOD,
        gyro_bias=p.gyro_bias**2,
        accelerometer_bias=p.accelerometer_bias**2,
        force_variance=acceleration_density(p) / SENSOR_PERIOD + sample_force,
        alignment=p.alignment**2,
        velocity_variance=p.velocity_spread**2,
        tilt_velocity=(p.gravity * p.agitation_time) ** 2,
        velocity_kept=math.exp(-SENSOR_PERIOD / p.agitation_time),
        agitation_limit=p.agitation_limit,
        patience=p.patience,
        jump_variance=p.jump_walk**2 * SENSOR_PERIOD,
        still_gyro=p.still_margin**2 * sample_gyro,
        still_force=p.still_margin**2 * sample_force,
        still_variance=sample_gyro / STILL_SAMPLES + p.still_rate**2,
        still_gate=p.still_gate**2,
    )


def correction_bandwidth(parameters: ImuAttitudeParameters) -> float:
    """omega of the correction by the accelerometers in calm flight [rad/s]; see the head of this module.

    Args:
        parameters: of the filter.
    """
    walk = parameters.gyro_walk * parameters.gravity / parameters.velocity_spread
    return max(SLOWEST_CORRECTION, math.pow(3.0 / (4.0 * math.sqrt(2.0)) * walk**2, 0.2))


def acceleration_density(parameters: ImuAttitudeParameters) -> float:
    """S: density of the white noise that stands for the helicopter's acceleration [m^2/s^3].

    Args:
        parameters: of the filter.
    """
    gain = math.sqrt(2.0) * correction_bandwidth(parameters)
    return 4.0 / 3.0 * gain * parameters.velocity_spread**2
