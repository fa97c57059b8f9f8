"""The navigation as a component: encoders, IMU and rotor speed in, odometry and what is known of the IMU out.

Every sample of the encoders is taken together with the IMU's of the same stamp. Should the IMU fall silent,
the navigation waits for it once, then goes on without until it speaks again; samples of the encoders that
never come are gone over by what was known before them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from heli_common import topics
from heli_common.component import Message
from heli_common.finite import require_finite
from heli_common.quantities import quantity
from heli_common.rig_geometry import ENCODER_NAMES, RigGeometry
from heli_common.rotations import Vector3
from heli_common.timing import CONTROL_PERIOD, SENSOR_PERIOD_NS, is_control_tick
from heli_common.vehicle_state import (
    NOWHERE,
    UNKNOWN_VARIANCE,
    imu_from_values,
    odometry_values,
)
from heli_navigation.differentiator import LowPass
from heli_navigation.filter_outputs import BiasMessage
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.imu_attitude import ImuAttitude
from heli_navigation.imu_attitude_parameters import ImuAttitudeParameters
from heli_navigation.imu_monitor import ImuMonitor
from heli_navigation.inertial_navigation import Health, InertialNavigation

IMU_PATIENCE = 12
"""Samples of the encoders for which the first missing one of the IMU is waited for: 30 ms."""

NOISE_PERIOD_NS = 1_000_000_000
"""How often the measured noise of the IMU is renewed."""

LONGEST_SKIP = 400
"""Lost samples that are gone over; after a longer silence the filter begins anew."""

_FIRST_EFFORT = 2 * len(ENCODER_NAMES)
_ROTOR_SPEED = topics.TOPICS["rotor"].layout.fields.index("velocity.rotor")
_NOWHERE = odometry_values(NOWHERE, (UNKNOWN_VARIANCE,) * 6, (UNKNOWN_VARIANCE,) * 6)
_NOTHING: Vector3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class NavigationParameters:
    """What is no filter's own."""

    rotor_bandwidth: float = quantity(
        100.0, "rad/s", "D", "low-pass of the rotor speed: 6 ms late", 5.0, 1000.0
    )


class _Sample(NamedTuple):
    """What a sample said beside the angles of the arms, as far as `update` needs it."""

    stamp_ns: int
    gimbal: Sequence[float]
    gyro: Vector3
    accelerometer: Vector3
    valid: bool
    known: bool
    """whether there was a pose before it"""


