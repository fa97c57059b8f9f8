"""Speed of the graph: lockstep and composed flights beside the middleware's own floor, and each node's share.

    python benchmarks/graph.py [--rounds 3] [--plan hover_steps]

The floor is a ping-pong of the same messages between as many processes, which compute nothing.
Every round flies and ping-pongs in turn, so that a machine that slows down does so for both.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from rich.console import Console
from rich.table import Table

from heli_common.timing import CONTROL_PERIOD_NS
from heli_control.controller_file import load_controller
from heli_flight.flying import fly
from heli_flight.order import FlightOrder, Mode
from heli_flight.plan import load_plan
from heli_flight.process_group import ProcessGroup
from heli_flight.process_table import environment, processes
from heli_flight.processor_time import processor_seconds
from heli_flight.progress import Progress

STEPS_PER_SECOND = 1e9 / CONTROL_PERIOD_NS
FLOOR = Path(__file__).with_name("ping_pong.py")
PATIENCE_SECONDS = 120.0
SETTLED = 8.0
"""Simulated seconds after which the flight goes at its own speed."""


class Watch:
    """Simulated and wall time, and what each child process has used, at the first and the last look."""

    def __init__(self) -> None:
        self.looks: list[tuple[float, float, dict[str, float]]] = []

    def tell(self, progress: Progress) -> None:
        """Look, if the flight has settled."""
        if progress.time >= SETTLED and not progress.state.ended:
            self.looks = [*self.looks[:1], (progress.time, perf_counter(), processor_seconds())]

    @property
    def speed(self) -> float:
        """Simulated seconds per second."""
        (first, began, _), (last, ended, _) = self.looks
        return (last - first) / (ended - began)

    @property
    def shares(self) -> dict[str, float]:
        """Processor time of each process per control step [ms]."""
        (first, _, before), (last, _, after) = self.looks
        steps = (last - first) * STEPS_PER_SECOND
        return {name: 1e3 * (after[name] - before[name]) / steps for name in after if name in before}


def flight(order: FlightOrder, mode: Mode, folder: Path) -> Watch:
    """Fly; the bag is left in the folder."""
    watch = Watch()
    end = fly(replace(order, mode=mode, bag=folder / mode.value), watch.tell, sys.stderr.write)
    if end.exit_code:
        raise SystemExit(f"{mode.value}: {end.reason}")
    return watch


def floor() -> float:
    """Ping-pong of the same messages, in simulated seconds per second."""
    nodes = [process.name for process in processes(identified=False)]
    commands = {
        name: [sys.executable, str(FLOOR), name, "--ros-args", "-p", f"running:={','.join(nodes)}"]
        for name in nodes
    }
    deadline = perf_counter() + PATIENCE_SECONDS
    with ProcessGroup(commands, environment()) as group:
        while perf_counter() < deadline:
            for line in group.read(0.1):
                if not line.is_error:
                    return float(line.text) / STEPS_PER_SECOND
                sys.stderr.write(line.text + "\n")
    raise SystemExit("ping-pong: did not come to an end")


def main() -> None:
    """Fly, ping-pong, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--plan", default="hover_steps")
    options = parser.parse_args()
    plan = load_plan(options.plan)
    controller = load_controller(plan.controller)
    order = FlightOrder(plan, options.plan, Mode.LOCKSTEP, plan.seed, controller, plan.controller, Path())
    speeds: dict[str, list[float]] = {"lockstep": [], "composed": [], "in process": [], "ping-pong": []}
    shares: list[dict[str, float]] = []
    for number in range(1, options.rounds + 1):
        sys.stderr.write(f"round {number} of {options.rounds}\n")
        with tempfile.TemporaryDirectory() as folder:
            lockstep = flight(order, Mode.LOCKSTEP, Path(folder))
            speeds["ping-pong"].append(floor())
            shares.append(lockstep.shares)
            speeds["lockstep"].append(lockstep.speed)
            speeds["composed"].append(flight(order, Mode.COMPOSED, Path(folder)).speed)
            speeds["in process"].append(flight(order, Mode.INPROCESS, Path(folder)).speed)
    say(speeds, shares)


def say(speeds: dict[str, list[float]], shares: list[dict[str, float]]) -> None:
    """Print the tables."""
    console = Console(highlight=False)
    table = Table("x real time, recorder on", "median", "lowest", "highest", "of the floor", box=None)
    for name, values in speeds.items():
        ratio = statistics.median(a / b for a, b in zip(values, speeds["ping-pong"], strict=True))
        row = (
            f"{statistics.median(values):.2f}",
            f"{min(values):.2f}",
            f"{max(values):.2f}",
            f"{100 * ratio:.0f} %",
        )
        table.add_row(name, *row)
    console.print(table)
    stages = Table("lockstep, node", "ms a control step", "share", box=None)
    middle = {name: statistics.median(each[name] for each in shares) for name in shares[0]}
    for name, value in sorted(middle.items(), key=lambda item: -item[1]):
        stages.add_row(name, f"{value:.2f}", f"{100 * value / sum(middle.values()):.0f} %")
    console.print(stages)


if __name__ == "__main__":
    main()
