"""attitude_controller: flies whatever its controller file holds."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import run_node  # first: it takes the signals before rclpy

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_names, declare_parameters, declare_request, declare_text
from heli_common.topics import ATTITUDE_CONTROLLER
from heli_control.attitude_control import AttitudeController, AttitudeParameters
from heli_control.controller_file import load_controller
from heli_control.nodes.attitude_program import AttitudeProgram


def build(node: Node, _running: tuple[str, ...]) -> AttitudeProgram:
    """Declare parameters, read the controller files and build the controller.

    Raises:
        InputError: a controller file or a parameter is not allowed.
    """
    plant = declare_text(node, "plant", "", "hash of the plant that controllers must be for; empty: any")
    about = "controllers of the plan in order, comma-separated, before `controller`; empty: that one alone"
    planned = declare_names(node, "plan_controllers", about)
    parameters = declare_parameters(node, AttitudeParameters)
    about = "shipped controller or path of a controller file; may be set while flying"
    declare_request(node, "controller", "lq", about, lambda name: program.request(name))
    names = planned or (str(node.get_parameter("controller").value),)
    first, *later = [load_controller(name, plant) for name in names]
    program = AttitudeProgram(AttitudeController(first, parameters, later), plant)
    return program


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(ATTITUDE_CONTROLLER, build))


if __name__ == "__main__":
    main()
