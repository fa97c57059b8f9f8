"""Navigation by differentiating the encoders: what flew first, kept as the measure of the Kalman filter.

Position is the forward kinematics of the arm angles, attitude the gimbal angles themselves. Velocities are
differentiated in earth axes and turned into the body, rates follow from the differentiated Euler angles
(source app. A.2):

    p = phi' - psi' sin theta
    q = theta' cos phi + psi' cos theta sin phi
    r = -theta' sin phi + psi' cos theta cos phi
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin

from heli_common import topics
from heli_common.component import Message, StampJoin
from heli_common.finite import require_finite
from heli_common.quantities import quantity
from heli_common.rig_geometry import ENCODER_NAMES, QUANTISATION_VARIANCE, RigGeometry
from heli_common.rotations import Euler, Matrix3, Vector3, matrix_from_euler, rotate, transpose
from heli_common.timing import CONTROL_PERIOD, SENSOR_PERIOD, SENSOR_PERIOD_NS, is_control_tick
from heli_common.vehicle_state import NOWHERE, UNKNOWN_VARIANCE, VehicleState, odometry_values, swap_earth
from heli_navigation.arm_kinematics import arm_jacobian, position_from_arms, position_variance
from heli_navigation.differentiator import Differentiator, LowPass

_FIRST_EFFORT = 2 * len(ENCODER_NAMES)
_ROTOR_SPEED = topics.TOPICS["rotor"].layout.fields.index("velocity.rotor")
_UNKNOWN = (UNKNOWN_VARIANCE,) * 6


@dataclass(frozen=True)
class DifferentiatorParameters:
    """Bandwidths of the filters; their delays are 1.41/omega (velocity, rates) and about 1/omega - 5 ms."""

    velocity_bandwidth: float = quantity(
        40.0, "rad/s", "D", "differentiator of the position: 35 ms late, 0.04 m/s per count", 5.0, 400.0
    )
    rate_bandwidth: float = quantity(
        100.0, "rad/s", "D", "differentiator of the Euler angles: 14 ms late, 8 deg/s per count", 5.0, 400.0
    )
    rotor_bandwidth: float = quantity(
        100.0, "rad/s", "D", "low-pass of the rotor speed: 6 ms late", 5.0, 1000.0
    )


class DifferentiatingNavigator:
    """Encoders and rotor speed in, odometry and filtered rotor speed out.

    While an encoder is not indexed nothing is known: pose and twist are zero with UNKNOWN_VARIANCE. Arm
    angles that fit no position leave the state as it was, with UNKNOWN_VARIANCE, and are counted. After lost
    or rejected samples the filters go on from the new pose with the old rates.

    Args:
        parameters: bandwidths.
        geometry: of the rig.

    Attributes:
        rejected: encoder samples whose arm angles fit no position.
        gaps: times at which filters had to skip lost or rejected samples.
    """

    name = topics.NAVIGATION
    inputs: tuple[str, ...] = ("encoders", "rotor")
    outputs: tuple[str, ...] = ("odometry", "rotor_state")

    def __init__(self, parameters: DifferentiatorParameters, geometry: RigGeometry) -> None:
        self.rejected = 0
        self.gaps = 0
        self._geometry = geometry
        velocity, rate = parameters.velocity_bandwidth, parameters.rate_bandwidth
        self._filters = [Differentiator(velocity, SENSOR_PERIOD) for _ in range(3)]
        self._filters += [Differentiator(rate, SENSOR_PERIOD) for _ in range(3)]
        # (rate deviation / angle deviation)^2: a step is sqrt(12) quantisation deviations
        self._velocity_factor = 12.0 * self._filters[0].quantisation_gain ** 2
        self._rate_variance = 12.0 * self._filters[3].quantisation_gain ** 2 * QUANTISATION_VARIANCE
        self._rotor = LowPass(parameters.rotor_bandwidth, CONTROL_PERIOD)
        self._join = StampJoin(self.inputs)
        self._last_good_ns: int | None = None
        self._state = NOWHERE
        self._angles: Vector3 = (0.0, 0.0, 0.0)

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Take in one message; at a control tick the odometry and rotor state of both inputs.

        Raises:
            ValueError: another topic, or a number that is not finite.
        """
        require_finite(topic, values)
        if topic == "rotor":
            ready = self._join.add(topic, stamp_ns, (self._rotor.step(values[_ROTOR_SPEED]),))
        else:
            if topic != "encoders":
                raise ValueError(f"topic {topic!r} is none of {self.inputs}")
            self._update(stamp_ns, values)
            if not is_control_tick(stamp_ns):
                return []
            ready = self._join.add(topic, stamp_ns, self._odometry())
        if ready is None:
            return []
        return [
            Message("odometry", stamp_ns, ready["encoders"]),
            Message("rotor_state", stamp_ns, (0.0, ready["rotor"][0], 0.0)),
        ]

    def _update(self, stamp_ns: int, values: Sequence[float]) -> None:
        """Bring state and filters to one encoder sample."""
        if min(values[_FIRST_EFFORT:]) < 0.5:
            for differentiator in self._filters:
                differentiator.reset()
            self._state, self._last_good_ns = NOWHERE, None
            return
        angles = (values[0], values[1], values[2])
        attitude = Euler(values[3], values[4], values[5])
        try:
            position = position_from_arms(angles, self._geometry)
        except ValueError:
            self.rejected += 1
            self._state = self._state._replace(known=False)
            return
        if self._last_good_ns is not None and stamp_ns - self._last_good_ns != SENSOR_PERIOD_NS:
            self.gaps += 1
            for differentiator, value in zip(self._filters, (*position, *attitude), strict=True):
                differentiator.resume(value)
            rates = [differentiator.rate for differentiator in self._filters]
        else:
            rates = [
                differentiator.step(value)
                for differentiator, value in zip(self._filters, (*position, *attitude), strict=True)
            ]
        self._last_good_ns = stamp_ns
        self._angles = angles
        north, east, down, yaw_rate, pitch_rate, roll_rate = rates
        velocity = rotate(transpose(matrix_from_euler(attitude)), (north, east, down))
        body_rates = rates_from_euler(attitude, yaw_rate, pitch_rate, roll_rate)
        self._state = VehicleState(position, attitude, velocity, body_rates)

    def _odometry(self) -> tuple[float, ...]:
        """Numbers of the odometry message of the present state."""
        state = self._state
        if not state.known:
            return odometry_values(state, _UNKNOWN, _UNKNOWN)
        jacobian = arm_jacobian(self._angles, state.position, self._geometry)
        variance = position_variance(jacobian, QUANTISATION_VARIANCE)
        factor = self._velocity_factor
        moving = _turned_variance(matrix_from_euler(state.attitude), variance)
        # the rig measures yaw, pitch and roll equally well, so near level the axes do not matter
        east, north, up = swap_earth(variance)
        pose = (east, north, -up, *(QUANTISATION_VARIANCE,) * 3)
        twist = (factor * moving[0], factor * moving[1], factor * moving[2], *(self._rate_variance,) * 3)
        return odometry_values(state, pose, twist)


def rates_from_euler(attitude: Euler, yaw_rate: float, pitch_rate: float, roll_rate: float) -> Vector3:
    """p, q, r in body FRD from the derivatives of the Euler angles [rad/s] (source eq. A.11)."""
    sin_phi, cos_phi = sin(attitude.phi), cos(attitude.phi)
    sin_theta, cos_theta = sin(attitude.theta), cos(attitude.theta)
    return (
        roll_rate - yaw_rate * sin_theta,
        pitch_rate * cos_phi + yaw_rate * cos_theta * sin_phi,
        -pitch_rate * sin_phi + yaw_rate * cos_theta * cos_phi,
    )


def _turned_variance(c_nb: Matrix3, variance: Vector3) -> Vector3:
    """Diagonal of C_nb' diag(variance) C_nb: earth variances seen along the body axes."""
    a, b, c = c_nb
    x, y, z = variance
    return (
        a[0] * a[0] * x + b[0] * b[0] * y + c[0] * c[0] * z,
        a[1] * a[1] * x + b[1] * b[1] * y + c[1] * c[1] * z,
        a[2] * a[2] * x + b[2] * b[2] * y + c[2] * c[2] * z,
    )
