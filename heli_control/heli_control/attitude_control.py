"""Attitude controller: velocity references and the measured state to servo commands (spec 3, 3.3).

    command = idle + authority (limited(trim + K (state - trim, references)) - idle)

K is whatever linear controller the file holds. Authority rises and falls linearly, so the rotor takes the
load up and gives it back without a jump. K is told the command that went out, limited and faded, so that
nothing in it winds up on the stop or at a limit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians

from heli_common import topics
from heli_common.component import Message, StampJoin
from heli_common.finite import require_finite
from heli_common.quantities import quantity
from heli_common.rotations import Euler, Vector3, matrix_from_euler, rotate, transpose
from heli_common.timing import CONTROL_PERIOD
from heli_common.vehicle_state import VehicleState, state_from_odometry, twist_from_values
from heli_control.command_limits import CommandLimits
from heli_control.controller_file import ControllerFile
from heli_control.flight_law import FlightLaw
from heli_control.law_exchange import LawExchange
from heli_control.received import flight_state, planned_controller


@dataclass(frozen=True)
class AttitudeParameters:
    """Engagement, idle command and limits of the servo commands (spec 2.5)."""

    engage_time: float = quantity(2.0, "s", "D", "from idle to full authority", 0.01, 60.0)
    release_time: float = quantity(1.0, "s", "D", "from full authority to idle", 0.01, 60.0)
    exchange_time: float = quantity(0.5, "s", "D", "from one controller to the next in flight", 0.01, 60.0)
    idle_B_1s: float = quantity(0.0, "rad", "D", "idle longitudinal cyclic", -0.2, 0.2)
    idle_A_1s: float = quantity(0.0, "rad", "D", "idle lateral cyclic", -0.2, 0.2)
    idle_theta_0: float = quantity(radians(1.0), "rad", "D", "idle collective", -0.1, 0.3)
    idle_theta_t: float = quantity(
        radians(4.0), "rad", "D", "idle tail: balances the idle rotor's torque", -0.1, 0.5
    )
    cyclic_limit: float = quantity(radians(10.0), "rad", "D", "largest cyclic either way", 0.0, 0.3)
    collective_minimum: float = quantity(radians(-4.0), "rad", "D", "lowest collective", -0.3, 0.3)
    collective_maximum: float = quantity(radians(16.0), "rad", "D", "highest collective", -0.3, 0.5)
    tail_minimum: float = quantity(radians(-5.0), "rad", "D", "lowest tail collective", -0.5, 0.5)
    tail_maximum: float = quantity(radians(25.0), "rad", "D", "highest tail collective", -0.5, 0.6)
    collective_neutral: float = quantity(
        radians(6.0), "rad", "D", "collective at which the swash-plate servos stand in the middle", -0.5, 0.5
    )
    shaft_limit: float = quantity(
        radians(60.0), "rad", "D", "shaft angle of a swash-plate servo at its end", 0.1, 3.0
    )
    plate_lever: float = quantity(6.0, "-", "D", "shaft angle per blade angle, swash plate", 0.1, 100.0)


def next_authority(authority: float, ended: bool, steered: bool, rise: float, fall: float) -> float:
    """Authority of this sample, 0 .. 1; compiled code may call it, as the next two.

    Args:
        authority: of the sample before.
        ended: whether the flight is over, or in a fault.
        steered: whether the helicopter is controlled and its pose known.
        rise: per sample.
        fall: per sample.
    """
    if ended:
        return 0.0
    return min(1.0, authority + rise) if steered else max(0.0, authority - fall)


def faded(idle: float, asked: float, authority: float) -> float:
    """One command [rad] between idle and what the law asks for."""
    return idle + authority * (asked - idle)


def body_from_level(velocity: Vector3, theta: float, phi: float) -> Vector3:
    """A velocity in body FRD from one in heading axes [m/s].

    Args:
        velocity: forward, right, down in heading axes [m/s].
        theta: pitch [rad].
        phi: roll [rad].
    """
    return rotate(transpose(matrix_from_euler(Euler(0.0, theta, phi))), velocity)


class AttitudeController:
    """Component: odometry, velocity reference and flight state in, servo command out.

    Authority rises while the helicopter is controlled and its pose known, and falls otherwise; in a fault and
    after the flight it is zero at once. While the pose is not known the law keeps its last command.

    Which controller flies, the plan says by number in `flight_state`; `replace` flies any other until the
    plan changes its own.

    Args:
        controller: the law to fly first, number 0 of the plan.
        parameters: engagement, idle command and limits.
        later: further controllers of the plan, number 1 and so on.

    Attributes:
        authority: 0 idle .. 1 controlled.
        rise: of the authority per sample.
        fall: of the authority per sample.
        idle: command B_1s A_1s theta_0 theta_t without authority [rad].
        limits: of the commands.
        exchanged: stamp [ns] of the last change of controller and name of the one that came; None before.

    Raises:
        InputError: the operating point of a controller lies outside the limits.
    """

    name = topics.ATTITUDE_CONTROLLER
    inputs: tuple[str, ...] = ("odometry", "velocity_reference", "flight_state")
    waking: tuple[str, ...] = ("velocity_reference",)
    outputs: tuple[str, ...] = ("servo_command",)

    def __init__(
        self,
        controller: ControllerFile,
        parameters: AttitudeParameters,
        later: Sequence[ControllerFile] = (),
    ) -> None:
        p = parameters
        self.authority = 0.0
        self.rise = CONTROL_PERIOD / p.engage_time
        self.fall = CONTROL_PERIOD / p.release_time
        self.idle = (p.idle_B_1s, p.idle_A_1s, p.idle_theta_0, p.idle_theta_t)
        self.limits = CommandLimits(
            (-p.cyclic_limit, -p.cyclic_limit, p.collective_minimum, p.tail_minimum),
            (p.cyclic_limit, p.cyclic_limit, p.collective_maximum, p.tail_maximum),
            p.collective_neutral,
            p.shaft_limit / p.plate_lever,
        )
        self._plan = (controller, *later)
        law, *_ = [self._checked(file) for file in self._plan]
        self._planned = 0
        self._next: FlightLaw | None = None
        self.exchanged: tuple[int, str] | None = None
        self._laws = LawExchange(law, CONTROL_PERIOD / p.exchange_time, self.limits.within)
        self._asked = list(law.trim)
        self._sent: Sequence[float] = ()
        self._join = StampJoin(self.inputs)

    def replace(self, controller: ControllerFile) -> None:
        """Fly another controller from the next sample on; in flight the old one fades into it.

        Raises:
            InputError: its operating point lies outside the limits; the old one goes on.
        """
        self._next = self._checked(controller)

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Take in one message; when all inputs of a stamp are there, the servo command.

        Raises:
            ValueError: another topic, a number that is not finite, or no such flight state.
        """
        self.update()
        require_finite(topic, values)
        ready = self._join.add(topic, stamp_ns, values)
        if ready is None:
            return []
        state = state_from_odometry(ready["odometry"])
        stage, _ = flight_state(ready["flight_state"])
        self._exchange(planned_controller(ready["flight_state"], len(self._plan)), stamp_ns)
        steered = stage.controlled and state.known
        self.authority = next_authority(self.authority, stage.ended, steered, self.rise, self.fall)
        if self.authority == 0.0:
            self._laws.reset()
            self._asked = list(self._laws.law.trim)
            command = list(self.idle)
        else:
            if state.known:
                linear, angular = twist_from_values(ready["velocity_reference"])
                self._asked = self._step(state, linear, angular[2])
            command = [
                faded(idle, asked, self.authority) for idle, asked in zip(self.idle, self._asked, strict=True)
            ]
            if state.known:
                self._sent = command
        message = (*command, *(0.0,) * 8)
        require_finite("servo_command", message)
        return [Message("servo_command", stamp_ns, message)]

    def update(self) -> list[Message]:
        """Let the states of the laws go on, once the command is out."""
        if self._sent:
            self._laws.follow(self._sent)
            self._sent = ()
        return []

    def _exchange(self, planned: int, stamp_ns: int) -> None:
        """Begin to fly what was asked for since the last sample."""
        if planned != self._planned:
            self._planned = planned
            self._next = self._checked(self._plan[planned])
        if self._next is None:
            return
        self._laws.replace(self._next)
        if self.authority == 0.0:
            self._laws.reset()
        self.exchanged = (stamp_ns, self._next.name)
        self._next = None

    def _step(self, state: VehicleState, heading_velocity: Vector3, yaw_rate: float) -> list[float]:
        """The law's command within the limits; references come in heading axes."""
        velocity = body_from_level(heading_velocity, state.attitude.theta, state.attitude.phi)
        return self._laws.step(state, velocity, yaw_rate)

    def _checked(self, controller: ControllerFile) -> FlightLaw:
        law = FlightLaw(controller)
        self.limits.require(law.trim, f"{law.name}: operating_point")
        return law
