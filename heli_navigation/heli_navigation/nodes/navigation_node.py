"""navigation: position, velocity, attitude and rates from encoders and IMU; what the sensors are worth."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import ComponentProgram, run_node  # first: it takes the signals before rclpy

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_parameters
from heli_common.rig_geometry import RigGeometry
from heli_common.topics import NAVIGATION
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.imu_attitude_parameters import ImuAttitudeParameters
from heli_navigation.navigator import NavigationParameters, Navigator
from heli_navigation.warm_up import warm_up


class NavigationProgram(ComponentProgram):
    """The navigator on the graph; it tells people when a sensor is lost or comes back."""

    def __init__(self, navigator: Navigator) -> None:
        super().__init__(navigator)
        self._navigator = navigator
        self._told = ""

    def on_message(self, topic: str, data: bytes) -> None:
        """Hand the numbers to the navigator, publish what it gives back, tell a change of its sensors."""
        super().on_message(topic, data)
        said = self._navigator.complaints
        if said != self._told and self.connection is not None:
            self._told = said
            stamp_ns, _ = self._unpack[topic](data)
            self.connection.diagnose(stamp_ns, "warn" if said else "ok", said or "all sensors are there")


def build(node: Node, _running: tuple[str, ...]) -> NavigationProgram:
    """Declare parameters and build the navigator.

    Raises:
        InputError: a parameter is not allowed.
    """
    navigator = Navigator(
        declare_parameters(node, NavigationParameters),
        declare_parameters(node, RigGeometry, "rig."),
        declare_parameters(node, FilterParameters, "filter."),
        declare_parameters(node, ImuAttitudeParameters, "imu_attitude."),
    )
    warm_up()
    return NavigationProgram(navigator)


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(NAVIGATION, build))


if __name__ == "__main__":
    main()
