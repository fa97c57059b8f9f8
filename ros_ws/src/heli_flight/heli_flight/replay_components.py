"""The component of a node as it flew, built from what the bag of its flight carries."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_typestore

from heli_bench_sim.fault_request import fault_from_text
from heli_bench_sim.simulator import BenchSimulator
from heli_common import topics
from heli_common.component import Component, Message
from heli_common.errors import InputError
from heli_control.attitude_control import AttitudeController
from heli_control.controller_file import ControllerFile
from heli_control.motor_controller_file import MotorControllerFile
from heli_flight.bag_reader import Bag
from heli_flight.components import (
    DEFAULTS,
    bench_simulator,
    controllers,
    identifier,
    navigator,
    supervisor,
)
from heli_flight.parameter_file import NodeValues, read_parameters
from heli_flight.plan import Plan, parse_plan

DIAGNOSTICS = "diagnostics"
REQUEST = "request"
_DIAGNOSTIC_ARRAY = "diagnostic_msgs/msg/DiagnosticArray"

Ask = Callable[[int, str], None]
"""Asks something of a component: stamp at which it acted [ns] and text."""


@dataclass(frozen=True)
class Replayed:
    """A component and what was asked of it in flight.

    Attributes:
        component: as it flew.
        requests: stamp at which each acted [ns] and its text, in order.
        ask: asks it again.
    """

    component: Component
    requests: tuple[tuple[int, str], ...]
    ask: Ask


class ReplayedBench:
    """The bench as a component that goes on whenever its commands are there, as it does in lockstep."""

    name = topics.BENCH_SIM

    def __init__(self, simulator: BenchSimulator) -> None:
        self.simulator = simulator
        self.inputs, self.outputs = simulator.inputs, simulator.outputs

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Take a command in; give back the samples up to the next one that needs a command."""
        sent = self.simulator.receive(topic, stamp_ns, values)
        while self.simulator.ended_at is None and not self.simulator.missing():
            sent += self.simulator.tick()
        return sent


def build(bag: Bag, node: str) -> Replayed:
    """The component of a node as it flew, from what the bag carries.

    Raises:
        InputError: no such node, a remark of the bag is missing or damaged, or what the node sent depended
            on something that is not in the bag.
    """
    values = _parameters(bag)
    builders: dict[str, Callable[[], tuple[Component, Ask]]] = {
        topics.BENCH_SIM: lambda: _bench(bag, values),
        topics.NAVIGATION: lambda: (navigator(values), _refuse),
        topics.SUPERVISOR: lambda: _supervisor(bag, values),
        topics.POSITION_CONTROLLER: lambda: (_controller(bag, topics.POSITION_CONTROLLER, values), _refuse),
        topics.ATTITUDE_CONTROLLER: lambda: _attitude(bag, values),
        topics.MOTOR_CONTROLLER: lambda: (_controller(bag, topics.MOTOR_CONTROLLER, values), _refuse),
        topics.IDENTIFICATION: lambda: _identification(bag, values),
    }
    if node not in builders:
        raise InputError(f"unknown node {node!r}", allowed=", ".join(builders), key="--into")
    component, ask = builders[node]()
    return Replayed(component, requests_of(bag, node), ask)


def requests_of(bag: Bag, node: str) -> tuple[tuple[int, str], ...]:
    """What was asked of a node in flight by parameter or service: stamp at which it acted [ns], and text."""
    store = get_typestore(Stores.ROS2_JAZZY)
    found = []
    for data in bag.messages.get(DIAGNOSTICS, []):
        array: Any = store.deserialize_cdr(data, _DIAGNOSTIC_ARRAY)
        stamp_ns = array.header.stamp.sec * 1_000_000_000 + array.header.stamp.nanosec
        for status in array.status:
            if status.name == node:
                found += [(stamp_ns, pair.value) for pair in status.values if pair.key == REQUEST]
    return tuple(sorted(found, key=lambda request: request[0]))


def _bench(bag: Bag, values: NodeValues) -> tuple[Component, Ask]:
    for key, count in bag.custom_data.items():
        if key.startswith("late_") and count != "0":
            problem = f"{count}: when a late command came is not in the bag"
            raise InputError(problem, allowed="0", file=bag.folder, key=key)
    seed = _remark(bag, "seed")
    if not seed.isdecimal():
        raise InputError(f"{seed!r}", allowed="a number", file=bag.folder, key="seed")
    identified = bool(bag.messages.get("excitation"))
    simulator = bench_simulator(int(seed), values, _plan(bag), identified)
    # faults have a time of their own: the bench may know them from the start
    for stamp_ns, text in requests_of(bag, topics.BENCH_SIM):
        simulator.bench.add_fault(fault_from_text(text, now_ns=stamp_ns))
    return ReplayedBench(simulator), _nothing


def _supervisor(bag: Bag, values: NodeValues) -> tuple[Component, Ask]:
    component = supervisor(_plan(bag), values)

    def ask(_stamp_ns: int, text: str) -> None:
        component.command(text)

    return component, ask


def _attitude(bag: Bag, values: NodeValues) -> tuple[Component, Ask]:
    component = _controller(bag, topics.ATTITUDE_CONTROLLER, values)
    assert isinstance(component, AttitudeController)

    def ask(_stamp_ns: int, text: str) -> None:
        with _as_file(text) as path:
            component.replace(ControllerFile.read(path))

    return component, ask


def _identification(bag: Bag, values: NodeValues) -> tuple[Component, Ask]:
    component = identifier(_plan(bag), values)
    return component, lambda _, text: component.request(text)


def _nothing(_stamp_ns: int, _text: str) -> None:
    """Was asked for already."""


def _refuse(stamp_ns: int, text: str) -> None:
    raise InputError(f"{text!r} was asked for at {stamp_ns * 1e-9:.2f} s", allowed="nothing", key=REQUEST)


def _controller(bag: Bag, name: str, values: NodeValues) -> Component:
    files = []
    for text in _remark(bag, "controller_file").split("---\n"):
        with _as_file(text) as path:
            files.append(ControllerFile.read(path))
    with _as_file(_remark(bag, "motor_file")) as path:
        motor = MotorControllerFile.read(path)
    identified = bool(bag.messages.get("reference_excitation"))
    (found,) = (
        part for part in controllers(files[0], values, files[1:], motor, identified) if part.name == name
    )
    return found


def _plan(bag: Bag) -> Plan:
    return parse_plan(_remark(bag, "plan"), str(bag.folder))


def _parameters(bag: Bag) -> NodeValues:
    text = _remark(bag, "parameters")
    if text == "defaults":
        return DEFAULTS
    with _as_file(text) as path:
        return read_parameters(path)


@contextmanager
def _as_file(text: str) -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="heli_") as folder:
        path = Path(folder) / "remark.yaml"
        path.write_text(text)
        yield path


def _remark(bag: Bag, key: str) -> str:
    text = bag.custom_data.get(key)
    if text is None:
        raise InputError("is missing", allowed="a bag of `heli fly`", file=bag.folder, key=key)
    return text