class Navigator:
    """Component: Kalman filter of the bench, and the attitude by the IMU alone beside it.

    While an encoder is not indexed nothing is known: pose and twist are zero with UNKNOWN_VARIANCE.

    Args:
        parameters: of the rotor speed's filter.
        geometry: of the rig.
        filter_parameters: of the Kalman filter.
        attitude_parameters: of the attitude by the IMU alone.

    Attributes:
        gaps: times at which samples of the encoders were missing.
    """

    name = topics.NAVIGATION
    inputs: tuple[str, ...] = ("rotor", "encoders", "imu")
    waking: tuple[str, ...] = ("imu",)
    outputs: tuple[str, ...] = ("odometry", "odometry_imu", "imu_attitude", "imu_bias", "rotor_state")

    def __init__(
        self,
        parameters: NavigationParameters,
        geometry: RigGeometry,
        filter_parameters: FilterParameters | None = None,
        attitude_parameters: ImuAttitudeParameters | None = None,
    ) -> None:
        self.gaps = 0
        self._geometry = geometry
        self._filter_parameters = filter_parameters or FilterParameters()
        self._filter = InertialNavigation(self._filter_parameters, geometry)
        self._by_imu = ImuAttitude(attitude_parameters)
        self._monitor = ImuMonitor(attitude_parameters)
        self._noise: tuple[float, ...] = (0.0,) * 6
        self._rotor = LowPass(parameters.rotor_bandwidth, CONTROL_PERIOD)
        self._encoders: deque[tuple[int, Sequence[float]]] = deque()
        self._imu: dict[int, Sequence[float]] = {}
        self._imu_silent = False
        self._last_ns: int | None = None
        self._latest: _Sample | None = None
        self._alarms = self._filter.alarms
        self._complaints = ""

    @property
    def health(self) -> Health:
        """What the navigation thinks of its sensors."""
        return self._filter.health

    @property
    def complaints(self) -> str:
        """What is wrong with the sensors, for people; empty if nothing is."""
        return self._complaints

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Take in one message; give back the odometry of every sample that is complete.

        What the IMU alone says of it comes by `update`.

        Raises:
            ValueError: another topic, or a number that is not finite.
        """
        if topic not in self.inputs:
            raise ValueError(f"topic {topic!r} is none of {self.inputs}")
        require_finite(topic, values)
        if topic == "rotor":
            return [Message("rotor_state", stamp_ns, (0.0, self._rotor.step(values[_ROTOR_SPEED]), 0.0))]
        if topic == "imu":
            if self._last_ns is None or stamp_ns > self._last_ns:
                self._imu[stamp_ns] = values
            self._imu_silent = False
        else:
            self._encoders.append((stamp_ns, values))
        return self._go_on()

    def _go_on(self) -> list[Message]:
        """Take every sample of the encoders whose IMU sample is here, or is waited for no longer."""
        sent: list[Message] = []
        while self._encoders:
            stamp_ns, values = self._encoders[0]
            felt = self._imu.pop(stamp_ns, None)
            if felt is None and not self._imu_silent:
                if len(self._encoders) <= IMU_PATIENCE:
                    break
                self._imu_silent = True
            self._encoders.popleft()
            sent += self.update()
            self._sample(stamp_ns, values, felt)
            sent += self._odometry(stamp_ns)
        if self._imu and self._last_ns is not None and min(self._imu) <= self._last_ns:
            self._imu = {stamp: felt for stamp, felt in self._imu.items() if stamp > self._last_ns}
        return sent

    def _sample(self, stamp_ns: int, values: Sequence[float], felt: Sequence[float] | None) -> None:
        """Bring the Kalman filter to one sample."""
        if self._last_ns is not None and stamp_ns - self._last_ns != SENSOR_PERIOD_NS:
            self.gaps += 1
            missing = (stamp_ns - self._last_ns) // SENSOR_PERIOD_NS - 1
            if missing > LONGEST_SKIP:
                self._filter = InertialNavigation(self._filter_parameters, self._geometry)
            else:
                self._filter.skip(missing)
        self._last_ns = stamp_ns
        gyro, accelerometer, valid = (_NOTHING, _NOTHING, False) if felt is None else imu_from_values(felt)
        indexed = values[_FIRST_EFFORT:]
        known = self._filter.known
        self._filter.step(values[0:3], values[3:6], indexed, gyro, accelerometer, valid)
        self._latest = _Sample(stamp_ns, values[3:6], gyro, accelerometer, valid, known)

    def _odometry(self, stamp_ns: int) -> list[Message]:
        odometry = self._filter.odometry if self._filter.known else _NOWHERE
        sent = [Message("odometry_imu", stamp_ns, odometry)]
        # first, for a command waits for it
        return [Message("odometry", stamp_ns, odometry), *sent] if is_control_tick(stamp_ns) else sent

    def update(self) -> list[Message]:
        """Take the latest sample into what the IMU alone says, once its odometry is out.

        Returns:
            attitude by the IMU and its biases, at a control tick.
        """
        if self._latest is None:
            return []
        stamp_ns, gimbal, gyro, accelerometer, valid, known = self._latest
        self._latest = None
        self._by_imu.step(gyro, accelerometer, valid)
        if self._filter.known:
            self._monitor.step(gimbal, gyro, accelerometer, valid)
            if not known:
                self._by_imu.align(*self._filter.state.attitude)
        if not is_control_tick(stamp_ns):
            return []
        if self._filter.alarms != self._alarms:
            self._alarms = self._filter.alarms
            self._complaints = _complaints(self._filter.health)
        if stamp_ns % NOISE_PERIOD_NS == 0:
            self._noise = self._monitor.figures().noise
        biases = self._filter.biases
        biases[BiasMessage.noise : BiasMessage.deviation] = self._noise
        return [
            Message("imu_attitude", stamp_ns, self._by_imu.message),
            Message("imu_bias", stamp_ns, biases),
        ]


def _complaints(health: Health) -> str:
    said = []
    if health.known and health.without_imu:
        said.append("no IMU")
    if health.known and health.lost:
        said.append(f"not believed: {', '.join(health.lost)}")
    if health.gyro_jumps:
        said.append(f"jumps of a gyro's bias so far: {health.gyro_jumps}")
    if health.restarts:
        said.append(f"begun anew so far: {health.restarts}")
    return "; ".join(said)
