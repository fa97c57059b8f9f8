"""A flight in this process that leaves no bag: what calibration and reproduction need of it, in memory.

`fly_for_figures` is the one place where they fly; whatever flies faster and gives the same bytes takes its place.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from heli_common.errors import SafetyStop
from heli_common.flight_state import FlightState
from heli_common.rig_geometry import RigGeometry
from heli_common.topics import TOPICS
from heli_control.controller_file import load_controller
from heli_flight.bag_reader import Bag
from heli_flight.components import DEFAULTS, bench_simulator, controllers, identifier, supervisor
from heli_flight.flight_record import FlightRecord
from heli_flight.in_process import InProcessGraph
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Plan

KEPT = (
    "ground_truth",
    "flight_state",
    "reference",
    "velocity_reference",
    "servo_command",
    "actuator_state",
    "wind",
    "bench_condition",
    "excitation",
    "rotor",
)
"""Topics that are kept; the others are flown and forgotten."""

RESULT = "result"
"""Remark that says why a flight ended early, as the recorder writes it."""

CONTACT = 0.005
"""How close to the end of travel counts as touching it [m]."""


def fly_for_figures(
    plan: Plan, controller: str, seed: int, values: NodeValues = DEFAULTS, kept: tuple[str, ...] = KEPT
) -> FlightRecord:
    """Fly a plan in this process and keep some of its topics.

    Args:
        plan: what to fly; its own seed and first controller do not count.
        controller: shipped controller or path, in place of the plan's first.
        seed: of every random number.
        values: parameters of the nodes.
        kept: topics.

    Returns:
        the record of a flight whether it was flown to its end or stopped; then `result` says why.

    Raises:
        InputError: no such controller.
    """
    plan = replace(plan, seed=seed, controller=controller)
    first, *later = [load_controller(name) for name in plan.controllers]
    excited = bool(plan.excitations)
    bench, leader = bench_simulator(seed, values, plan, excited), supervisor(plan, values)
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
    return FlightRecord(Bag(Path(plan.name), types, {}, messages, {RESULT: reason} if reason else {}, ()))


def lost(record: FlightRecord) -> str:
    """Why the helicopter counts as lost: stopped by the supervisor, or in touch with a stop; empty if it is not.

    Args:
        record: of a flight.
    """
    if reason := record.custom_data.get(RESULT, ""):
        return reason
    rig, truth = RigGeometry(), record.truth
    flying = np.zeros(len(truth.stamps), dtype=np.bool_)
    for stage in record.stages:
        if stage.state is FlightState.FLYING:
            flying |= (truth.stamps >= stage.start_ns) & (truth.stamps < stage.end_ns)
    stamps, reference = record.reference
    wanted = np.interp(truth.stamps, stamps, reference[:, 2]) if len(stamps) else np.zeros(len(truth.stamps))
    north, east, down = truth.position[flying].T
    away = wanted[flying] < 0.5 * rig.rest_depth  # the take-off begins on the stop
    if np.any(down[away] > rig.rest_depth - CONTACT):
        return "touched the lower stop"
    if np.any(np.hypot(north, east) > rig.work_radius - CONTACT):
        return "touched the side of the work space"
    if np.any(down < rig.centre_height - rig.work_top + CONTACT):
        return "touched the upper stop"
    if np.any(np.abs(truth.attitude[flying, 0]) > math.radians(169.0)):
        return "touched the yaw stop"
    return ""
