"""Bias, noise and vibration of the IMU, measured in flight against the encoders (source section 4.2).

Between two samples the encoders say by how much the Euler angles have changed, and so what the mean body
rates were (source eq. A.11); an attitude also says what the accelerometers would read without acceleration.
What the IMU reads beyond that, less the terms of its lever arm, is bias, noise and vibration:

- Bias is its mean. Counts make the rates of single samples useless, but over a time t they add up to the
  change of an angle, known to a fraction of a count. Accelerations likewise add up to a change of velocity.
- Noise is what is left of six differences of the reading, one after the other: they pass white noise with 924
  times its variance, a vibration of 52 Hz, twice per turn, with 0.06 times, slow motion not at all.
- Vibration is the spread of the reading within tenths of a second, less the noise.
- The Allan deviation over 1 s and 10 s is that of what the bias is taken from. Of a gyro it shows the counts
  at 1 s, noise and walk of the bias at 10 s; of an accelerometer it shows the helicopter's own motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_common.records import boxed, packed
from heli_common.rig_geometry import RADIAN_PER_COUNT
from heli_common.timing import SENSOR_PERIOD
from heli_navigation.imu_attitude_parameters import ImuAttitudeParameters, imu_attitude_constants
from heli_navigation.imu_monitor_equations import (
    DIFFERENCE_GAIN,
    AllanPart,
    MonitorMemory,
    monitor_step,
)

Array = NDArray[np.float64]
Axes = tuple[float, ...]


@dataclass(frozen=True)
class ImuFigures:
    """What was measured of gyros x, y, z and accelerometers x, y, z, body FRD, SI; 0 if not yet known."""

    duration: float
    """over which [s]"""
    bias: Axes
    """mean over the duration [rad/s], [m/s^2]"""
    bias_sigma: Axes
    """standard deviation of it"""
    noise: Axes
    """density [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)], quantisation included"""
    vibration: Axes
    """rms of what else changes within 0.1 s; of gyros it is the helicopter's motion [rad/s], [m/s^2]"""
    allan_1_s: Axes
    """Allan deviation over 1 s [rad/s], [m/s^2]"""
    allan_10_s: Axes
    """Allan deviation over 10 s"""


class ImuMonitor:
    """Measures the IMU against the encoders; figures at any time, over all samples since the last reset.

    Args:
        parameters: place of the IMU, gravity and the spread of the velocity are taken from them.
    """

    def __init__(self, parameters: ImuAttitudeParameters | None = None) -> None:
        self.parameters = parameters or ImuAttitudeParameters()
        self._box = boxed(packed(imu_attitude_constants(self.parameters)))
        self._memory = np.zeros(MonitorMemory.end)

    def reset(self) -> None:
        """Forget everything, for example at take-off."""
        self._memory[:] = 0.0

    def step(
        self,
        attitude: Sequence[float],
        gyro: Sequence[float],
        accelerometer: Sequence[float],
        valid: bool = True,
    ) -> None:
        """Take in one sample of 2.5 ms; call it once for every sample, lost ones included.

        Args:
            attitude: (3,) psi, theta, phi of the encoders [rad].
            gyro: (3,) readings, body FRD [rad/s].
            accelerometer: (3,) readings, body FRD [m/s^2].
            valid: whether both encoders and IMU were measured at this sample; else neither is looked at.

        Raises:
            ValueError: a valid number that is not finite; the monitor is as it was.
        """
        (psi, theta, phi), (p, q, r), (x, y, z) = attitude, gyro, accelerometer
        if not monitor_step(self._memory, psi, theta, phi, p, q, r, x, y, z, valid, self._box):
            told = (*attitude, *gyro, *accelerometer)
            raise ValueError(f"attitude and IMU {told!r} are not nine finite numbers")

    def figures(self) -> ImuFigures:
        """What was measured so far."""
        part, memory = MonitorMemory, self._memory
        count = max(1.0, float(memory[part.samples]))
        duration = count * SENSOR_PERIOD
        samples = max(1.0, float(memory[part.noise_samples]))
        noise = memory[part.noise_square : part.spread_count] / (samples * DIFFERENCE_GAIN)
        density = np.sqrt(noise * SENSOR_PERIOD)
        spread = memory[part.variance : part.short] / max(1.0, float(memory[part.spreads]))
        return ImuFigures(
            duration=float(memory[part.samples]) * SENSOR_PERIOD,
            bias=_axes(memory[part.total : part.noise_samples] / count),
            bias_sigma=_axes(np.sqrt(density**2 / duration + self._ends() / duration**2)),
            noise=_axes(density),
            vibration=_axes(np.sqrt(np.maximum(spread - noise, 0.0))),
            allan_1_s=self._allan(part.short),
            allan_10_s=self._allan(part.long),
        )

    def _ends(self) -> Array:
        """(6,) variance of what changes from the first to the last sample: angles, velocities."""
        return np.repeat([RADIAN_PER_COUNT**2 / 6.0, 2.0 * self.parameters.velocity_spread**2], 3)

    def _allan(self, first: int) -> Axes:
        square = self._memory[first + AllanPart.square : first + AllanPart.end]
        return _axes(np.sqrt(0.5 * square / max(1.0, float(self._memory[first + AllanPart.pairs]))))


def _axes(values: Array) -> Axes:
    return tuple(values.tolist())
