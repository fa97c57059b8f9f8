"""composed: every node of a flight in one process and one thread, still a ROS 2 node each."""

from __future__ import annotations

import json
import sys
from importlib import import_module
from pathlib import Path

from heli_common.nodes.runner import run_nodes  # first: it takes the signals before rclpy does

# isort: split
from heli_flight.process_table import PROCESSES


def main() -> None:
    """Entry point: `composed_node FILE`, a JSON object of ROS arguments by node name."""
    arguments: dict[str, list[str]] = json.loads(Path(sys.argv[1]).read_text())
    nodes = {each.name: import_module(each.module) for each in PROCESSES if each.name in arguments}
    sys.exit(run_nodes({name: (module.build, arguments[name]) for name, module in nodes.items()}))


if __name__ == "__main__":
    main()
