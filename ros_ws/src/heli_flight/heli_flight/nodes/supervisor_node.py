"""supervisor: takes the bench through a plan, or through its services without one."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import run_node  # first: it takes the signals before rclpy does

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_parameters, declare_request, declare_text
from heli_common.topics import SUPERVISOR
from heli_flight.nodes.supervisor_program import SupervisorProgram
from heli_flight.plan import load_plan
from heli_flight.stages import FlightLimits
from heli_flight.supervisor import Supervisor


def build(node: Node, _running: tuple[str, ...]) -> SupervisorProgram:
    """Declare parameters, read the plan and build the supervisor.

    Raises:
        InputError: the plan or a parameter is not allowed.
    """
    name = declare_text(node, "plan", "", "name of a shipped plan or path of a plan file; empty: services")
    limits = declare_parameters(node, FlightLimits)
    supervisor = Supervisor(limits, load_plan(name) if name else None)
    about = "set it to command the wind generator, 0 .. 8 m/s, while no plan is flown"
    program = SupervisorProgram(node, supervisor)
    declare_request(node, "wind", 0.0, about, lambda speed: program.set_wind(float(speed)))
    return program


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(SUPERVISOR, build))


if __name__ == "__main__":
    main()
