"""How much the integration step matters: the largest change of a 10 s flight when every step is halved.

Run: python benchmarks/steps.py [--json]. Two flights: open loop from trim, shaken by cyclic doublets for 4 s,
and a whole plan in closed loop, from homing to landing, with the whole chain of sensors and controllers.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from heli_bench_sim import bench as bench_module
from heli_bench_sim.bench import REFINEMENT, Bench
from heli_bench_sim.parameters import thesis
from heli_bench_sim.simulator import BenchSimulator
from heli_bench_sim.states import State
from heli_bench_sim.trim import trim
from heli_common.timing import SENSOR_PERIOD
from heli_control.controller_file import load_controller
from heli_flight.components import controllers, supervisor
from heli_flight.in_process import InProcessGraph
from heli_flight.plan import load_plan

Array = NDArray[np.float64]


def doublets() -> Array:
    """(n, 3) 10 s in open loop from trim with some speed, cyclic doublets during 4 s."""
    hover = trim(thesis())
    state = hover.state
    state[[State.u, State.v]] = 0.1, -0.1
    bench, path = Bench(), []
    bench.place(state, hover.inputs)
    for tick in range(round(10.0 / SENSOR_PERIOD)):
        if tick % 8 == 2:
            time = tick * SENSOR_PERIOD
            size = 1.0 if time < 4.0 else 0.0
            ahead = 0.0045 * size * np.sign(np.sin(2.0 * math.pi * time))
            aside = 0.003 * size * np.sign(np.sin(2.0 * math.pi * time / 0.7))
            bench.set_servo_command(hover.B_1s + ahead, hover.A_1s + aside, hover.theta_0, hover.theta_t)
        bench.advance()
        path.append(bench.position)
    return np.array(path)


def run_up() -> Array:
    """(n, 3) 10 s on the skids in closed loop: homing by the hand, then the run-up begins."""
    plan = load_plan("short_hover")
    bench, path = BenchSimulator(Bench(seed=plan.seed)), []
    graph = InProcessGraph(
        bench, [supervisor(plan), *controllers(load_controller(plan.controller))], lambda *_: None
    )
    while bench.stamp_ns < 10_000_000_000:
        graph.advance()
        path.append(bench.bench.position)
    return np.array(path)


FLIGHTS: dict[str, Callable[[], Array]] = {
    "open loop from trim, cyclic doublets": doublets,
    "homing and run-up on the stop, closed loop": run_up,
}


def changes() -> dict[str, tuple[float, float]]:
    """Per flight: way travelled and largest change of position with half the step [m]."""
    found = {}
    for name, fly in FLIGHTS.items():
        paths = []
        for refinement in (REFINEMENT, 2 * REFINEMENT):
            bench_module.REFINEMENT = refinement
            paths.append(fly())
        bench_module.REFINEMENT = REFINEMENT
        travelled = float(np.ptp(paths[0], axis=0).max())
        found[name] = (travelled, float(np.abs(paths[0] - paths[1]).max()))
    return found


def main() -> None:
    """Fly and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    found = changes()
    if options.json:
        sys.stdout.write(
            json.dumps({name: {"travelled_m": a, "change_m": b} for name, (a, b) in found.items()}) + "\n"
        )
        return
    table = Table("flight of 10 s", "way [m]", "change with half the step [mm]")
    for name, (travelled, change) in found.items():
        table.add_row(name, f"{travelled:.2f}", f"{1e3 * change:.2g}")
    Console().print(table)


if __name__ == "__main__":
    main()
