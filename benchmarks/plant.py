"""How fast the bench flies: simulated seconds per CPU second on one core, beside two published simulators.

Run: python benchmarks/plant.py [--json] [--repeats N] [--peers PYTHON]. The peers need an environment of
their own (docs/decisions/0004-benchmark-peers.md); without them the table says how to get them. All rows are
measured in turn, round by round, so that a slow moment of the machine hits all of them.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from heli_bench_sim import helicopter
from heli_bench_sim.bench import REFINEMENT, Bench
from heli_bench_sim.bench_parameters import bench_constants
from heli_bench_sim.motion import AIR_SIZE, FLYING_STEPS, WORK_ROWS, advance_batch
from heli_bench_sim.parameters import Constants, constants
from heli_bench_sim.states import STATE_SIZE, State
from heli_bench_sim.trim import trim
from heli_common.compiled import compiled
from heli_common.records import boxed
from heli_common.timing import CONTROL_PERIOD_NS, SENSOR_PERIOD, SENSOR_PERIOD_NS

Array = NDArray[np.float64]

BATCH = 1_000
"""Benches in the batch."""

FLIGHT = 2.5
"""Simulated time of one measurement [s]; from trim with some speed, so that friction and rotor have work."""

SIMULATED, STEPS = "simulated s per CPU s", "bench-steps per CPU s"

PEERS = {"jsbsim": "JSBSim ah1s at 400 Hz", "rotorpy": "RotorPy quadrotor at 400 Hz"}

PEER_PYTHON = "HELI_PEER_PYTHON"
"""Environment variable with the Python that has the peers."""

HOW_TO_INSTALL = (
    "python3 -m venv peers && peers/bin/pip install jsbsim rotorpy, then --peers peers/bin/python "
    f"or {PEER_PYTHON}=peers/bin/python"
)


@dataclass
class Measured:
    """One row: as many figures as rounds."""

    what: str
    unit: str
    figures: list[float] = field(default_factory=list)
    note: str = ""

    @property
    def median(self) -> float | None:
        """The middle one, or None if nothing was measured."""
        return median(self.figures) if self.figures else None


@compiled
def fly_helicopter(
    state: Array, inputs: Array, still: Array, step: float, steps: int, c: Constants, slopes: Array
) -> None:
    """The helicopter alone, classical Runge-Kutta of fourth order, in place.

    Args:
        state: (18,), overwritten.
        inputs: (5,) held.
        still: (3,) zeros: wind, further force, further moment.
        step: of the integration [s].
        steps: how many.
        c: constants of the helicopter.
        slopes: (5, 18) working memory.
    """
    first, second, third, fourth, trial = slopes[0], slopes[1], slopes[2], slopes[3], slopes[4]
    for _ in range(steps):
        helicopter.derivative(state, inputs, still, still, still, c, first)
        for index in range(STATE_SIZE):
            trial[index] = state[index] + 0.5 * step * first[index]
        helicopter.derivative(trial, inputs, still, still, still, c, second)
        for index in range(STATE_SIZE):
            trial[index] = state[index] + 0.5 * step * second[index]
        helicopter.derivative(trial, inputs, still, still, still, c, third)
        for index in range(STATE_SIZE):
            trial[index] = state[index] + step * third[index]
        helicopter.derivative(trial, inputs, still, still, still, c, fourth)
        for index in range(STATE_SIZE):
            slope = first[index] + 2.0 * (second[index] + third[index]) + fourth[index]
            state[index] += step / 6.0 * slope


class Flights:
    """The three measurements of this project."""

    def __init__(self) -> None:
        self.bench = Bench()
        self.helicopter = constants(self.bench.parameters.helicopter)
        self.box = boxed(bench_constants(self.bench.parameters))
        hover = trim(self.bench.parameters.helicopter)
        self.inputs, self.state = hover.inputs, hover.state
        self.state[[State.u, State.v]] = 0.3, -0.2
        self.bench.place(self.state, self.inputs)
        self.command, self.whole = self.bench.command, self.bench.whole_state
        self.still, self.slopes = np.zeros(3), np.empty((5, STATE_SIZE))

    def plant(self) -> float:
        """The helicopter's equations of motion alone, in compiled code, at the bench's integration step."""
        flights, step = 40, SENSOR_PERIOD / (REFINEMENT * FLYING_STEPS)
        steps = round(FLIGHT / step)
        begin = time.process_time()
        for _ in range(flights):
            state = self.state.copy()
            fly_helicopter(state, self.inputs, self.still, step, steps, self.helicopter, self.slopes)
        used = time.process_time() - begin
        self._must_be_finite(state)
        return flights * FLIGHT / used

    def sensors(self) -> float:
        """The bench with rig, servos, drive, air and every sensor at 400 Hz; commands held for 10 ms."""
        bench, together = self.bench, CONTROL_PERIOD_NS // SENSOR_PERIOD_NS
        bench.place(self.state, self.inputs)
        begin = time.process_time()
        for _ in range(round(FLIGHT / SENSOR_PERIOD) // together):
            bench.run(together)
        used = time.process_time() - begin
        self._must_be_finite(bench.whole_state)
        return FLIGHT / used

    def batch(self) -> float:
        """Many benches at once, one sensor period after the other."""
        states, commands = np.tile(self.whole, (BATCH, 1)), np.tile(self.command, (BATCH, 1))
        states[:, State.u] = np.linspace(-0.5, 0.5, BATCH)
        airs, periods = np.zeros((BATCH, AIR_SIZE)), 40
        work = np.empty((WORK_ROWS, states.shape[1]))
        begin = time.process_time()
        for _ in range(periods):
            advance_batch(states, commands, airs, SENSOR_PERIOD, REFINEMENT, self.box, work)
        used = time.process_time() - begin
        self._must_be_finite(states)
        return periods * BATCH / used

    @staticmethod
    def _must_be_finite(state: Array) -> None:
        if not np.isfinite(state).all():
            raise FloatingPointError("the flight left the model; its speed means nothing")


@contextmanager
def peers(python: str) -> Iterator[Callable[[str], dict[str, Any]]]:
    """Another Python that measures a peer by name each time it is asked."""
    script = Path(__file__).with_name("peers.py")
    process = subprocess.Popen(
        [python, str(script)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
    )
    assert process.stdin is not None and process.stdout is not None
    asked, answered = process.stdin, process.stdout

    def ask(name: str) -> dict[str, Any]:
        try:
            asked.write(f"{name}\n")
            asked.flush()
            line = answered.readline()
        except OSError:
            line = ""
        if not line:
            return {"missing": f"{python} ended"}
        answer: dict[str, Any] = json.loads(line)
        return answer

    try:
        yield ask
    finally:
        process.communicate()


def measure(repeats: int, peer_python: str) -> list[Measured]:
    """All rows, in turn, after one round that compiles and warms up.

    Args:
        repeats: rounds that count.
        peer_python: interpreter that has the peers.
    """
    flights = Flights()
    ours = (
        (Measured("plant alone", SIMULATED), flights.plant),
        (Measured("plant with rig and sensors at 400 Hz", SIMULATED), flights.sensors),
        (Measured(f"{BATCH:,} benches as a batch", STEPS), flights.batch),
    )
    theirs = {name: Measured(text, SIMULATED) for name, text in PEERS.items()}
    with peers(peer_python) as ask:
        for turn in range(repeats + 1):
            for row, fly in ours:
                speed = fly()
                if turn:
                    row.figures.append(speed)
            for name, row in theirs.items():
                answer = ask(name)
                row.note = answer.get("missing") or f"{name} {answer['version']}, {answer['flight']}"
                if turn and "missing" not in answer:
                    row.figures.append(answer["simulated_s_per_cpu_s"])
    return [*(row for row, _ in ours), *theirs.values()]


def show(rows: list[Measured], repeats: int, console: Console) -> None:
    """Print the table, what is missing, and how the bench compares."""
    title = f"{repeats} rounds in turn, one core, Python {platform.python_version()}"
    table = Table("what", "median", "lowest", "highest", "unit", title=title)
    for row in rows:
        cells = [f"{value:,.4g}" if value < 1e4 else f"{value:,.0f}" for value in _three(row)]
        table.add_row(row.what, *(cells or ["not installed", "", ""]), row.unit)
    console.print(table)
    bench = rows[1].median
    for row in rows[3:]:
        if row.median and bench:
            console.print(f"bench : {row.what} = {bench / row.median:.3g} ({row.note})", highlight=False)
        else:
            console.print(f"{row.what}: {row.note}", highlight=False)
    if not all(row.figures for row in rows):
        console.print(f"to install the peers: {HOW_TO_INSTALL}", highlight=False)


def _three(row: Measured) -> list[float]:
    return [median(row.figures), min(row.figures), max(row.figures)] if row.figures else []


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--repeats", type=int, default=7, help="rounds that count (default: 7)")
    parser.add_argument(
        "--peers",
        metavar="PYTHON",
        default=os.environ.get(PEER_PYTHON, sys.executable),
        help=f"Python that has jsbsim and rotorpy (default: {PEER_PYTHON}, else this one)",
    )
    options = parser.parse_args()
    if options.repeats < 1:
        parser.error(f"--repeats {options.repeats} is less than 1")
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    try:
        rows = measure(options.repeats, options.peers)
    except FileNotFoundError:
        parser.error(f"--peers {options.peers}: there is no such program")
    if options.json:
        mapping = [asdict(row) | {"median": row.median} for row in rows]
        sys.stdout.write(json.dumps(mapping, indent=2) + "\n")
    else:
        console = Console()
        show(rows, options.repeats, console if console.is_terminal else Console(width=110))


if __name__ == "__main__":
    main()
