"""Speed of the graph: lockstep and composed flights beside the middleware's own floor, and each node's share.

    python benchmarks/graph.py [--rounds 3] [--plan hover_steps] [--ordinary]

The floor is a ping-pong of the same messages between as many processes, or in one, which compute nothing.
Every round flies and ping-pongs in turn, so that a machine that slows down does so for both. --ordinary
leaves out SCHED_FIFO, as on a machine that does not permit it.
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

from heli_common.flight_state import FlightState
from heli_common.timing import CONTROL_PERIOD_NS
from heli_control.controller_file import load_controller
from heli_flight.flying import fly
from heli_flight.mode import COMPOSED_PROCESS, Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import load_plan
from heli_flight.process_group import ProcessGroup
from heli_flight.process_table import environment, processes, usable_cores
from heli_flight.processor_time import node_of, processor_seconds
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
        """Look when the flight has settled and when it lands, and leave it alone in between."""
        if progress.time >= SETTLED and (not self.looks or self._lands(progress)):
            self.look(progress.time)

    def _lands(self, progress: Progress) -> bool:
        return len(self.looks) == 1 and progress.state in (FlightState.LANDING, FlightState.RUN_DOWN)

    def look(self, time: float) -> None:
        """Note what has been used up to a simulated time [s]."""
        self.looks = [*self.looks[:1], (time, perf_counter(), processor_seconds(_program))]

    @property
    def speed(self) -> float:
        """Simulated seconds per second."""
        (first, began, _), (last, ended, _) = self.looks
        return (last - first) / (ended - began)

    @property
    def shares(self) -> dict[str, float]:
        """Processor time of each process per control step [ms]; empty if the flight was too short."""
        if len(self.looks) < 2:
            return {}
        (first, _, before), (last, _, after) = self.looks
        steps = (last - first) * STEPS_PER_SECOND
        return {name: 1e3 * (after[name] - before[name]) / steps for name in after if name in before}

    @property
    def percent(self) -> dict[str, float]:
        """The same of a flight in real time [% of a core]."""
        return {name: round(0.1 * STEPS_PER_SECOND * share, 2) for name, share in self.shares.items()}


def _program(words: list[str]) -> str:
    """Name of the node that a command line runs, empty for none."""
    return words[words.index(str(FLOOR)) + 1] if str(FLOOR) in words else node_of(words)


def flight(order: FlightOrder, mode: Mode, folder: Path) -> Watch:
    """Fly; the bag is left in the folder."""
    watch = Watch()
    order = replace(order, mode=mode, bag=folder / mode.value)
    end = fly(order, watch.tell, lambda text: sys.stderr.writelines([text, "\n"]))
    if end.exit_code:
        raise SystemExit(f"{mode.value}: {end.reason}")
    return watch


def floor(mode: Mode, scheduled: bool) -> Watch:
    """Ping-pong of the same messages; in real time they come by the clock."""
    nodes = processes(identified=False)
    paced = mode is Mode.REALTIME
    commands = {}
    for node in [nodes[0]] if mode is Mode.COMPOSED else nodes:
        name = COMPOSED_PROCESS if mode is Mode.COMPOSED else node.name
        settings: dict[str, str | int] = {"running": ",".join(each.name for each in nodes)}
        if scheduled:
            settings |= node.scheduling(paced, () if mode is Mode.COMPOSED else usable_cores())
        settings |= {"paced": int(paced)} if node is nodes[0] else {}
        words = [word for key, value in settings.items() for word in ("-p", f"{key}:={value}")]
        commands[name] = [sys.executable, str(FLOOR), name, "--ros-args", *words]
    watch, deadline = Watch(), perf_counter() + PATIENCE_SECONDS
    with ProcessGroup(commands, environment()) as group:
        while perf_counter() < deadline:
            for line in group.read(0.1):
                if line.is_error:
                    sys.stderr.write(line.text + "\n")
                    continue
                watch.look(float(line.text))
                if len(watch.looks) == 2:
                    return watch
    raise SystemExit("ping-pong: did not come to an end")


def main() -> None:
    """Fly, ping-pong, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--plan", default="hover_steps")
    parser.add_argument("--ordinary", action="store_true", help="without SCHED_FIFO")
    options = parser.parse_args()
    plan = load_plan(options.plan)
    controller = load_controller(plan.controller)
    order = FlightOrder(plan, options.plan, Mode.LOCKSTEP, plan.seed, controller, plan.controller, Path())
    order = replace(order, real_time_scheduling=not options.ordinary)
    rounds: list[dict[str, Watch]] = []
    for number in range(1, options.rounds + 1):
        sys.stderr.write(f"round {number} of {options.rounds}\n")
        seen: dict[str, Watch] = {}
        with tempfile.TemporaryDirectory() as folder:
            for mode in (Mode.LOCKSTEP, Mode.COMPOSED):
                seen[mode.value] = flight(order, mode, Path(folder))
                seen[f"ping-pong, {mode.value}"] = floor(mode, order.real_time_scheduling)
            seen[Mode.INPROCESS.value] = flight(order, Mode.INPROCESS, Path(folder))
        rounds.append(seen)
    say(rounds)


def say(rounds: list[dict[str, Watch]]) -> None:
    """Print the tables."""
    console = Console(highlight=False)
    table = Table("x real time, recorder on", "median", "lowest", "highest", "of its floor", box=None)
    for name in rounds[0]:
        values = [seen[name].speed for seen in rounds]
        row = [name, f"{statistics.median(values):.2f}", f"{min(values):.2f}", f"{max(values):.2f}"]
        if (below := f"ping-pong, {name}") in rounds[0]:
            row.append(
                f"{100 * statistics.median(seen[name].speed / seen[below].speed for seen in rounds):.0f} %"
            )
        table.add_row(*row)
    console.print(table)
    middle, bare = (_shares(rounds, name) for name in ("lockstep", "ping-pong, lockstep"))
    stages = Table("lockstep, node", "ms a control step", "share", "messages alone [ms]", box=None)
    for name, value in sorted(middle.items(), key=lambda item: -item[1]):
        share = f"{100 * value / sum(middle.values()):.0f} %"
        stages.add_row(name, f"{value:.2f}", share, f"{bare[name]:.2f}")
    stages.add_row("all", f"{sum(middle.values()):.2f}", "", f"{sum(bare.values()):.2f}")
    console.print(stages)


def _shares(rounds: list[dict[str, Watch]], flown: str) -> dict[str, float]:
    """Median of each node's processor time per control step [ms]."""
    each = [seen[flown].shares for seen in rounds]
    return {name: statistics.median(share[name] for share in each) for name in each[0]}


if __name__ == "__main__":
    main()
