"""What the inertial filter must know: IMU, encoders, gates, alignment, behaviour without IMU.

Noise densities are those of data sheets: a density N means white noise whose mean over a time tau has the
standard deviation N / sqrt(tau); a random walk K has grown to K sqrt(t) after a time t.

Rotor vibration is no white noise. A sinus of amplitude a at omega makes a velocity error of a / omega that
does not grow, so it is allowed for in what is said of the velocity and not in the noise of the filter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from heli_common.quantities import quantity
from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_common.timing import SENSOR_PERIOD


@dataclass(frozen=True)
class FilterParameters:
    """Noise, place, gates and waiting times of the filter; the text of each says what it acts on."""

    imu_x: float = quantity(0.10, "m", "D", "place of the IMU ahead of the centre of gravity", -2.0, 2.0)
    imu_y: float = quantity(0.0, "m", "D", "place of the IMU to the right of it", -2.0, 2.0)
    imu_z: float = quantity(-0.05, "m", "D", "place of the IMU below it", -2.0, 2.0)
    gravity: float = quantity(9.81, "m/s^2", "T", "acceleration of gravity", 9.0, 10.0)
    gyro_noise: float = quantity(math.radians(0.02), "rad/s/sqrt(Hz)", "D", "noise of a gyro", 1e-6, 0.1)
    gyro_walk: float = quantity(math.radians(0.01), "rad/s/sqrt(s)", "D", "walk of a gyro's bias", 0.0, 0.1)
    gyro_bias: float = quantity(
        math.radians(1.0), "rad/s", "D", "deviation of a gyro's bias at power-up", 1e-4, 1.0
    )
    accelerometer_noise: float = quantity(
        0.003, "m/s^2/sqrt(Hz)", "D", "noise of an accelerometer", 1e-5, 10.0
    )
    accelerometer_walk: float = quantity(
        0.0002, "m/s^2/sqrt(s)", "D", "walk of an accelerometer's bias", 0.0, 1.0
    )
    accelerometer_bias: float = quantity(
        0.1, "m/s^2", "D", "deviation of an accelerometer's bias at power-up", 1e-3, 10.0
    )
    vibration_once: float = quantity(0.5, "m/s^2", "D", "rotor vibration at 1/rev, x and y", 0.0, 100.0)
    vibration_twice: float = quantity(0.8, "m/s^2", "D", "rotor vibration at 2/rev, z", 0.0, 100.0)
    rotor_speed: float = quantity(163.363, "rad/s", "T", "rotor speed of the vibration", 1.0, 400.0)
    line_error: float = quantity(
        0.01, "count", "D", "deviation of an encoder's line from its place", 1e-3, 0.5
    )
    gate: float = quantity(5.0, "", "D", "innovation that is not believed, in its deviations", 2.0, 100.0)
    patience: float = quantity(0.05, "s", "D", "disagreement after which a sensor is judged", 0.005, 10.0)
    bias_jump: float = quantity(
        math.radians(2.0), "rad/s", "D", "deviation of a jump of a gyro's bias", 1e-3, 10.0
    )
    force_jump: float = quantity(
        0.5, "m/s^2", "D", "deviation of a jump of an accelerometer's bias", 1e-3, 100.0
    )
    still_time: float = quantity(0.4, "s", "D", "no count changes: the helicopter stands", 0.05, 60.0)
    still_height: float = quantity(0.02, "m", "D", "standing is believed this near the stop", 0.0, 0.5)
    coast_turn: float = quantity(
        0.5, "rad/s^2/sqrt(Hz)", "D", "angular acceleration while there is no IMU", 1e-3, 100.0
    )
    coast_force: float = quantity(
        0.2, "m/s^2/sqrt(Hz)", "D", "specific force beside the weight while there is no IMU", 1e-3, 100.0
    )


class FilterConstants(NamedTuple):
    """What the compiled filter needs; every field a float, SI."""

    period: float
    """of the samples [s]"""
    x: float
    """place of the IMU from the centre of gravity, body FRD [m]"""
    y: float
    z: float
    gravity: float
    inward: float
    """base circle less platform circle of the arms [m]"""
    upper_arm: float
    forearm: float
    centre_height: float
    cell: float
    """angle of one count [rad]"""
    cell_variance: float
    """of an angle of which only the count is known: cell^2 / 12 [rad^2]"""
    line_variance: float
    """of the place of a line [rad^2]"""
    gyro_density: float
    """square of the gyros' noise density [rad^2/s]"""
    gyro_walk: float
    """square of the bias walk [rad^2/s^3]"""
    accelerometer_density: float
    """square of the accelerometers' noise density [m^2/s^3]"""
    accelerometer_walk: float
    """square of the bias walk [m^2/s^5]"""
    gyro_bias: float
    """variance at power-up [rad^2/s^2]"""
    accelerometer_bias: float
    """variance at power-up [m^2/s^4]"""
    shake_once: float
    """variance of the velocity by vibration, x and y [m^2/s^2]"""
    shake_twice: float
    """the same, z [m^2/s^2]"""
    force_once: float
    """variance of the specific force by vibration, x and y [m^2/s^4]"""
    force_twice: float
    """the same, z [m^2/s^4]"""
    gate: float
    """square of the largest innovation believed, in its deviations"""
    patience: float
    bias_jump: float
    """variance [rad^2/s^2]"""
    force_jump: float
    """variance [m^2/s^4]"""
    still_time: float
    still_depth: float
    """NED z beyond which standing is believed [m]"""
    coast_turn: float
    """square of the density of angular acceleration [rad^2/s^3]"""
    coast_force: float
    """square of the density of specific force [m^2/s^3]"""


def filter_constants(parameters: FilterParameters, geometry: RigGeometry) -> FilterConstants:
    """Constants of the compiled filter.

    Args:
        parameters: of the filter.
        geometry: of the rig.
    """
    p = parameters
    speed = p.rotor_speed
    return FilterConstants(
        period=SENSOR_PERIOD,
        x=p.imu_x,
        y=p.imu_y,
        z=p.imu_z,
        gravity=p.gravity,
        inward=geometry.base_radius - geometry.platform_radius,
        upper_arm=geometry.upper_arm,
        forearm=geometry.forearm,
        centre_height=geometry.centre_height,
        cell=RADIAN_PER_COUNT,
        cell_variance=RADIAN_PER_COUNT**2 / 12.0,
        line_variance=(p.line_error * RADIAN_PER_COUNT) ** 2,
        gyro_density=p.gyro_noise**2,
        gyro_walk=p.gyro_walk**2,
        accelerometer_density=p.accelerometer_noise**2,
        accelerometer_walk=p.accelerometer_walk**2,
        gyro_bias=p.gyro_bias**2,
        accelerometer_bias=p.accelerometer_bias**2,
        shake_once=0.5 * (p.vibration_once / speed) ** 2,
        shake_twice=0.5 * (p.vibration_twice / (2.0 * speed)) ** 2,
        force_once=0.5 * p.vibration_once**2,
        force_twice=0.5 * p.vibration_twice**2,
        gate=p.gate**2,
        patience=p.patience,
        bias_jump=p.bias_jump**2,
        force_jump=p.force_jump**2,
        still_time=p.still_time,
        still_depth=geometry.rest_depth - p.still_height,
        coast_turn=p.coast_turn**2,
        coast_force=p.coast_force**2,
    )
