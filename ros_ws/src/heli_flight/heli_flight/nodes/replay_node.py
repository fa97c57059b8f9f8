"""replay: plays recorded topics of a bag into the graph, with the clock, paced by the wall clock."""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

from heli_common.nodes.runner import run_node  # first: it takes the signals before rclpy does

# isort: split
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from heli_common.component import Message
from heli_common.errors import InputError
from heli_common.nodes.connection import Connection
from heli_common.nodes.parameters import declare_names, declare_text
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_flight.bag_reader import read_bag

REPLAY = "replay"
CLOCK = "clock"
READY_SECONDS = 0.02


class ReplayProgram:
    """Publishes messages at the distances of their stamps.

    Args:
        messages: topic, stamp [ns] and serialized message, in the order of playing.
        topics: that are played.
        rate: simulated seconds per second.
    """

    name = REPLAY
    inputs: tuple[str, ...] = ()

    def __init__(self, messages: list[tuple[str, int, bytes]], topics: tuple[str, ...], rate: float) -> None:
        self.outputs = (*topics, CLOCK)
        self.finished = not messages
        self._messages = messages
        self._rate = rate
        self._next = 0
        self._zero = 0.0
        self._connection: Connection | None = None

    def start(self, connection: Connection) -> None:
        """The first message follows when every node of this graph has said that it is ready."""
        self._connection = connection

    def on_message(self, topic: str, data: bytes) -> None:
        """Nothing is listened to."""

    def turn(self) -> float:
        """Publish what is due; returns how long until the next message [s]."""
        assert self._connection is not None
        if self._connection.absent():
            return READY_SECONDS
        if not self._zero:
            self._zero = perf_counter() - self._messages[0][1] * 1e-9 / self._rate
        while self._next < len(self._messages):
            topic, stamp_ns, data = self._messages[self._next]
            wait = self._zero + stamp_ns * 1e-9 / self._rate - perf_counter()
            if wait > 0.0:
                return min(wait, 0.1)
            self._next += 1
            self._connection.publish_serialized(topic, data)
            if self._next == len(self._messages) or self._messages[self._next][1] != stamp_ns:
                self._connection.publish([Message(CLOCK, stamp_ns, ())])
        self.finished = True
        return 0.01

    def close(self) -> None:
        """Nothing to finish."""


def build(node: Node, _running: tuple[str, ...]) -> ReplayProgram:
    """Declare parameters and read the bag.

    Raises:
        InputError: no bag, no such topic in it, or a rate that is none.
    """
    folder = declare_text(node, "bag", "", "folder of the bag to play")
    chosen = declare_names(node, "topics", "topics to play, comma-separated; empty: all data topics")
    about = "simulated seconds per second"
    text = ParameterDescriptor(description=about, read_only=True, dynamic_typing=True)
    rate = node.declare_parameter("rate", 1.0, text).value
    if isinstance(rate, bool) or not isinstance(rate, (int, float)) or not 0.01 <= rate <= 100.0:
        raise InputError(f"{rate!r} is refused", allowed="0.01 .. 100", key="rate")
    if not folder:
        raise InputError("no folder given", allowed="a recorded bag", key="bag")
    bag = read_bag(Path(folder))
    present = tuple(topic for topic in DATA_TOPICS if bag.messages.get(topic))
    for topic in chosen:
        if topic not in present:
            raise InputError(f"no topic {topic!r}", allowed=", ".join(present), file=folder, key="topics")
    topics = chosen or present
    messages = [
        (topic, TOPICS[topic].layout.stamp(data), data) for topic in topics for data in bag.messages[topic]
    ]
    order = {topic: index for index, topic in enumerate(DATA_TOPICS)}
    messages.sort(key=lambda entry: (entry[1], order[entry[0]]))
    return ReplayProgram(messages, topics, float(rate))


def main() -> None:
    """Entry point of the node: `replay_node [BAG] [--ros-args ...]`."""
    words = sys.argv[1:]
    if words and not words[0].startswith("-"):
        words = [*words[1:], "--ros-args", "-p", f"bag:='{words[0]}'"]
    sys.exit(run_node(REPLAY, build, words))


if __name__ == "__main__":
    main()
