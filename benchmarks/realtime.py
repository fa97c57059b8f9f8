"""Is a long flight in real time punctual? Late commands, latency, jitter and processor time of each node.

    python benchmarks/realtime.py [--minutes 10] [--cases fifo,fifo_loaded,...] [--json FILE]

Hovers as `heli fly` does, recorder on, with (`fifo`) and without (`plain`) real-time scheduling, on an idle
machine and with one busy process of ordinary priority for every core (`_loaded`); `composed` with all nodes
but the recorder in one process and with real-time scheduling. The bounds are those asked of real-time
scheduling; without it the same figures are printed and nothing is demanded. Exit code 1: a bound
is missed. Tables come after each case. docs/realtime.md says what to set and how to read the figures.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from graph import Watch
from rich.console import Console
from rich.table import Table

from heli_common.errors import EXIT_DIFFERENT, EXIT_FLOWN, EXIT_INTERRUPTED
from heli_common.files import write_atomically
from heli_flight.bag_reader import read_bag
from heli_flight.cli.live import LiveProgress
from heli_flight.cli.planned import planned_order
from heli_flight.flight_hash import count_check
from heli_flight.flying import fly
from heli_flight.machine_load import every_core_busy
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.process_table import PROCESSES, environment
from heli_flight.progress import Progress
from heli_flight.punctuality import PERIOD, punctuality, spoken

LATENCY_BOUND_MS, JITTER_BOUND_MS = 5.0, 1.0
"""What 99.9 % of the commands and of the control periods must stay below with real-time scheduling."""

PULSE, PULSE_SECONDS = Path(__file__).with_name("pulse.py"), 30.0

FIGURES = ("median_ms", "p99_ms", "p99_9_ms", "max_ms")

PLAN = """
name: long_hover
about: Hover for a long time; what benchmarks/realtime.py flies.
seed: 1
controller: lq
phases:
  - home: {}
  - run_up: {}
  - take_off: {height: 0.0}
