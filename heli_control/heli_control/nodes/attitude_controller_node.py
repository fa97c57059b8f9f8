"""attitude_controller: flies whatever its controller file holds."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import ComponentProgram, run_node  # first: it takes the signals before rclpy

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_parameters, declare_text
from heli_common.topics import ATTITUDE_CONTROLLER
from heli_control.attitude_control import AttitudeController, AttitudeParameters
from heli_control.controller_file import load_controller


def build(node: Node, _running: tuple[str, ...]) -> ComponentProgram:
    """Declare parameters, read the controller file and build the controller.

    Raises:
        InputError: the controller file or a parameter is not allowed.
    """
    name = declare_text(node, "controller", "lq", "shipped controller or path of a controller file")
    parameters = declare_parameters(node, AttitudeParameters)
    return ComponentProgram(AttitudeController(load_controller(name), parameters))


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(ATTITUDE_CONTROLLER, build))


if __name__ == "__main__":
    main()
