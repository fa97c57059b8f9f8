"""Recorded inputs of a node through its component again: what it sends must be what it sent (spec 6.2)."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from heli_common import topics
from heli_common.component import Component
from heli_common.errors import InputError
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_control.controller_file import ControllerFile
from heli_control.motor_controller_file import MotorControllerFile
from heli_flight.bag_reader import Bag
from heli_flight.components import DEFAULTS, controllers, identifier, navigator, supervisor
from heli_flight.flight_hash import canonical_messages
from heli_flight.parameter_file import NodeValues, read_parameters
from heli_flight.plan import Plan, parse_plan


@dataclass(frozen=True)
class TopicReplay:
    """What became of one output.

    Attributes:
        topic: its name.
        recorded: messages in the bag.
        repeated: messages that the component sent.
        different: stamp of the first message that is not the same [ns], or None.
    """

    topic: str
    recorded: int
    repeated: int
    different: int | None

    @property
    def same(self) -> bool:
        """Whether every byte is."""
        return self.recorded == self.repeated and self.different is None


def replay(bag: Bag, node: str) -> list[TopicReplay]:
    """Feed the inputs of a node from a bag into its component, and compare what it sends.

    Args:
        bag: of a flight.
        node: name of the node.

    Raises:
        InputError: no such node, or the bag does not say how it was built or what it heard.
    """
    component = build(bag, node)
    for topic in component.inputs:
        if not bag.messages.get(topic):
            raise InputError("holds nothing of it", allowed="a whole flight", file=bag.folder, key=topic)
    heard = [
        (TOPICS[topic].layout.stamp(data), order, topic, data)
        for order, topic in enumerate(DATA_TOPICS)
        if topic in component.inputs
        for data in bag.messages[topic]
    ]
    sent: dict[str, list[bytes]] = {topic: [] for topic in component.outputs}
    for stamp_ns, _, topic, data in sorted(heard, key=lambda entry: entry[:2]):
        _, values = TOPICS[topic].layout.unpack(data)
        for message in component.receive(topic, stamp_ns, values):
            sent[message.topic].append(TOPICS[message.topic].layout.pack(message.stamp_ns, message.values))
    return [_compare(topic, bag.messages.get(topic, []), sent[topic]) for topic in component.outputs]


def _compare(topic: str, recorded: Sequence[bytes], repeated: list[bytes]) -> TopicReplay:
    layout = TOPICS[topic].layout
    originals = canonical_messages(layout, recorded) if recorded else []
    different = next(
        (layout.stamp(one) for one, other in zip(originals, repeated, strict=False) if one != other), None
    )
    return TopicReplay(topic, len(originals), len(repeated), different)


def build(bag: Bag, node: str) -> Component:
    """The component of a node as it flew, from what the bag carries.

    Raises:
        InputError: no such node, or a remark of the bag is missing or damaged.
    """
    values = _parameters(bag)
    builders: dict[str, Callable[[], Component]] = {
        topics.NAVIGATION: lambda: navigator(values),
        topics.SUPERVISOR: lambda: supervisor(_plan(bag), values),
        topics.IDENTIFICATION: lambda: identifier(_plan(bag), values),
    }
    for name in (topics.POSITION_CONTROLLER, topics.ATTITUDE_CONTROLLER, topics.MOTOR_CONTROLLER):
        builders[name] = lambda name=name: _controller(bag, name, values)  # type: ignore[misc]
    if node not in builders:
        raise InputError(f"unknown node {node!r}", allowed=", ".join(builders), key="--into")
    return builders[node]()


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
