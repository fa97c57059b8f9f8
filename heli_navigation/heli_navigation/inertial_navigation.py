"""Navigation with IMU and encoders: one sample in, pose, velocity, rates, biases and their covariances out.

Nothing is known before all six encoders have passed their index. Until then the gyros' means are taken
whenever no count changes, so that their biases are known when the filter begins.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_common.finite import require_finite
from heli_common.records import boxed, packed
from heli_common.rig_geometry import ENCODER_NAMES, RADIAN_PER_COUNT, RigGeometry
from heli_common.rotations import Euler, Vector3
from heli_common.topics import TOPICS
from heli_common.vehicle_state import NOWHERE, VehicleState, swap_body
from heli_navigation.beginning import FirstRest, first_memory
from heli_navigation.filter_memory import SIZE, Memory, Work, blank_memory
from heli_navigation.filter_outputs import (
    TWIST,
    BiasMessage,
    Output,
    read_alarms,
    read_biases,
    read_covariance,
    read_motion,
    read_odometry,
)
from heli_navigation.filter_parameters import FilterConstants, FilterParameters, filter_constants
from heli_navigation.inertial_filter import filter_run, filter_step

Array = NDArray[np.float64]

_NAN = (math.nan, math.nan, math.nan)
_NONE = (0.0, 0.0, 0.0)
_ODOMETRY = len(TOPICS["odometry"].layout.fields)
_COUNTERS = (
    (Memory.refused, Memory.innovation),
    (Memory.jumps, Memory.silent),
    (Memory.force_jumps, Memory.follow),
    (Memory.lines, Memory.end),
)


@dataclass(frozen=True)
class Health:
    """What navigation thinks of its sensors."""

    known: bool
    """whether there is a pose at all"""
    standing: bool
    """whether it takes the helicopter to stand on its stop, and learns biases"""
    without_imu: bool
    """whether the IMU is missing now"""
    lost: tuple[str, ...]
    """names of the encoders not believed now"""
    refused: tuple[int, ...]
    """(6,) readings outside their gate so far"""
    gyro_jumps: int
    """jumps of a gyro's bias found so far"""
    force_jumps: int
    """jumps of an accelerometer's bias found so far"""
    restarts: int
    """how often the estimate became meaningless and was begun anew"""
    rejected: int
    """samples whose arm angles fit no position when the filter wanted to begin"""

    @property
    def sound(self) -> bool:
        """Whether all sensors are there and believed."""
        return self.known and not self.without_imu and not self.lost


