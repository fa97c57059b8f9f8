"""motor_controller: see `heli_control.motor_control`."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import ComponentProgram, run_node  # first: it takes the signals before rclpy

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_parameters
from heli_common.topics import MOTOR_CONTROLLER
from heli_control.motor_control import MotorController, MotorParameters


def build(node: Node, _running: tuple[str, ...]) -> ComponentProgram:
    """Declare parameters and build the controller.

    Raises:
        InputError: a parameter is not allowed.
    """
    return ComponentProgram(MotorController(declare_parameters(node, MotorParameters)))


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(MOTOR_CONTROLLER, build))


if __name__ == "__main__":
    main()
