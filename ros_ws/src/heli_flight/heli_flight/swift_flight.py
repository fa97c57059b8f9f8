"""A flight in this process without messages: the bench, the filter, the supervisor, compiled control.

The way of flying for campaigns. Everything that acts on the flight runs, with the sensors at 400 Hz: bench
with all its noise, Kalman filter with gates, supervisor with its limits, the three controllers. Left out is
what is only published: the attitude by the IMU alone, the IMU's monitor, serialized messages. Numbers are
those of `fly_in_process` bit for bit (`test_swift_flight.py`), so a flight of a campaign can be flown again
on the graph.

Only plans of one controller without faults and excitations fly like this (`is_swift`); `plain_flight`
flies all others.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.bench_memory import READING_SIZE
from heli_common import topics
from heli_common.compiled_messages import read_state
from heli_common.errors import SafetyStop
from heli_common.finite import require_finite
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.rig_geometry import RigGeometry
from heli_common.rotations import Euler
from heli_common.timing import CONTROL_PERIOD, CONTROL_PERIOD_NS, SENSOR_PERIOD_NS
from heli_common.vehicle_state import NOWHERE, UNKNOWN_VARIANCE, VehicleState
from heli_control.attitude_control import AttitudeController, AttitudeParameters
from heli_control.controller_file import ControllerFile
from heli_control.motor_control import SpeedGovernor
from heli_control.motor_controller_file import MotorControllerFile, load_motor_controller
from heli_control.position_control import PositionLaw, PositionParameters
from heli_flight.components import DEFAULTS, bench_simulator, supervisor
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Plan
from heli_flight.stages import Reference
from heli_flight.supervisor import POSITION_VARIANCES
from heli_flight.swift_control import Flag, SwiftControl
from heli_navigation.differentiator import LowPass
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.inertial_navigation import InertialNavigation
from heli_navigation.navigator import NavigationParameters

Array = NDArray[np.float64]

_SAMPLES = CONTROL_PERIOD_NS // SENSOR_PERIOD_NS
_HALF = _SAMPLES // 2
_FIRST, _SECOND, _THIRD = POSITION_VARIANCES
_KNOWN, _DRIVEN = int(Flag.known), int(Flag.driven)
_FLAGS = {
    state: int(Flag.controlled) * state.controlled
    + int(Flag.ended) * state.ended
    + _DRIVEN * (state is not FlightState.IDLE and not state.ended)
    for state in FlightState
}
_NOWHERE_DEVIATION = sqrt(UNKNOWN_VARIANCE)


@dataclass(eq=False)
class FlightLog:
    """What is kept of a flight, a row per control tick.

    Attributes:
        truth: (n, 6) north, east, down [m], yaw, pitch, roll [rad] as they were.
        reference: (n, 4) north, east, down [m], yaw [rad] asked for.
        command: (n, 5) servo command [rad] and control voltage [V].
        state: (n,) codes of the stages.
        rotor: (n, 2) reference and measured rotor speed [rad/s].
        reason: why the flight ended early, or an empty string.
        remarks: of the bench: where the model did not hold.
    """

    truth: Array
    reference: Array
    command: Array
    state: NDArray[np.int64]
    rotor: Array
    reason: str = ""
    remarks: dict[str, str] = field(default_factory=dict)

    @classmethod
    def blank(cls, rows: int) -> FlightLog:
        """Room for so many ticks."""
        return cls(
            np.zeros((rows, 6)),
            np.zeros((rows, 4)),
            np.zeros((rows, 5)),
            np.zeros(rows, dtype=np.int64),
            np.zeros((rows, 2)),
        )

    def grown(self, rows: int) -> FlightLog:
        """The same with room for so many ticks; fewer than before cut it."""
        larger = FlightLog.blank(rows)
        kept = min(rows, len(self.state))
        for name in ("truth", "reference", "command", "state", "rotor"):
            getattr(larger, name)[:kept] = getattr(self, name)[:kept]
        larger.reason, larger.remarks = self.reason, self.remarks
        return larger


def is_swift(plan: Plan) -> bool:
    """Whether a plan can be flown by `SwiftFlight`."""
    return len(plan.controllers) == 1 and not plan.faults and not plan.excitations


class SwiftFlight:
    """One flight of a plan with one controller and neither faults nor excitations.

    Args:
        plan: see `is_swift`.
        seed: of every random number.
        controller: that flies.
        values: parameters of the nodes.
        motor: controller of the motor; the shipped one without.

    Raises:
        ValueError: the plan needs more than this.
    """

    def __init__(
        self,
        plan: Plan,
        seed: int,
        controller: ControllerFile,
        values: NodeValues = DEFAULTS,
        motor: MotorControllerFile | None = None,
    ) -> None:
        if not is_swift(plan):
            raise ValueError(f"plan {plan.name} has faults, excitations or several controllers")
        self.leader = supervisor(plan, values)
        self.bench = bench_simulator(seed, values, plan)
        self._filter = InertialNavigation(
            values.build(topics.NAVIGATION, FilterParameters, "filter."),
            values.build(topics.NAVIGATION, RigGeometry, "rig."),
        )
        bandwidth = values.build(topics.NAVIGATION, NavigationParameters).rotor_bandwidth
        self._rotor = LowPass(bandwidth, CONTROL_PERIOD)
        self._control = SwiftControl(
            PositionLaw(values.build(topics.POSITION_CONTROLLER, PositionParameters)),
            AttitudeController(controller, values.build(topics.ATTITUDE_CONTROLLER, AttitudeParameters)),
            controller,
            SpeedGovernor((motor or load_motor_controller("motor")).parameters),
        )
        self._vehicle: Array = np.zeros(12)
        self._samples: Array = np.empty((_SAMPLES, READING_SIZE))
        self._told: tuple[FlightState, float] | None = None
        self._expected = round(plan.duration / CONTROL_PERIOD) + 1

    def fly(self) -> FlightLog:
        """Fly to the end."""
        log, tick = FlightLog.blank(self._expected), 0
        reason = ""
        try:
            self.bench.tick()
            self._filter.run(self.bench.bench.reading[None])
            while True:
                if tick == len(log.state):
                    log = log.grown(2 * tick)
                self._control_tick(log, tick)
                tick += 1
                if self.bench.ended_at is not None:
                    break
                self._samples[:_HALF] = self.bench.run(_HALF)
                self._samples[_HALF:] = self.bench.run(_HALF)
                self._filter.run(self._samples)
            if self.leader.state is FlightState.FAULT:
                reason = self.leader.reason
        except (SafetyStop, ValueError) as error:
            reason = str(error)
        log = log.grown(tick)
        log.reason = reason
        log.remarks = {name: said for name, said in self.bench.remarks().items() if name.startswith("regime")}
        return log

    def _control_tick(self, log: FlightLog, tick: int) -> None:
        """Supervisor and controllers act on the latest sample."""
        bench, stamp_ns = self.bench, self.bench.stamp_ns
        vehicle, deviation = self._seen()
        rotor_speed = self._rotor.step(bench.bench.rotor_reading())
        wanted = self.leader.act(stamp_ns, vehicle, rotor_speed, deviation)
        stage = wanted.state
        command = self._command(wanted, stage, vehicle.known, rotor_speed)
        north, east, down = wanted.position
        log.truth[tick] = bench.bench.pose
        log.reference[tick] = north, east, down, wanted.heading
        log.command[tick], log.state[tick] = command, stage
        log.rotor[tick] = wanted.rotor_speed, rotor_speed
        *servo, voltage = command.tolist()
        bench.receive("servo_command", stamp_ns, servo)
        bench.receive("motor_command", stamp_ns, (0.0, 0.0, voltage))
        told = (stage, wanted.wind)
        if told != self._told:  # the bench holds what it was told last
            self._told = told
            bench.receive("flight_state", stamp_ns, flight_state_values(stage, wanted.rotor_speed, wanted.wind))

    def _seen(self) -> tuple[VehicleState, float]:
        """What the navigation knows: the vehicle, and the largest deviation of its position [m]."""
        if not self._filter.known:
            return NOWHERE, _NOWHERE_DEVIATION
        values = self._filter.odometry
        if not read_state(values, self._vehicle):
            require_finite("odometry", values.tolist())
        x, y, z, psi, theta, phi, u, v, w, p, q, r = self._vehicle.tolist()
        variance = max(values[_FIRST], values[_SECOND], values[_THIRD])
        known = bool(values[_FIRST] < 0.5 * UNKNOWN_VARIANCE)
        return VehicleState((x, y, z), Euler(psi, theta, phi), (u, v, w), (p, q, r), known), sqrt(variance)

    def _command(self, wanted: Reference, stage: FlightState, known: bool, rotor_speed: float) -> Array:
        """(5,) servo command [rad] and control voltage [V]."""
        flags = _FLAGS[stage] | (_KNOWN if known else 0)
        if wanted.rotor_speed <= 0.0:
            flags &= ~_DRIVEN
        rotor = (wanted.rotor_speed, rotor_speed)
        if not self._control.step(self._vehicle, (*wanted.position, wanted.heading), rotor, flags):
            require_finite("servo_command", self._control.command.tolist())
        return self._control.command
