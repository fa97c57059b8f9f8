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

from collections.abc import Sequence
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.bench_memory import READING_SIZE
from heli_bench_sim.simulator import BenchSimulator
from heli_common import topics
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
from heli_flight.compiled_control import Flag
from heli_flight.components import DEFAULTS, bench_simulator, controllers, identifier, supervisor
from heli_flight.flight_log import LOGGED, FlightLog, log_of_values
from heli_flight.in_process import InProcessGraph, Sink
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Plan
from heli_flight.stages import Reference
from heli_flight.swift_control import SwiftControl
from heli_navigation.differentiator import LowPass
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.inertial_navigation import InertialNavigation
from heli_navigation.navigator import NavigationParameters

Array = NDArray[np.float64]

_SAMPLES = CONTROL_PERIOD_NS // SENSOR_PERIOD_NS
_HALF = _SAMPLES // 2
_KNOWN, _DRIVEN = int(Flag.known), int(Flag.driven)
_FLAGS = {
    state: int(Flag.controlled) * state.controlled
    + int(Flag.ended) * state.ended
    + _DRIVEN * (state is not FlightState.IDLE and not state.ended)
    for state in FlightState
}
_NOWHERE_DEVIATION = sqrt(UNKNOWN_VARIANCE)


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
        self._vehicle: Array = np.zeros(15)
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
                    log = log.resized(2 * tick)
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
        log = log.resized(tick)
        log.reason = reason
        log.remarks = regime(self.bench)
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
            bench.receive(
                "flight_state", stamp_ns, flight_state_values(stage, wanted.rotor_speed, wanted.wind)
            )

    def _seen(self) -> tuple[VehicleState, float]:
        """What the navigation knows: the vehicle, and the largest deviation of its position [m]."""
        if not self._filter.known:
            return NOWHERE, _NOWHERE_DEVIATION
        if not self._filter.see(self._vehicle):
            require_finite("odometry", self._filter.odometry.tolist())
        x, y, z, psi, theta, phi, u, v, w, p, q, r, *variances = self._vehicle.tolist()
        known = variances[1] < 0.5 * UNKNOWN_VARIANCE  # east, the first in a message
        vehicle = VehicleState((x, y, z), Euler(psi, theta, phi), (u, v, w), (p, q, r), known)
        return vehicle, sqrt(max(variances))

    def _command(self, wanted: Reference, stage: FlightState, known: bool, rotor_speed: float) -> Array:
        """(5,) servo command [rad] and control voltage [V]."""
        flags = _FLAGS[stage] | (_KNOWN if known else 0)
        if wanted.rotor_speed <= 0.0:
            flags &= ~_DRIVEN
        rotor = (wanted.rotor_speed, rotor_speed)
        if not self._control.step(self._vehicle, (*wanted.position, wanted.heading), rotor, flags):
            require_finite("servo_command", self._control.command.tolist())
        return self._control.command


def fly_components(
    plan: Plan,
    seed: int,
    controller: ControllerFile,
    values: NodeValues,
    motor: MotorControllerFile | None,
    later: Sequence[ControllerFile],
    *,
    sink: Sink,
) -> tuple[BenchSimulator, str]:
    """Fly any plan with the components to its end; the bench, and why the flight was stopped, if it was.

    Args:
        plan: what to fly.
        seed: of every random number.
        controller: that flies first.
        values: parameters of the nodes.
        motor: of the motor; the shipped one without.
        later: controllers that phases of the plan change to.
        sink: sees every message.
    """
    excited = bool(plan.excitations)
    bench, leader = bench_simulator(seed, values, plan, excited), supervisor(plan, values)
    parts = [leader, *controllers(controller, values, later, motor, excited)]
    if excited:
        parts.append(identifier(plan, values))
    graph = InProcessGraph(bench, parts, sink)
    try:
        while bench.ended_at is None:
            graph.advance()
    except (SafetyStop, ValueError) as error:
        return bench, str(error) or type(error).__name__
    return bench, leader.reason if leader.state is FlightState.FAULT else ""


def plain_flight(
    plan: Plan,
    seed: int,
    controller: ControllerFile,
    values: NodeValues = DEFAULTS,
    motor: MotorControllerFile | None = None,
    later: Sequence[ControllerFile] = (),
) -> FlightLog:
    """Fly any plan with the components, as `fly_in_process` does, without a bag; arguments as there."""
    sent: dict[str, list[tuple[float, ...]]] = {name: [] for name in LOGGED}

    def record(topic: str, _stamp_ns: int, data: bytes) -> None:
        if topic in sent:
            sent[topic].append(topics.TOPICS[topic].layout.unpack(data)[1])

    bench, reason = fly_components(plan, seed, controller, values, motor, later, sink=record)
    widths = {name: len(topics.TOPICS[name].layout.fields) for name in LOGGED}
    log = log_of_values({name: np.array(rows).reshape(-1, widths[name]) for name, rows in sent.items()})
    log.reason, log.remarks = reason, regime(bench)
    return log


def regime(bench: BenchSimulator) -> dict[str, str]:
    """Where the model did not hold."""
    return {name: said for name, said in bench.remarks().items() if name.startswith("regime")}