class InertialNavigation:
    """Error-state Kalman filter of the bench: every 2.5 ms one `step`, then whatever is to be read.

    Args:
        parameters: of the filter.
        geometry: of the rig.
    """

    def __init__(
        self, parameters: FilterParameters | None = None, geometry: RigGeometry | None = None
    ) -> None:
        self._geometry = geometry or RigGeometry()
        self._constants: FilterConstants = packed(
            filter_constants(parameters or FilterParameters(), self._geometry)
        )
        self._box = boxed(self._constants)
        self._memory, self._work = blank_memory(), np.zeros(Work.end)
        self._rows, self._out = np.zeros(TWIST * SIZE), np.zeros(Output.end)
        self._known, self._restarts, self._rejected = False, 0, 0
        self._rest = FirstRest(self._constants.period, self._constants.still_time)

    # One sample ----------------------------------------------------------------------------------------

    def step(
        self,
        arms: Sequence[float],
        gimbal: Sequence[float],
        indexed: Sequence[float],
        gyro: Sequence[float],
        accelerometer: Sequence[float],
        imu_valid: bool = True,
    ) -> None:
        """Take in the next sample, one period after the one before.

        Args:
            arms: (3,) angles of the arms as their counts say [rad].
            gimbal: (3,) yaw, pitch, roll as their counts say [rad].
            indexed: (6,) 1 for each encoder that has passed its index, arms first.
            gyro: (3,) body rates, FRD [rad/s].
            accelerometer: (3,) specific force at the IMU, FRD [m/s^2].
            imu_valid: whether gyro and accelerometer were measured now; if not, they do not matter.

        Raises:
            ValueError: a number that is said to be measured is not finite.
        """
        if not self._known or min(indexed) < 0.5:
            self._await(arms, gimbal, indexed, gyro, accelerometer, imu_valid)
            return
        arm_1, arm_2, arm_3 = arms
        psi, theta, phi = gimbal
        p, q, r = gyro
        x, y, z = accelerometer
        memory, box, work = self._memory, self._box, self._work
        if not filter_step(
            memory, arm_1, arm_2, arm_3, psi, theta, phi, p, q, r, x, y, z, imu_valid, box, work
        ):
            # not finite, or out of the arms' reach: begin again from the encoders
            self._restarts += 1
            self._known = False
            self._await(arms, gimbal, indexed, gyro, accelerometer, imu_valid)

    def run(self, samples: Array) -> None:
        """Take in several samples whose IMU is sound: as `step` one after the other, in one call.

        Args:
            samples: (n, 18 or more) counts of arms and gimbal; 1 for each encoder that has passed its index;
                body rates, FRD [rad/s]; specific force at the IMU, FRD [m/s^2]; more is not read.

        Raises:
            ValueError: a number is not finite.
        """
        taken = 0
        if self._known:
            taken = filter_run(self._memory, samples, self._box, self._work)
            if taken < 0:
                taken = -1 - taken
                self._restarts += 1
                self._known = False
                self._await(*_parts(samples[taken]), True)
                taken += 1
        for sample in samples[taken:]:
            self.step(*_parts(sample))

    def skip(self, samples: int) -> None:
        """Go on over samples that never came, by what was known before them.

        Args:
            samples: how many periods of 2.5 ms.
        """
        if not self._known:
            return
        for _ in range(samples):
            filter_step(self._memory, *_NAN, *_NAN, *_NONE, *_NONE, False, self._box, self._work)

    # What is known -------------------------------------------------------------------------------------

    @property
    def known(self) -> bool:
        """Whether there is a pose; before, every other reading is zero."""
        return self._known

    @property
    def state(self) -> VehicleState:
        """Position, attitude, velocity and rates at the centre of gravity, of the latest sample."""
        if not self._known:
            return NOWHERE
        read_motion(self._memory, self._box, self._work, self._out)
        x, y, z, psi, theta, phi, u, v, w, p, q, r = self._out[: Output.pose].tolist()
        return VehicleState((x, y, z), Euler(psi, theta, phi), (u, v, w), (p, q, r))

    @property
    def covariances(self) -> tuple[Array, Array]:
        """Two (6, 6); zeros while nothing is known.

        Of position and rotations about north, east, down [m, rad]; of velocity and rates, FRD [m/s, rad/s].
        """
        if self._known:
            read_covariance(self._memory, self._box, self._work, self._rows, self._out)
        pose, twist = self._out[Output.pose : Output.twist], self._out[Output.twist :]
        return pose.reshape(TWIST, TWIST).copy(), twist.reshape(TWIST, TWIST).copy()

    @property
    def odometry(self) -> Array:
        """(85,) numbers of an Odometry in ENU/FLU; only while `known`."""
        values = np.empty(_ODOMETRY)
        read_odometry(self._memory, self._box, self._work, self._rows, self._out, values)
        return values

    @property
    def biases(self) -> Array:
        """(18,) what is known of the IMU's biases, in the parts of `BiasMessage`; the noise is zero."""
        values = np.zeros(BiasMessage.end)
        read_biases(self._memory, self._box, values)
        return values

    @property
    def gyro_bias(self) -> Vector3:
        """Estimated biases of the gyros, body FRD [rad/s]; without IMU those from before."""
        x, y, z = self.biases[:3].tolist()
        return swap_body((x, y, z))

    @property
    def accelerometer_bias(self) -> Vector3:
        """Estimated biases of the accelerometers, body FRD [m/s^2]."""
        x, y, z = self.biases[3:6].tolist()
        return swap_body((x, y, z))

    @property
    def bias_deviations(self) -> tuple[float, ...]:
        """(6,) standard deviations of the biases, gyros [rad/s] first [m/s^2]."""
        return tuple(self.biases[BiasMessage.deviation :].tolist())

    @property
    def covariance(self) -> Array:
        """(15, 15) of the filter's errors, in the order of `Estimate`."""
        return self._memory[Memory.covariance : Memory.gyro].reshape(SIZE, SIZE).copy()

    @property
    def innovations(self) -> tuple[float, ...]:
        """(6,) innovations of the latest line of each encoder, in their deviations."""
        return tuple(self._memory[Memory.innovation : Memory.unchanged].tolist())

    @property
    def alarms(self) -> tuple[bool, int, int]:
        """Changes whenever that part of `health` does which people must be told."""
        return self._known, self._restarts, read_alarms(self._memory)

    @property
    def health(self) -> Health:
        """What navigation thinks of its sensors."""
        memory = self._memory
        flags = memory[Memory.lost : Memory.agreed].tolist()
        return Health(
            known=self._known,
            standing=bool(memory[Memory.standing] > 0.0),
            without_imu=bool(memory[Memory.coasting] > 0.0),
            lost=tuple(name for name, flag in zip(ENCODER_NAMES, flags, strict=True) if flag > 0.0),
            refused=tuple(int(number) for number in memory[Memory.refused : Memory.innovation]),
            gyro_jumps=int(memory[Memory.jumps : Memory.silent].sum()),
            force_jumps=int(memory[Memory.force_jumps]),
            restarts=self._restarts,
            rejected=self._rejected,
        )

    # The beginning -------------------------------------------------------------------------------------

    def _await(
        self,
        arms: Sequence[float],
        gimbal: Sequence[float],
        indexed: Sequence[float],
        gyro: Sequence[float],
        accelerometer: Sequence[float],
        imu_valid: bool,
    ) -> None:
        """Nothing is known yet: take the gyros' means at rest, begin once the encoders are absolute."""
        self._known = False
        angles_now = (*arms, *gimbal)
        if imu_valid:
            require_finite("imu", (*gyro, *accelerometer))
            self._rest.add(angles_now, gyro)
        if min(indexed) < 0.5 or not all(map(math.isfinite, angles_now)):
            return
        c = self._constants
        bias = self._rest.bias(c.gyro_density, c.gyro_bias)
        if not imu_valid:
            gyro = bias[0].tolist()
        try:
            memory = first_memory(
                _vector(arms), _vector(gimbal), _vector(gyro), _vector(accelerometer), bias, c, self._geometry
            )
        except ValueError:
            self._rejected += 1
            return
        for start, end in _COUNTERS:  # what has happened stays known
            memory[start:end] = self._memory[start:end]
        self._memory, self._known = memory, True


def _parts(sample: Array) -> tuple[list[float], list[float], list[float], list[float], list[float]]:
    """Arms, gimbal, flags, rates and forces of one sample of `InertialNavigation.run`."""
    s: list[float] = sample.tolist()
    angles = [count * RADIAN_PER_COUNT for count in s[0:6]]
    return angles[0:3], angles[3:6], s[6:12], s[12:15], s[15:18]


def _vector(values: Sequence[float]) -> Vector3:
    x, y, z = values
    return (float(x), float(y), float(z))
