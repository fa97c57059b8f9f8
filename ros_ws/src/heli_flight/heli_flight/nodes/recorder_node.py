"""recorder: writes the flight into a rosbag2 bag."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from heli_common.nodes.runner import run_node  # first: it takes the signals before rclpy does

# isort: split
from rclpy.node import Node

from heli_common.errors import InputError
from heli_common.nodes.parameters import declare_text
from heli_common.topics import RECORDER, TOPICS, data_topics
from heli_flight.bag import STORAGES
from heli_flight.framed_bag import FramedBagWriter
from heli_flight.mode import Mode
from heli_flight.nodes.recorder_program import DIAGNOSTICS, RecorderProgram

PACED = tuple(mode.value for mode in Mode if mode.paced)


def build(node: Node, running: tuple[str, ...]) -> RecorderProgram:
    """Declare parameters and open the bag.

    Raises:
        InputError: no folder is given, it is not empty or cannot be written, no such storage, or the
            notes are unreadable.
    """
    folder = declare_text(node, "bag", "", "folder of the bag to write")
    storage = declare_text(node, "storage", "mcap", f"way of storing: {', '.join(STORAGES)}")
    notes = declare_text(node, "notes", "", "JSON file of what the bag shall carry: plan, seed, versions")
    if not folder:
        raise InputError("no folder given", allowed="a new folder", key="bag")
    about = _read_notes(notes)
    bag = FramedBagWriter(Path(folder), about, storage)
    recorded = data_topics(running)
    for topic in recorded:
        bag.add_topic(topic, TOPICS[topic].layout.ros_type)
    bag.add_topic(DIAGNOSTICS, "diagnostic_msgs/msg/DiagnosticArray")
    return RecorderProgram(node, bag, recorded, about.get("mode") in PACED)


def _read_notes(path: str) -> dict[str, str]:
    if not path:
        return {}
    try:
        return {str(key): str(value) for key, value in json.loads(Path(path).read_text()).items()}
    except (OSError, ValueError, AttributeError) as error:
        raise InputError(f"unreadable: {error}", allowed="a JSON object", file=path, key="notes") from None


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(RECORDER, build))


if __name__ == "__main__":
    main()
