"""A flight in this process that leaves no bag: what calibration and reproduction need of it, in memory.

`fly_for_figures` is the one place where they fly: without messages where the plan allows it (`swift_flight`),
else by the components of `in_process`. Both give the same numbers (`test_unrecorded_flight.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import SafetyStop
from heli_common.flight_state import FlightState
from heli_common.rig_geometry import RigGeometry
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import TOPICS
from heli_control.controller_file import load_controller
from heli_flight.bag_reader import Bag
from heli_flight.components import DEFAULTS, bench_simulator, controllers, identifier, supervisor
from heli_flight.flight_record import Array, FlightRecord, Motion, Stage, Stamps, stages_of
from heli_flight.in_process import InProcessGraph
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Plan
from heli_flight.swift_flight import FlightLog, SwiftFlight, is_swift

KEPT = (
    "ground_truth",
    "flight_state",
    "reference",
    "servo_command",
    "actuator_state",
    "bench_condition",
    "excitation",
    "reference_excitation",
)
"""Topics that are kept of a flight by components."""

CONTACT = 0.005
"""How close to the end of travel counts as touching it [m]."""

_FURTHEST_YAW = math.radians(169.0)
_COMMANDS = 4


@dataclass(frozen=True, eq=False)
class FlownFlight:
    """A flight in arrays, a row per control tick; `heli_flight.metrics` takes it for a record.

    Attributes:
        truth: the motion as it was.
        reference: stamps [ns] and north, east, down [m], yaw [rad] asked for, shape (n, 4).
        command: B_1s, A_1s, theta_0, theta_t asked of the servos [rad], shape (n, 4).
        actuators: the same as they were [rad], shape (n, 4).
        fan: mean speed on the axis of the jet [m/s], shape (n,).
        state: codes of the stages, shape (n,).
        reason: why the flight ended early, or an empty string.
        record: its messages, of a flight by components.
    """

    truth: Motion
    reference: tuple[Stamps, Array]
    command: Array
    actuators: Array
    fan: Array
    state: NDArray[np.int64]
    reason: str
    record: FlightRecord | None = None

    @cached_property
    def stages(self) -> tuple[Stage, ...]:
        """The flight's stages one after the other."""
        return stages_of(self.truth.stamps, self.state.astype(np.float64))


def fly_for_figures(
    plan: Plan, controller: str, seed: int, values: NodeValues = DEFAULTS, kept: tuple[str, ...] = KEPT
) -> FlownFlight:
    """Fly a plan in this process.

    Args:
        plan: what to fly; its own seed and first controller do not count.
        controller: shipped controller or path, in place of the plan's first.
        seed: of every random number.
        values: parameters of the nodes.
        kept: topics of a flight by components, at least KEPT.

    Returns:
        the flight, whether it was flown to its end or stopped; then `reason` says why.

    Raises:
        InputError: no such controller.
    """
    plan = replace(plan, seed=seed, controller=controller)
    if is_swift(plan):
        return _swift(plan, values)
    return _by_components(plan, values, kept)


class _WatchedFlight(SwiftFlight):
    """A swift flight that also notes velocities, rates, actuators and fan."""

    def __init__(self, plan: Plan, values: NodeValues) -> None:
        super().__init__(plan, plan.seed, load_controller(plan.controller), values)
        self.noted: list[tuple[float, ...]] = []

    def _control_tick(self, log: FlightLog, tick: int) -> None:
        super()._control_tick(log, tick)
        bench = self.bench.bench
        self.noted.append((*bench.velocity, *bench.rates, *self.shafts(), bench.fan_speed))

    def shafts(self) -> tuple[float, ...]:
        """Blade angles B_1s, A_1s, theta_0, theta_t as they are [rad]."""
        return tuple(self.bench.bench.actuator_state().angles)