"""


@dataclass(frozen=True)
class Case:
    """How a flight is flown.

    Attributes:
        scheduled: with real-time scheduling.
        loaded: with every core busy.
        mode: way of running.
    """

    scheduled: bool
    loaded: bool
    mode: Mode = Mode.REALTIME


CASES = {
    "fifo": Case(True, False),
    "fifo_loaded": Case(True, True),
    "composed": Case(True, False, Mode.REALTIME_COMPOSED),
    "composed_loaded": Case(True, True, Mode.REALTIME_COMPOSED),
    "plain": Case(False, False),
    "plain_loaded": Case(False, True),
}


@dataclass(frozen=True)
class Found:
    """What a flight showed.

    Attributes:
        minutes: length of the flight, simulated.
        ended: why it was stopped, empty if it was flown to its end.
        scheduled: whether real-time scheduling was asked for and permitted.
        late: late commands by topic.
        lost: messages that are not in the bag.
        paused_s: for how long the bench itself was kept from running [s].
        punctuality: median, quantiles and maximum by subject [ms], see `heli_flight.punctuality`.
        shares: processor time of each node [% of a core].
        machine: jitter of a bare loop of the same period and load, before the flight [ms].
        stolen_s: for how long the host of a virtual machine let its cores wait, all together [s].
    """

    minutes: float
    ended: str
    scheduled: bool
    late: dict[str, int]
    lost: int
    paused_s: float
    punctuality: dict[str, dict[str, float]]
    shares: dict[str, float]
    machine: dict[str, float]
    stolen_s: float

    def missed(self) -> list[str]:
        """Bounds of real-time scheduling that the flight has missed."""
        missed = [f"stopped: {self.ended}"] if self.ended else []
        missed += [f"{count} late {topic}" for topic, count in self.late.items() if count]
        if self.lost:
            missed.append(f"{self.lost} messages lost")
        if self.paused_s:
            missed.append(f"bench kept from running for {self.paused_s:.3f} s")
        for subject, figures in self.punctuality.items():
            bound = JITTER_BOUND_MS if subject == PERIOD else LATENCY_BOUND_MS
            if figures["p99_9_ms"] >= bound:
                missed.append(f"{subject} 99.9 % {figures['p99_9_ms']:.2f} ms, not below {bound:.0f} ms")
        return missed


def bare_jitter(case: Case) -> dict[str, float]:
    """Jitter of a loop that computes nothing [ms]: what the machine itself costs."""
    priority = PROCESSES[0].priority if case.scheduled else 0
    words = [sys.executable, str(PULSE), str(PULSE_SECONDS), str(priority)]
    with every_core_busy(case.loaded):
        said = subprocess.run(words, env=environment(), stdout=subprocess.PIPE, text=True, check=True).stdout
    figures: dict[str, float] = json.loads(said)
    return figures


def stolen_seconds() -> float:
    """Time so far in which the host of a virtual machine ran something else on our cores [s]."""
    words = Path("/proc/stat").read_text().splitlines()[0].split()
    return int(words[8]) / os.sysconf("SC_CLK_TCK")


def plan_text(minutes: float) -> str:
    """The plan file of a hover of so many minutes."""
    return f"{PLAN.lstrip()}  - hover: {{duration: {60.0 * minutes!r}}}\n  - land: {{}}\n  - run_down: {{}}\n"


def flown(order: FlightOrder, case: Case, title: str) -> Found:
    """Fly a case.

    Raises:
        KeyboardInterrupt: while flying.
        SystemExit: no bag was left.
    """
    order = replace(order, mode=case.mode, real_time_scheduling=case.scheduled)
    watch, warnings, machine = Watch(), [], bare_jitter(case)
    stolen_before = stolen_seconds()
    with every_core_busy(case.loaded), LiveProgress(order.plan.duration, quiet=False) as live:
        live.warn(title)

        def tell(progress: Progress) -> None:
            live.show(progress)
            watch.tell(progress)

        def warn(text: str) -> None:
            live.warn(text)
            warnings.append(text)

        end = fly(order, tell, warn)
    stolen = stolen_seconds() - stolen_before
    if end.exit_code == EXIT_INTERRUPTED:
        raise KeyboardInterrupt
    if not (order.bag / "metadata.yaml").is_file():
        raise SystemExit(f"{title}: {end.reason or 'left no bag'}")
    bag = read_bag(order.bag)
    remarks = bag.custom_data
    late = {key.removeprefix("late_"): int(text) for key, text in remarks.items() if key.startswith("late_")}
    return Found(
        minutes=round(end.simulated_seconds / 60.0, 2),
        ended="" if end.exit_code == EXIT_FLOWN else end.reason,
        scheduled=case.scheduled and not any("SCHED_FIFO" in text for text in warnings),
        late=late,
        lost=sum(count.lost for count in count_check(bag)),
        paused_s=float(remarks.get("paused_s", 0.0)),
        punctuality=punctuality(remarks),
        shares=watch.percent,
        machine=machine,
        stolen_s=round(stolen, 2),
    )


def verdict(case: Case, found: Found) -> tuple[bool, str]:
    """Whether nothing that is demanded is missed, and in words."""
    missed = found.missed()
    if case.scheduled and not found.scheduled:
        missed.insert(0, "real-time scheduling is not permitted here")
    held = not missed or not case.scheduled
    word = "held" if not missed else "MISSED" if case.scheduled else "missed, as nothing is demanded"
    return held, f"{word}: {'; '.join(missed) or 'all bounds'}"


def say(name: str, case: Case, found: Found) -> None:
    """Print the tables of a case."""
    console = Console(highlight=False)
    console.print(f"\n{name}: {found.minutes:.1f} min", style="bold")
    late = ", ".join(f"{topic} {count}" for topic, count in found.late.items())
    console.print(f"late commands: {late}; lost messages {found.lost}; paused {found.paused_s:.3f} s")
    console.print(f"cores waited for the host for {found.stolen_s:.2f} s, all together")
    table = Table("ms", box=None, pad_edge=False)
    for title in ("median", "99 %", "99.9 %", "max"):
        table.add_column(title, justify="right")
    for subject, figures in found.punctuality.items():
        table.add_row(spoken(subject), *(f"{figures[each]:.2f}" for each in FIGURES))
    table.add_row("bare loop before", *(f"{found.machine[each]:.2f}" for each in FIGURES))
    console.print(table)
    nodes = Table("node", box=None, pad_edge=False)
    nodes.add_column("% of a core", justify="right")
    for node, share in sorted(found.shares.items(), key=lambda item: -item[1]):
        nodes.add_row(node, f"{share:.1f}")
    nodes.add_row("all", f"{sum(found.shares.values()):.1f}")
    console.print(nodes)
    console.print(verdict(case, found)[1])


@contextlib.contextmanager
def place(kept: Path | None) -> Iterator[Path]:
    """A folder for bags, which goes at the end unless it is asked for."""
    if kept is not None:
        kept.mkdir(parents=True, exist_ok=True)
        yield kept.absolute()
        return
    with tempfile.TemporaryDirectory(prefix="heli_realtime_") as folder:
        yield Path(folder)


def as_object(results: dict[str, Found]) -> dict[str, Any]:
    """Everything, ready for JSON."""
    said = {}
    for name, found in results.items():
        held, words = verdict(CASES[name], found)
        said[name] = {**asdict(found), "held": held, "verdict": words}
    return {"bounds_ms": {"latency": LATENCY_BOUND_MS, PERIOD: JITTER_BOUND_MS}, "cases": said}


def main() -> int:
    """Fly, print; returns the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=10.0, help="of hover (10)")
    parser.add_argument("--cases", default=",".join(CASES), help="comma-separated")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write everything after each case")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="keep the bags here")
    options = parser.parse_args()
    names = [name.strip() for name in options.cases.split(",") if name.strip()]
    if unknown := [name for name in names if name not in CASES]:
        parser.error(f"--cases: {unknown[0]!r} (allowed: {', '.join(CASES)})")
    if not 0.1 <= options.minutes <= 60.0:
        parser.error(f"--minutes: {options.minutes} (allowed: 0.1 .. 60)")
    for interrupt in (signal.SIGINT, signal.SIGTERM):  # a shell's background has SIGINT ignored
        signal.signal(interrupt, signal.default_int_handler)
    results: dict[str, Found] = {}
    try:
        with place(options.out) as folder:
            file = folder / "long_hover.yaml"
            file.write_text(plan_text(options.minutes))
            order = planned_order(str(file), None, None)
            for number, name in enumerate(names, start=1):
                title = f"{name}, case {number} of {len(names)}"
                results[name] = flown(replace(order, bag=folder / name), CASES[name], title)
                say(name, CASES[name], results[name])
                if options.json:
                    write_atomically(options.json, json.dumps(as_object(results), indent=2) + "\n")
    except KeyboardInterrupt:
        sys.stderr.write(f"interrupted; {len(results)} of {len(names)} cases flown\n")
        return EXIT_INTERRUPTED
    held = all(verdict(CASES[name], found)[0] for name, found in results.items())
    return EXIT_FLOWN if held else EXIT_DIFFERENT


if __name__ == "__main__":
    sys.exit(main())
