"""navigation: position, velocity and attitude from the encoders."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import ComponentProgram, run_node  # first: it takes the signals before rclpy

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_parameters
from heli_common.rig_geometry import RigGeometry
from heli_common.topics import NAVIGATION
from heli_navigation.navigator import NavigationParameters, Navigator


def build(node: Node, _running: tuple[str, ...]) -> ComponentProgram:
    """Declare parameters and build the navigator.

    Raises:
        InputError: a parameter is not allowed.
    """
    parameters = declare_parameters(node, NavigationParameters)
    geometry = declare_parameters(node, RigGeometry, "rig.")
    return ComponentProgram(Navigator(parameters, geometry))


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(NAVIGATION, build))


if __name__ == "__main__":
    main()
