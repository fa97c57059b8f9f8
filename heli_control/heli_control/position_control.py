"""Position controller: PI per axis in heading coordinates, to velocity and yaw-rate references (spec 3.2).

    reference = K_p (e + 1/T_i integral of e) + feed-forward          (source sec. 3.2.4, Table 3.2)

x points forward horizontally, y to the right, z down. The integral part is limited and resettable, and
stands still while its error would drive a limited output further. It takes in the distance from the expected
response (`reference_model`), not from the reference, so that a step does not wind it up (D). The vertical
axis follows that response altogether, with its rate as feed-forward: take-off and landing are ramps (D).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin

from heli_common import topics
from heli_common.component import Message, StampJoin
from heli_common.finite import require_finite
from heli_common.quantities import quantity
from heli_common.rotations import Vector3
from heli_common.timing import CONTROL_PERIOD
from heli_common.vehicle_state import (
    VehicleState,
    pose_from_values,
    state_from_odometry,
    twist_from_values,
    twist_values,
)
from heli_control.received import flight_state
from heli_control.reference_model import ReferenceModel

VelocityReference = tuple[float, float, float, float]
"""Velocities forward, right, down in heading axes [m/s] and yaw rate [rad/s]."""

Place = tuple[float, float, float, float]
"""North, east, down [m] and yaw [rad]."""

NO_VELOCITY: VelocityReference = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class PositionParameters:
    """Gains, times and limits of the four axes."""

    gain_x: float = quantity(2.0, "1/s", "T", "gain K_p forward", 0.0, 10.0)
    gain_y: float = quantity(2.0, "1/s", "T", "gain K_p to the right", 0.0, 10.0)
    gain_z: float = quantity(0.7, "1/s", "T", "gain K_p down", 0.0, 10.0)
    gain_psi: float = quantity(2.5, "1/s", "T", "gain K_p of the heading", 0.0, 10.0)
    time_x: float = quantity(5.0, "s", "T", "integral time T_i forward", 0.1, 1e6)
    time_y: float = quantity(5.0, "s", "T", "integral time T_i to the right", 0.1, 1e6)
    time_z: float = quantity(15.0, "s", "T", "integral time T_i down", 0.1, 1e6)
    time_psi: float = quantity(5.0, "s", "T", "integral time T_i of the heading", 0.1, 1e6)
    integral_x: float = quantity(0.3, "m/s", "D", "largest integral part forward", 0.0, 2.0)
    integral_y: float = quantity(0.3, "m/s", "D", "largest integral part to the right", 0.0, 2.0)
    integral_z: float = quantity(0.5, "m/s", "D", "largest integral part down", 0.0, 2.0)
    integral_psi: float = quantity(0.5, "rad/s", "D", "largest integral part of the heading", 0.0, 3.0)
    response_x: float = quantity(1.8, "rad/s", "D", "expected response forward", 0.1, 100.0)
    response_y: float = quantity(1.8, "rad/s", "D", "expected response to the right", 0.1, 100.0)
    response_z: float = quantity(3.0, "rad/s", "D", "expected response down", 0.1, 100.0)
    response_psi: float = quantity(3.0, "rad/s", "D", "expected response of the heading", 0.1, 100.0)
    limit_x: float = quantity(0.8, "m/s", "D", "largest velocity reference forward", 0.0, 3.0)
    limit_y: float = quantity(0.8, "m/s", "D", "largest velocity reference to the right", 0.0, 3.0)
    limit_z: float = quantity(0.5, "m/s", "D", "largest velocity reference down", 0.0, 3.0)
    limit_psi: float = quantity(1.0, "rad/s", "D", "largest yaw-rate reference", 0.0, 3.0)


def proportional_integral(
    integral: float, errors: Vector3, gain: float, growth: float, integral_limit: float, limit: float
) -> tuple[float, float]:
    """Output of one axis and its integral part for the next; compiled code may call it.

    Args:
        integral: integral part [unit of the output].
        errors: reference minus measurement, expected response minus measurement, feed-forward.
        gain: K_p.
        growth: K_p T / T_i.
        integral_limit: of the integral part [unit of the output].
        limit: of the output [unit of the output].
    """
    error, unexpected, feed_forward = errors
    asked = gain * error + integral + feed_forward
    output = min(max(asked, -limit), limit)
    if (asked - output) * unexpected <= 0.0:
        grown = integral + growth * unexpected
        integral = min(max(grown, -integral_limit), integral_limit)
    return output, integral


def heading_errors(
    place: Place, references: Place, expected: Place, down_rate: float, feed_forward: VelocityReference
) -> tuple[Vector3, Vector3, Vector3, Vector3]:
    """What each axis goes by, in heading axes: errors as `proportional_integral` takes them.

    The heading error is not wrapped: between the yaw stops at +-170 deg the way round the back is closed.

    Args:
        place: north, east, down [m] and yaw [rad] measured.
        references: the same, wanted.
        expected: the same, of the expected response.
        down_rate: of the expected response [m/s].
        feed_forward: added in heading axes.
    """
    north, east = references[0] - place[0], references[1] - place[1]
    late_north, late_east = expected[0] - place[0], expected[1] - place[1]
    down, turn = expected[2] - place[2], expected[3] - place[3]
    cosine, sine = cos(place[3]), sin(place[3])
    return (
        (cosine * north + sine * east, cosine * late_north + sine * late_east, feed_forward[0]),
        (cosine * east - sine * north, cosine * late_east - sine * late_north, feed_forward[1]),
        (down, down, down_rate + feed_forward[2]),
        (references[3] - place[3], turn, feed_forward[3]),
    )


class ProportionalIntegral:
    """One axis.

    Args:
        gain: K_p [1/s].
        time: T_i [s].
        integral_limit: of the integral part [unit of the output].
        limit: of the output [unit of the output].

    Attributes:
        gain: K_p [1/s].
        growth: K_p T / T_i, of the integral part per error and sample [1/s].
        integral_limit: as given.
        limit: as given.
        integral: integral part of the next output [unit of the output].
    """

    def __init__(self, gain: float, time: float, integral_limit: float, limit: float) -> None:
        self.gain = gain
        self.growth = gain * CONTROL_PERIOD / time
        self.integral_limit = integral_limit
        self.limit = limit
        self.integral = 0.0

    def step(self, error: float, unexpected: float, feed_forward: float = 0.0) -> float:
        """Output of this sample; the integral part is advanced afterwards.

        Args:
            error: reference minus measurement [m or rad].
            unexpected: expected response minus measurement, for the integral part [m or rad].
            feed_forward: added to the output before it is limited [m/s or rad/s].
        """
        output, self.integral = proportional_integral(
            self.integral,
            (error, unexpected, feed_forward),
            self.gain,
            self.growth,
            self.integral_limit,
            self.limit,
        )
        return output

    def reset(self) -> None:
        """Forget the integral."""
        self.integral = 0.0


class PositionLaw:
    """Four axes in heading coordinates.

    Args:
        parameters: gains, times and limits.

    Attributes:
        axes: forward, right, down, heading.
        models: expected response north, east, down, of the heading.
    """

    def __init__(self, parameters: PositionParameters) -> None:
        p = parameters
        self.axes = (
            ProportionalIntegral(p.gain_x, p.time_x, p.integral_x, p.limit_x),
            ProportionalIntegral(p.gain_y, p.time_y, p.integral_y, p.limit_y),
            ProportionalIntegral(p.gain_z, p.time_z, p.integral_z, p.limit_z),
            ProportionalIntegral(p.gain_psi, p.time_psi, p.integral_psi, p.limit_psi),
        )
        frequencies = (p.response_x, p.response_y, p.response_z, p.response_psi)
        self.models = tuple(ReferenceModel(frequency) for frequency in frequencies)
        self._engaged = False

    def step(
        self,
        state: VehicleState,
        position: Vector3,
        heading: float,
        feed_forward: VelocityReference = NO_VELOCITY,
    ) -> VelocityReference:
        """Velocity reference of this sample.

        Args:
            state: of the helicopter.
            position: reference in earth NED [m].
            heading: reference yaw [rad].
            feed_forward: added in heading axes.
        """
        place = (*state.position, state.attitude.psi)
        references = (*position, heading)
        if not self._engaged:
            self._engaged = True
            for model, value in zip(self.models, place, strict=True):
                model.reset(value)
        for model, reference in zip(self.models, references, strict=True):
            model.step(reference)
        north, east, down, turn = self.models
        expected = (north.value, east.value, down.value, turn.value)
        errors = heading_errors(place, references, expected, down.rate, feed_forward)
        x, y, z, psi = (axis.step(*each) for axis, each in zip(self.axes, errors, strict=True))
        return x, y, z, psi

    def reset(self) -> None:
        """Forget all integrals; the next step expects nothing but what it sees."""
        self._engaged = False
        for axis in self.axes:
            axis.reset()


class PositionController:
    """Component: odometry, reference and flight state in, velocity reference out.

    While the helicopter is not controlled or its pose is not known, the integrals are reset and zeros go out.
    An excitation of the reference is added as feed-forward, inside the limits.

    Args:
        parameters: gains, times and limits.
        excited: whether an identification runs that may excite the reference.
    """

    name = topics.POSITION_CONTROLLER
    inputs: tuple[str, ...] = ("odometry", "reference", "flight_state")
    waking: tuple[str, ...] = ("reference",)
    outputs: tuple[str, ...] = ("velocity_reference",)

    def __init__(self, parameters: PositionParameters, excited: bool = False) -> None:
        self._law = PositionLaw(parameters)
        optional = ("reference_excitation",) if excited else ()
        self._join = StampJoin(self.inputs, optional)
        self.inputs, self.waking = (*self.inputs, *optional), (*self.waking, *optional)

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Take in one message; when all inputs of a stamp are there, the velocity reference.

        Raises:
            ValueError: another topic, a number that is not finite, or no such flight state.
        """
        require_finite(topic, values)
        ready = self._join.add(topic, stamp_ns, values)
        if ready is None:
            return []
        state = state_from_odometry(ready["odometry"])
        stage, _ = flight_state(ready["flight_state"])
        if stage.controlled and state.known:
            position, attitude = pose_from_values(ready["reference"])
            excitation = NO_VELOCITY
            if "reference_excitation" in ready:
                velocity, turn = twist_from_values(ready["reference_excitation"])
                excitation = (*velocity, turn[2])
            forward, right, down, yaw_rate = self._law.step(state, position, attitude.psi, excitation)
        else:
            self._law.reset()
            forward, right, down, yaw_rate = NO_VELOCITY
        reference = twist_values((forward, right, down), (0.0, 0.0, yaw_rate))
        require_finite("velocity_reference", reference)
        return [Message("velocity_reference", self._join.stamp_ns, reference)]
