"""position_controller: see `heli_control.position_control`."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import ComponentProgram, run_node  # first: it takes the signals before rclpy

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_parameters
from heli_common.topics import IDENTIFICATION, POSITION_CONTROLLER
from heli_control.position_control import PositionController, PositionParameters


def build(node: Node, running: tuple[str, ...]) -> ComponentProgram:
    """Declare parameters and build the controller.

    Raises:
        InputError: a parameter is not allowed.
    """
    parameters = declare_parameters(node, PositionParameters)
    return ComponentProgram(PositionController(parameters, excited=IDENTIFICATION in running))


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(POSITION_CONTROLLER, build))


if __name__ == "__main__":
    main()
