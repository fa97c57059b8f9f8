"""bench_sim: the simulated bench as a ROS 2 node."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import run_node  # first: it takes the signals before rclpy does

# isort: split
import yaml
from rclpy.node import Node

from heli_bench_sim.bench import Bench
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.fault_words import fault_schedule
from heli_bench_sim.faults import FaultSchedule
from heli_bench_sim.nodes.bench_program import LOCKSTEP, MODES, BenchProgram
from heli_bench_sim.nodes.rig_display import RigDisplay
from heli_bench_sim.simulator import BenchSimulator
from heli_bench_sim.warm_up import warm_up
from heli_bench_sim.watch import WatchParameters
from heli_common.errors import InputError
from heli_common.nodes.parameters import (
    declare_groups,
    declare_integer,
    declare_parameters,
    declare_request,
    declare_text,
)
from heli_common.topics import BENCH_SIM, IDENTIFICATION


def build(node: Node, running: tuple[str, ...]) -> BenchProgram:
    """Declare parameters and build the bench.

    Raises:
        InputError: a parameter is not allowed.
    """
    mode = declare_text(node, "mode", LOCKSTEP, f"way of running: {' or '.join(MODES)}")
    if mode not in MODES:
        raise InputError(f"{mode!r}", allowed=", ".join(MODES), key="mode")
    seed = declare_integer(node, "seed", 1, "seed of every random number of the bench", 0, 2**31 - 1)
    parameters = declare_groups(node, BenchParameters)
    watch = declare_parameters(node, WatchParameters, "watch.")
    faults = _read_faults(declare_text(node, "faults", "[]", "what goes wrong and when, as in a plan (YAML)"))
    warm_up(parameters)
    bench = Bench(parameters, seed, faults=faults)
    simulator = BenchSimulator(bench, excited=IDENTIFICATION in running)
    about = "set it to let something go wrong now, e.g. encoder_stuck encoder=arm_1 for_s=2"
    program = BenchProgram(simulator, mode, running, watch, RigDisplay(node, parameters).show)
    declare_request(node, "fault", "", about, lambda text: program.request_fault(str(text)))
    return program


def _read_faults(text: str) -> FaultSchedule:
    try:
        return fault_schedule(yaml.safe_load(text))
    except yaml.YAMLError as error:
        problem = str(error).splitlines()[0]
        raise InputError(f"no YAML: {problem}", allowed="a list of faults", key="faults") from None


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(BENCH_SIM, build))


if __name__ == "__main__":
    main()
