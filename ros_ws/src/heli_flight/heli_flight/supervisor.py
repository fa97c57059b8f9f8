"""The supervisor: takes the bench through a plan or through commands, and watches that it stays safe."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

from heli_common.component import Message, StampJoin
from heli_common.errors import InputError, SafetyStop
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.quantities import check_number
from heli_common.rotations import Euler
from heli_common.topics import SUPERVISOR, TOPICS
from heli_common.vehicle_state import VehicleState, pose_values, state_from_odometry
from heli_flight.plan import Home, Hover, Land, Phase, Plan, RunDown, RunUp, TakeOff
from heli_flight.plan_phases import WIND
from heli_flight.stages import FlightLimits, Observation, Reference, Stage, run_phase

COMMANDS: dict[str, tuple[Phase, ...]] = {
    "home": (Home(),),
    "arm": (RunUp(),),
    "take_off": (TakeOff(), Hover(duration=math.inf)),
    "land": (Land(), RunDown()),
}
"""What each service makes the bench do, beside `stop`."""


_POSITION_VARIANCES = tuple(
    TOPICS["odometry"].layout.fields.index(f"pose_covariance[{place}]") for place in (0, 7, 14)
)


class Supervisor:
    """Component: flight state, rotor speed reference and pose reference at every control tick.

    Args:
        limits: of the bench.
        plan: flown from time 0 on and ended with `stopped`; without one, commands are awaited.

    Attributes:
        reason: why the flight ended in a fault, or an empty string.
        phase: number of the phase being flown, from 1; 0 before the first.
    """

    name = SUPERVISOR
    inputs: tuple[str, ...] = ("rotor_state", "odometry")
    waking: tuple[str, ...] = ("odometry",)
    outputs: tuple[str, ...] = ("flight_state", "reference")

    def __init__(self, limits: FlightLimits, plan: Plan | None = None) -> None:
        self.plan = plan
        self.reason = ""
        self.phase = 0
        self._limits = limits
        self._queue: deque[Phase] = deque(plan.phases if plan else ())
        self._stage: Stage | None = None
        self._reference = Reference(position=(0.0, 0.0, limits.rest_depth))
        self._observation: Observation | None = None
        self._join = StampJoin(self.inputs)
        self._stop_requested = False
        self._deviation = 0.0
        self._landing_for = ""

    @property
    def state(self) -> FlightState:
        """The stage of the flight."""
        return self._reference.state

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Act on odometry and rotor speed of one control tick."""
        joined = self._join.add(topic, stamp_ns, values)
        if joined is None:
            return []
        vehicle = state_from_odometry(joined["odometry"])
        variance = max(joined["odometry"][place] for place in _POSITION_VARIANCES)
        self.act(stamp_ns, vehicle, joined["rotor_state"][1], math.sqrt(variance))
        return self._messages(stamp_ns)

    def act(self, stamp_ns: int, vehicle: VehicleState, rotor_speed: float, deviation: float) -> Reference:
        """What is asked for at a control tick; the same object every time.

        Args:
            stamp_ns: of the tick [ns].
            vehicle: as the navigation knows it.
            rotor_speed: measured [rad/s].
            deviation: largest standard deviation of the position [m].
        """
        self._observation = Observation(stamp_ns * 1e-9, vehicle, rotor_speed)
        self._deviation = deviation
        if not self.state.ended:
            try:
                self._watch(self._observation)
                self._advance()
            except SafetyStop as stop:
                self.reason = f"{stop} at {stamp_ns * 1e-9:.2f} s"
                self._reference.state = FlightState.FAULT
                self._reference.rotor_speed = self._reference.wind = 0.0
                self._reference.excitation = 0
        return self._reference

    def command(self, name: str) -> tuple[bool, str]:
        """A service call; acts at the next control tick.

        Returns:
            whether it was accepted, and why not.
        """
        if self.state.ended:
            return False, f"the flight is over ({self.state.word})"
        if name == "stop":
            self._stop_requested = True
            return True, "stopping"
        allowed = {
            "home": self.state is FlightState.IDLE,
            "arm": self.state is FlightState.IDLE and self._homed(),
            "take_off": self.state is FlightState.RUN_UP and self._stage is None,
            "land": self.state is FlightState.FLYING,
        }
        if name not in allowed:
            return False, f"unknown command {name!r}; known: {', '.join(allowed)}, stop"
        if self.plan is not None and name != "land":
            return False, f"plan {self.plan.name} is being flown; only land and stop are accepted"
        if not allowed[name]:
            return False, f"{name} is not possible while {self.state.word}" + self._hint(name)
        self._queue = deque(COMMANDS[name])
        self._stage = None
        return True, f"{name} begins"

    def set_wind(self, speed: float) -> None:
        """Command the wind generator; acts at the next control tick.

        Args:
            speed: of the air on its axis [m/s].

        Raises:
            InputError: a plan is being flown, or the speed is out of range.
        """
        if self.plan is not None:
            raise InputError(f"plan {self.plan.name} is being flown", allowed="its own wind_m_s", key="wind")
        self._reference.wind = check_number(speed, WIND, key="wind")

    def _homed(self) -> bool:
        return self._observation is not None and self._observation.vehicle.known

    def _hint(self, name: str) -> str:
        return ": home first" if name == "arm" and not self._homed() else ""

    def _see(self) -> Observation:
        if self._observation is None:
            raise RuntimeError("nothing has been observed yet")
        return self._observation

    def _watch(self, seen: Observation) -> None:
        if self._stop_requested:
            raise SafetyStop("stop requested")
        if not self.state.controlled:
            return
        vehicle = seen.vehicle
        if not vehicle.known:
            raise SafetyStop("position lost: the encoders are not indexed")
        limits = self._limits
        tilt = max(abs(vehicle.attitude.theta), abs(vehicle.attitude.phi))
        if tilt > limits.maximum_tilt:
            allowed = math.degrees(limits.maximum_tilt)
            raise SafetyStop(f"roll or pitch of {math.degrees(tilt):.1f} deg (limit {allowed:.1f} deg)")
        radius = math.hypot(vehicle.position[0], vehicle.position[1])
        if radius > limits.maximum_radius:
            raise SafetyStop(f"{radius:.2f} m from the axis (limit {limits.maximum_radius} m)")
        if self._deviation > limits.maximum_deviation:
            raise SafetyStop(f"position known to {1e3 * self._deviation:.0f} mm only")
        if self._deviation > limits.landing_deviation and self.state is FlightState.FLYING:
            self._landing_for = f"landed: position known to {1e3 * self._deviation:.0f} mm only"
            self._queue, self._stage = deque(COMMANDS["land"]), None
        if seen.rotor_speed < limits.minimum_rotor_fraction * limits.nominal_rotor_speed:
            raise SafetyStop(f"rotor speed {seen.rotor_speed:.1f} rad/s is too low to fly")

    def _advance(self) -> None:
        """Advance the phase being flown; when it ends, the next one begins at this same tick."""
        while True:
            if self._stage is None:
                if not self._queue:
                    if self.plan is not None or self.state is FlightState.RUN_DOWN:
                        self._finish()
                    return
                phase = self._queue.popleft()
                self.phase += 1
                if self.plan is not None and phase.controller is not None:
                    self._reference.controller = self.plan.controllers.index(phase.controller)
                self._stage = run_phase(phase, self._reference, self._see, self._limits)
            if next(self._stage, self) is not self:
                return
            self._stage = None

    def _finish(self) -> None:
        if self._landing_for:
            raise SafetyStop(self._landing_for)
        self._reference.rotor_speed = self._reference.wind = 0.0
        self._reference.state = FlightState.STOPPED

    def _messages(self, stamp_ns: int) -> list[Message]:
        reference = self._reference
        state = flight_state_values(
            reference.state,
            reference.rotor_speed,
            reference.wind,
            controller=reference.controller,
            excitation=reference.excitation,
        )
        pose = pose_values(reference.position, Euler(reference.heading, 0.0, 0.0))
        return [Message("flight_state", stamp_ns, state), Message("reference", stamp_ns, pose)]
