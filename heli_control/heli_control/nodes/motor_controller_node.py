"""motor_controller: see `heli_control.motor_control`."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import ComponentProgram, run_node  # first: it takes the signals before rclpy

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_text
from heli_common.topics import MOTOR_CONTROLLER
from heli_control.motor_control import MotorController
from heli_control.motor_controller_file import load_motor_controller


def build(node: Node, _running: tuple[str, ...]) -> ComponentProgram:
    """Declare parameters, read the controller file and build the controller.

    Raises:
        InputError: the controller file or a parameter is not allowed.
    """
    name = declare_text(node, "controller", "motor", "shipped motor controller or path of its file")
    return ComponentProgram(MotorController(load_motor_controller(name).parameters))


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(MOTOR_CONTROLLER, build))


if __name__ == "__main__":
    main()
