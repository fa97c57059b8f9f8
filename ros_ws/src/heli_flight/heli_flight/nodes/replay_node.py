"""replay: plays recorded topics of a bag into the graph, with the clock, paced by the wall clock."""

from __future__ import annotations

import argparse
import sys
from math import inf
from pathlib import Path

from heli_common.nodes.runner import run_node  # first: it takes the signals before rclpy does

# isort: split
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from heli_common.errors import EXIT_BAD_INPUT, InputError
from heli_common.nodes.parameters import declare_names, declare_text
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_flight.bag_reader import Bag, read_bag
from heli_flight.nodes.replay_program import REPLAY, Recorded, ReplayProgram, declare_rate
from heli_flight.playback import Playback

HELP = """Play a bag into the graph: recorded data topics and the clock. Everything may also be given as ROS
parameters."""


def build(node: Node, running: tuple[str, ...]) -> ReplayProgram:
    """Declare parameters and read the bag.

    Raises:
        InputError: no bag, no such topic in it, a number out of range, or nothing left to play.
    """
    folder = declare_text(node, "bag", "", "folder of the bag to play")
    about = "topics to play, comma-separated; empty: all data topics that no running node publishes"
    chosen = declare_names(node, "topics", about)
    rate = declare_rate(node)
    offset = _seconds(node, "start_offset", 0.0, "of the bag are left out [s]")
    length = _seconds(node, "duration", inf, "of the bag are played [s]")
    paused = bool(node.declare_parameter("start_paused", False, _described("wait for resume")).value)
    if not folder:
        raise InputError("no folder given", allowed="a recorded bag", key="bag")
    bag = read_bag(Path(folder))
    topics = _topics(bag, chosen, running)
    messages = recorded_messages(bag, topics)
    first = messages[0][0] + round(offset * 1e9)
    last = first + length * 1e9
    messages = [entry for entry in messages if first <= entry[0] <= last]
    if not messages:
        raise InputError(f"nothing to play after {offset:g} s", file=folder, key="start_offset")
    return ReplayProgram(node, messages, topics, Playback(messages[0][0], rate, paused))


def recorded_messages(bag: Bag, topics: tuple[str, ...]) -> list[Recorded]:
    """Messages of some topics in the order of playing: by stamp, then as in the table of topics."""
    order = {topic: index for index, topic in enumerate(DATA_TOPICS)}
    messages = [
        (TOPICS[topic].layout.stamp(data), topic, data) for topic in topics for data in bag.messages[topic]
    ]
    messages.sort(key=lambda entry: (entry[0], order[entry[1]]))
    return messages


def _topics(bag: Bag, chosen: tuple[str, ...], running: tuple[str, ...]) -> tuple[str, ...]:
    present = tuple(topic for topic in DATA_TOPICS if bag.messages.get(topic))
    for topic in chosen:
        if topic not in present:
            raise InputError(f"no topic {topic!r}", allowed=", ".join(present), file=bag.folder, key="topics")
    topics = chosen or tuple(topic for topic in present if TOPICS[topic].source not in running)
    if not topics:
        raise InputError("holds no data topic to play", file=bag.folder, key="topics")
    return topics


def _described(text: str) -> ParameterDescriptor:
    return ParameterDescriptor(description=text, read_only=True, dynamic_typing=True)


def _seconds(node: Node, name: str, default: float, text: str) -> float:
    value = node.declare_parameter(name, default, _described(text)).value
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value >= 0.0:
        raise InputError(f"{value!r} is refused", allowed="0 or more", key=name)
    return float(value)


def ros_arguments(words: list[str]) -> list[str]:
    """The words of the command as ROS arguments.

    Raises:
        SystemExit: help was asked for, or a word is not understood.
    """
    own, ros = (words, []) if "--ros-args" not in words else _split(words)
    parser = argparse.ArgumentParser(prog="replay.sh", description=HELP)
    parser.add_argument("bag", nargs="?", metavar="BAG", help="folder of the bag")
    parser.add_argument("--rate", help="simulated seconds per second, 0.01 to 100 (1)")
    parser.add_argument("--start-offset", metavar="S", help="seconds of the bag to leave out")
    parser.add_argument("--duration", metavar="S", help="seconds of the bag to play")
    parser.add_argument("--topics", metavar="A,B", help="topics to play, comma-separated")
    parser.add_argument("--start-paused", action="store_true", default=None, help="wait for resume")
    parser.add_argument("--running", metavar="A,B", help="nodes to wait for; what they publish is not played")
    given = vars(parser.parse_args(own))
    if given["running"]:
        given["running"] = f"{REPLAY},{given['running']}"
    texts = {name: f"'{given[name]}'" for name in ("bag", "topics", "running") if given[name] is not None}
    numbers = {name: given[name] for name in ("rate", "start_offset", "duration") if given[name] is not None}
    flags = {"start_paused": "true"} if given["start_paused"] else {}
    values = texts | numbers | flags
    parameters = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
    return ["--ros-args", *parameters, *ros] if parameters or ros else []


def _split(words: list[str]) -> tuple[list[str], list[str]]:
    place = words.index("--ros-args")
    return words[:place], words[place + 1 :]


def main() -> None:
    """Entry point of the node: `replay_node [BAG] [options] [--ros-args ...]`."""
    try:
        arguments = ros_arguments(sys.argv[1:])
    except SystemExit as stop:
        sys.exit(EXIT_BAD_INPUT if stop.code else 0)
    sys.exit(run_node(REPLAY, build, arguments))


if __name__ == "__main__":
    main()
