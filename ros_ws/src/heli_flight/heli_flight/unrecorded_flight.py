"""A flight in this process that leaves no bag: what calibration and reproduction need of it, in memory.

`fly_for_figures` is the one place where they fly: without messages where the plan allows it (`swift_flight`),
else by the components of `in_process`. `fly_excited` adds the excitations of a plan to the commands of a
swift flight, without the identification and its guard. All give the same numbers (a test compares them).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.flight_state import FlightState
from heli_common.rig_geometry import RigGeometry
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import SERVO_CHANNELS, TOPICS
from heli_control.controller_file import load_controller
from heli_flight.bag_reader import Bag
from heli_flight.components import DEFAULTS, bench_simulator
from heli_flight.flight_log import FlightLog
from heli_flight.flight_record import Array, FlightRecord, Motion, Stage, Stamps, stages_of
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Excite, Hover, Phase, Plan
from heli_flight.swift_flight import SwiftFlight, fly_components, is_swift
from heli_identification.excitation import COMMAND_CHANNELS, samples

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
_COMMANDS = len(SERVO_CHANNELS)
_NOTHING = (0.0,) * _COMMANDS


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
        excitation: added to the command [rad], shape (n, 4).
        record: its messages, of a flight by components.
    """

    truth: Motion
    reference: tuple[Stamps, Array]
    command: Array
    actuators: Array
    fan: Array
    state: NDArray[np.int64]
    reason: str
    excitation: Array
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


def fly_excited(plan: Plan, controller: str, seed: int, values: NodeValues = DEFAULTS) -> FlownFlight:
    """Fly a plan whose excitations act on the servos' commands, with nobody who would end them early.

    Args:
        plan: what to fly; its own seed and first controller do not count.
        controller: shipped controller or path, in place of the plan's first.
        seed: of every random number of the bench.
        values: parameters of the nodes.

    Raises:
        InputError: no such controller, or an excitation of something else.
        ValueError: the plan has faults or several controllers.
    """
    tables: dict[int, Array] = {}
    phases: list[Phase] = []
    for number, phase in enumerate(plan.phases, 1):
        if not isinstance(phase, Excite):
            phases.append(phase)
            continue
        if not set(phase.excitation.channels) <= set(COMMAND_CHANNELS):
            raise InputError(
                f"excites {', '.join(phase.excitation.channels)}",
                allowed=", ".join(COMMAND_CHANNELS),
                key="channels",
            )
        tables[number] = samples(phase.excitation)[:, :_COMMANDS]
        phases.append(Hover(duration=phase.duration, wind=phase.wind, wind_to=phase.wind_to))
    quiet = replace(plan, seed=seed, controller=controller, phases=tuple(phases))
    return _swift(quiet, values, tables)


class _WatchedFlight(SwiftFlight):
    """A swift flight that also notes velocities, rates, actuators and fan, and may be excited.

    Args:
        plan: to be flown.
        values: parameters of the nodes.
        tables: what is added to the commands in phases of the plan, by number from 1, shape (k, 4) [rad].
    """

    def __init__(self, plan: Plan, values: NodeValues, tables: Mapping[int, Array]) -> None:
        super().__init__(plan, plan.seed, load_controller(plan.controller), values)
        if tables:
            self.bench = bench_simulator(plan.seed, values, plan, True)
        self._tables, self._begun = tables, dict.fromkeys(tables, 0)
        self.noted: list[tuple[float, ...]] = []

    def _control_tick(self, log: FlightLog, tick: int) -> None:
        super()._control_tick(log, tick)
        row, bench = self._excite(), self.bench.bench
        shafts = bench.actuator_state().angles
        self.noted.append((*bench.velocity, *bench.rates, *shafts, bench.fan_speed, *row))

    def _excite(self) -> tuple[float, ...]:
        """Send what is added at this tick."""
        phase, row = self.leader.phase, _NOTHING
        table = self._tables.get(phase)
        if table is not None and self._begun[phase] < len(table) and not self.leader.state.ended:
            row = tuple(table[self._begun[phase]].tolist())
            self._begun[phase] += 1
        if self._tables:
            stamp_ns = self.bench.stamp_ns
            self.bench.receive("excitation", stamp_ns, (*row, *_NOTHING, *_NOTHING))
            self.bench.receive("motor_excitation", stamp_ns, (0.0, 0.0, 0.0))
        return row


def _swift(plan: Plan, values: NodeValues, tables: Mapping[int, Array] = MappingProxyType({})) -> FlownFlight:
    flight = _WatchedFlight(plan, values, tables)
    log = flight.fly()
    count = len(flight.noted)
    stamps = np.arange(count, dtype=np.int64) * CONTROL_PERIOD_NS
    noted = np.array(flight.noted, dtype=np.float64).reshape(count, 6 + 2 * _COMMANDS + 1)
    velocity, rates, shafts, fan, added = np.split(noted, (3, 6, 6 + _COMMANDS, 7 + _COMMANDS), axis=1)
    pose = log.truth[:count]
    return FlownFlight(
        truth=Motion(stamps, pose[:, :3], pose[:, 3:], velocity, rates, np.ones(count, dtype=np.bool_)),
        reference=(stamps, log.reference[:count]),
        command=log.command[:count, :_COMMANDS],
        actuators=shafts,
        fan=fan[:, 0],
        state=log.state[:count],
        reason=log.reason,
        excitation=added,
    )


def _by_components(plan: Plan, values: NodeValues, kept: tuple[str, ...]) -> FlownFlight:
    first, *later = [load_controller(name) for name in plan.controllers]
    messages: dict[str, list[bytes]] = {topic: [] for topic in kept}

    def keep(topic: str, _stamp_ns: int, data: bytes) -> None:
        if topic in messages:
            messages[topic].append(data)

    _, reason = fly_components(plan, plan.seed, first, values, None, later, sink=keep)
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
        excitation=_excitation(record, count),
        record=record,
    )


def _excitation(record: FlightRecord, count: int) -> Array:
    series = record.series["excitation"]
    added = series.columns(tuple(f"position.{name}" for name in SERVO_CHANNELS))[:count]
    return np.vstack((added, np.zeros((count - len(added), _COMMANDS))))


def messages_of(flight: FlownFlight) -> FlightRecord:
    """The messages of a flight by components.

    Raises:
        ValueError: it was flown without.
    """
    if flight.record is None:
        raise ValueError("flown without messages; allowed: a plan with excitations or faults")
    return flight.record


def stopped(flight: FlownFlight) -> str:
    """Why the supervisor stopped the flight before it began to land; else empty.

    Args:
        flight: flown.
    """
    return "" if np.any(flight.state == FlightState.LANDING) else flight.reason


def lost(flight: FlownFlight) -> str:
    """Why the helicopter counts as lost: stopped in the air, or in touch with a stop; else empty.

    Args:
        flight: flown.
    """
    if reason := stopped(flight):
        return reason
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
