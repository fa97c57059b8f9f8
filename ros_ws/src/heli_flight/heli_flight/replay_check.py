"""Recorded inputs of a node through its component again: what it sends must be what it sent (spec 6.2).

What was asked of the node in flight, by parameter or service, stands in the recorded diagnostics with the
stamp at which it acted, and is asked of the component at the same stamp.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from heli_common.component import Message, update_of
from heli_common.errors import InputError
from heli_common.flight_state import flight_state_from_code
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_flight.bag_reader import Bag
from heli_flight.flight_hash import canonical_messages, stamps_of
from heli_flight.replay_components import Replayed, build


@dataclass(frozen=True)
class TopicReplay:
    """What became of one output.

    Attributes:
        topic: its name.
        recorded: messages in the bag.
        repeated: messages that the component sent.
        different: stamp of the first message that is not the same [ns], or None.
        until_ns: newest stamp that was compared [ns].
        whole: whether the flight came to its end in the bag; if not, what reaches further is not compared.
    """

    topic: str
    recorded: int
    repeated: int
    different: int | None
    until_ns: int
    whole: bool

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
        InputError: no such node, the bag does not say how it was built or what it heard, or what it sent
            depended on more than that.
    """
    replayed = build(bag, node)
    component = replayed.component
    for topic in component.inputs:
        if not bag.messages.get(topic):
            raise InputError("holds nothing of it", allowed="a whole flight", file=bag.folder, key=topic)
    outputs = tuple(topic for topic in component.outputs if topic in DATA_TOPICS)
    until_ns, whole = _end(bag, (*component.inputs, *outputs))
    sent: dict[str, list[bytes]] = {topic: [] for topic in outputs}
    for message in _run(bag, replayed):
        if message.topic in sent and message.stamp_ns <= until_ns:
            data = TOPICS[message.topic].layout.pack(message.stamp_ns, message.values)
            sent[message.topic].append(data)
    return [_compare(bag, topic, sent[topic], until_ns, whole) for topic in outputs]


def _run(bag: Bag, replayed: Replayed) -> list[Message]:
    """Everything that the component sends."""
    component = replayed.component
    heard = [
        (TOPICS[topic].layout.stamp(data), order, topic, data)
        for order, topic in enumerate(DATA_TOPICS)
        if topic in component.inputs
        for data in bag.messages[topic]
    ]
    heard.sort(key=lambda entry: entry[:2])
    requests = list(replayed.requests)
    update, sent = update_of(component), list[Message]()
    for stamp_ns, _, topic, data in heard:
        while requests and requests[0][0] <= stamp_ns:
            replayed.ask(*requests.pop(0))
        _, values = TOPICS[topic].layout.unpack(data)
        sent += component.receive(topic, stamp_ns, values)
        sent += update()
    return sent


def _end(bag: Bag, names: Sequence[str]) -> tuple[int, bool]:
    """Stamp up to which inputs and outputs can be compared, and whether the flight ends with it."""
    layout = TOPICS["flight_state"].layout
    for data in bag.messages.get("flight_state", []):
        stamp_ns, values = layout.unpack(data)
        if flight_state_from_code(values[0]).ended:
            return stamp_ns, True
    # a slow topic says nothing of the time until its next message
    last = [
        int(stamps_of(TOPICS[name].layout, bag.messages[name])[-1]) + TOPICS[name].period_ns - 1
        for name in names
        if bag.messages.get(name)
    ]
    return min(last), False


def _compare(bag: Bag, topic: str, repeated: list[bytes], until_ns: int, whole: bool) -> TopicReplay:
    layout = TOPICS[topic].layout
    recorded = bag.messages.get(topic, [])
    originals: Sequence[bytes] = canonical_messages(layout, recorded) if recorded else []
    if not whole:
        originals = [data for data in originals if layout.stamp(data) <= until_ns]
    different = next(
        (layout.stamp(one) for one, other in zip(originals, repeated, strict=False) if one != other), None
    )
    return TopicReplay(topic, len(originals), len(repeated), different, until_ns, whole)