def _swift(plan: Plan, values: NodeValues) -> FlownFlight:
    flight = _WatchedFlight(plan, values)
    log = flight.fly()
    count = len(flight.noted)
    stamps = np.arange(count, dtype=np.int64) * CONTROL_PERIOD_NS
    noted = np.array(flight.noted, dtype=np.float64).reshape(count, 6 + _COMMANDS + 1)
    truth = Motion(
        stamps,
        log.truth[:count, :3],
        log.truth[:count, 3:],
        noted[:, :3],
        noted[:, 3:6],
        np.ones(count, dtype=np.bool_),
    )
    return FlownFlight(
        truth=truth,
        reference=(stamps, log.reference[:count]),
        command=log.command[:count, :_COMMANDS],
        actuators=noted[:, 6:-1],
        fan=noted[:, -1],
        state=log.state[:count],
        reason=log.reason,
    )


def _by_components(plan: Plan, values: NodeValues, kept: tuple[str, ...]) -> FlownFlight:
    first, *later = [load_controller(name) for name in plan.controllers]
    excited = bool(plan.excitations)
    bench, leader = bench_simulator(plan.seed, values, plan, excited), supervisor(plan, values)
    parts = [leader, *controllers(first, values, later, None, excited)]
    if excited:
        parts.append(identifier(plan, values))
    messages: dict[str, list[bytes]] = {topic: [] for topic in kept}

    def keep(topic: str, _stamp_ns: int, data: bytes) -> None:
        if topic in messages:
            messages[topic].append(data)

    graph, reason = InProcessGraph(bench, parts, keep), ""
    try:
        while bench.ended_at is None:
            graph.advance()
        if leader.state is FlightState.FAULT:
            reason = leader.reason
    except (SafetyStop, ValueError) as error:
        reason = str(error) or type(error).__name__
    types = {topic: TOPICS[topic].layout.ros_type for topic in kept}
    return _of_record(FlightRecord(Bag(Path(plan.name), types, {}, messages, {}, ())), reason)


def _of_record(record: FlightRecord, reason: str) -> FlownFlight:
    """The stamps that every topic has; the last tick of a stopped flight may be half sent."""
    stamps, reference = record.reference
    state = record.series["flight_state"]
    series = (record.servo_command[1], record.actuator_state[1], record.series["bench_condition"])
    count = min(len(stamps), len(record.truth.stamps), len(series[0]), len(series[1]), len(series[2].stamps))
    motion = record.truth
    truth = Motion(
        motion.stamps[:count],
        motion.position[:count],
        motion.attitude[:count],
        motion.velocity[:count],
        motion.rates[:count],
        motion.known[:count],
    )
    return FlownFlight(
        truth=truth,
        reference=(stamps[:count], reference[:count]),
        command=series[0][:count],
        actuators=series[1][:count],
        fan=series[2].column("position.fan")[:count],
        state=state.column("position.flight_state")[:count].round().astype(np.int64),
        reason=reason,
        record=record,
    )


def messages_of(flight: FlownFlight) -> FlightRecord:
    """The messages of a flight by components.

    Raises:
        ValueError: it was flown without.
    """
    if flight.record is None:
        raise ValueError("flown without messages; allowed: a plan with excitations or faults")
    return flight.record


def lost(flight: FlownFlight) -> str:
    """Why the helicopter counts as lost: stopped by the supervisor, or in touch with a stop; else empty.

    Args:
        flight: flown.
    """
    if flight.reason:
        return flight.reason
    rig, truth = RigGeometry(), flight.truth
    # the take-off begins on the lower stop
    flying = (flight.state == FlightState.FLYING) & (flight.reference[1][:, 2] < 0.5 * rig.rest_depth)
    north, east, down = truth.position[flying].T
    for touched, stop in (
        (down > rig.rest_depth - CONTACT, "the lower stop"),
        (down < rig.centre_height - rig.work_top + CONTACT, "the upper stop"),
        (np.hypot(north, east) > rig.work_radius - CONTACT, "the side of the work space"),
        (np.abs(truth.attitude[flying, 0]) > _FURTHEST_YAW, "the yaw stop"),
    ):
        if np.any(touched):
            return f"touched {stop}"
    return ""
