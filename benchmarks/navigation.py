"""How good and how honest the navigation is over many seeds, and what one update costs.

Run: python benchmarks/navigation.py [--seeds N] [--json]. Flies navigation_trial in process (hover in gusts,
steps, wind of 4 m/s) once for each seed, then prints what `heli navigation` prints of all of them together.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

import graph
from rich.console import Console

from heli_common.rig_geometry import RigGeometry
from heli_common.topics import NAVIGATION
from heli_control.controller_file import load_controller
from heli_flight.cli.navigation import assess, show
from heli_flight.flight_record import FlightRecord
from heli_flight.fly_in_process import fly_in_process
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import load_plan
from heli_navigation.arm_kinematics import arms_from_position
from heli_navigation.inertial_navigation import InertialNavigation

PLAN = "navigation_trial"


def update_cost() -> float:
    """Median of one call of `InertialNavigation.step` with a moving helicopter [us]."""
    geometry, filter_ = RigGeometry(), InertialNavigation()
    indexed, costs = (1.0,) * 6, []
    for sample in range(20_000):
        # a slow climb, so that lines are crossed and the whole update is at work
        arms = arms_from_position((0.0, 0.0, 0.2 - 2e-5 * sample), geometry)
        begin = perf_counter()
        filter_.step(arms, (0.0, 0.0, 0.0), indexed, (0.0, 0.0, 0.0), (0.0, 0.0, -9.81))
        costs.append(perf_counter() - begin)
    return 1e6 * median(costs)


def node_shares() -> dict[str, float]:
    """Share of a core [%] that the node takes in a real-time flight, and what its messages alone take."""
    plan, controller = load_plan("short_hover"), load_controller("lq")
    order = FlightOrder(plan, "short_hover", Mode.REALTIME, 1, controller, "lq", Path())
    with tempfile.TemporaryDirectory() as folder:
        flown = graph.flight(order, Mode.REALTIME, Path(folder))
    bare = graph.floor(Mode.REALTIME, scheduled=True)
    return {"node": flown.percent[NAVIGATION], "messages": bare.percent[NAVIGATION]}


def fly(seeds: int, folder: Path, console: Console) -> list[FlightRecord]:
    """One flight for each seed from 1."""
    plan, controller = load_plan(PLAN), load_controller("lq")
    records = []
    for seed in range(1, seeds + 1):
        begin = perf_counter()
        bag = folder / f"seed_{seed}"
        order = FlightOrder(plan, PLAN, Mode.INPROCESS, seed, controller, "lq", bag)
        end = fly_in_process(order, lambda _: None)
        if end.exit_code:
            console.print(f"seed {seed}: {end.reason}")
        left = (seeds - seed) * (perf_counter() - begin)
        console.print(f"seed {seed} of {seeds} flown, about {left:.0f} s left", highlight=False)
        records.append(FlightRecord.load(bag))
    return records


def main() -> None:
    """Fly, measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20, help="flights (default: 20)")
    parser.add_argument("--node", action="store_true", help="fly in real time, too, for the node's CPU share")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    if options.seeds < 1:
        parser.error(f"--seeds {options.seeds} is less than 1")
    told = Console(stderr=True)
    with tempfile.TemporaryDirectory() as folder:
        found = assess(fly(options.seeds, Path(folder), told))
    found["flights"] = [f"{PLAN}, seed {seed}" for seed in range(1, options.seeds + 1)]
    found["update_us"] = update_cost()
    found["node_shares"] = node_shares() if options.node else None
    if options.json:
        sys.stdout.write(json.dumps(found, indent=2) + "\n")
        return
    show(found)
    said = Console(highlight=False)
    said.print(f"one update in process: {found['update_us']:.1f} us (median)")
    if options.node:
        node, messages = (found["node_shares"][which] for which in ("node", "messages"))
        said.print(
            f"the node in real time at 400 Hz: {node:.1f} % of a core, its messages alone {messages:.1f} %"
        )


if __name__ == "__main__":
    main()
