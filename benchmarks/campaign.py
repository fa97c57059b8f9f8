"""A thousand flights of 20 s with full sensors, navigation, control: time, and the same file on any workers.

Run: python benchmarks/campaign.py [--flights N] [--workers 1 2] [--dask] [--kill] [--json]. Every row is one
`heli campaign` as a process of its own, start included. `--kill` kills one at half and goes on; `--dask`
flies on a cluster of two workers on loopback. The last table says where the time of a flight goes.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_control.controller_file import load_controller
from heli_flight.campaign import JOURNAL
from heli_flight.campaign_draws import draw
from heli_flight.campaign_results import TABLE
from heli_flight.plan import load_plan
from heli_flight.swift_flight import SwiftFlight
from heli_flight.vary_file import parse_vary

PLAN = "campaign_hover"
VARY = """\
wind_m_s: {uniform: [0.0, 2.0]}
parameters:
  bench_sim:
    helicopter.mass: {normal: [1.0, 0.02], times_default: true}
    imu.gyro_noise: {log_uniform: [0.5, 2.0], times_default: true}
"""


@dataclass
class Flown:
    """One campaign."""

    how: str
    wall_s: float
    cpu_s: float
    sha256: str


def command(folder: Path, vary: Path, flights: int, *more: str) -> list[str]:
    """`heli campaign` as a process."""
    words = ["campaign", PLAN, "--flights", str(flights), "--vary", str(vary), "--out", str(folder)]
    return [sys.executable, "-m", "heli_flight.cli.main", *words, *more]


def flown(how: str, folder: Path, vary: Path, flights: int, *more: str) -> Flown:
    """Fly a campaign to its end."""
    begin, used = time.perf_counter(), children()
    subprocess.run(command(folder, vary, flights, *more, "--json"), check=True, stdout=subprocess.DEVNULL)
    wall, used = time.perf_counter() - begin, children() - used
    return Flown(how, wall, used, hashlib.sha256((folder / TABLE).read_bytes()).hexdigest())


def children() -> float:
    """Processor time of all processes that have ended [s]; those of a cluster are not among them."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def killed(folder: Path, vary: Path, flights: int, *more: str) -> None:
    """Fly a campaign and kill it when half of it is flown."""
    process = subprocess.Popen(command(folder, vary, flights, *more), stderr=subprocess.DEVNULL)
    while process.poll() is None:
        journal = folder / JOURNAL
        if journal.exists() and journal.read_text().count("\n") > flights // 2:
            os.kill(process.pid, signal.SIGKILL)
            break
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(0.05)
    process.wait()


def shares(flights: int) -> list[tuple[str, float]]:
    """Processor time per control period [us] of each stage of a flight, by what the calls take."""
    vary, plan, controller = parse_vary(VARY), load_plan(PLAN), load_controller("lq")
    spent: dict[str, float] = {}
    periods, total = 0, 0.0

    def timed(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def run(*given: Any) -> Any:
            begin = time.perf_counter()
            result = call(*given)
            spent[name] = spent.get(name, 0.0) + time.perf_counter() - begin
            return result

        return run

    for number in range(flights):
        drawn = draw(plan, vary, number)
        flight: Any = SwiftFlight(drawn.plan, drawn.plan.seed, controller, drawn.values)
        flight.bench.run = timed("bench and sensors", flight.bench.run)
        flight._filter.run = timed("navigation", flight._filter.run)
        flight._seen = timed("odometry", flight._seen)
        flight.leader.act = timed("supervisor", flight.leader.act)
        flight._control.step = timed("controllers", flight._control.step)
        begin = time.perf_counter()
        log = flight.fly()
        total += time.perf_counter() - begin
        periods += len(log.state)
    rows = [(name, 1e6 * seconds / periods) for name, seconds in spent.items()]
    whole = 1e6 * total / periods
    return [*rows, ("the rest", whole - sum(value for _, value in rows)), ("a control period", whole)]


def measure(options: argparse.Namespace, folder: Path) -> list[Flown]:
    """All campaigns asked for, one after the other."""
    vary, flights = folder / "vary.yaml", options.flights
    vary.write_text(VARY)
    rows = [
        flown(f"{workers} worker(s)", folder / f"workers_{workers}", vary, flights, "--workers", str(workers))
        for workers in options.workers
    ]
    if options.kill:
        killed(folder / "killed", vary, flights, "--workers", "2")
        rows.append(flown("killed at half, the rest", folder / "killed", vary, flights, "--workers", "2"))
    if options.dask:
        from distributed import LocalCluster

        with LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster:
            address = cluster.scheduler_address
            rows.append(flown("dask, 2 workers", folder / "dask", vary, flights, "--dask", address))
    return rows


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--flights", type=int, default=1000)
    parser.add_argument("--workers", type=int, nargs="*", default=[1, 2])
    parser.add_argument("--kill", action="store_true", help="kill one at half and go on")
    parser.add_argument("--dask", action="store_true", help="fly on a dask cluster on loopback, too")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = measure(options, Path(folder))
    parts = shares(3)
    if options.json:
        sys.stdout.write(
            json.dumps({"campaigns": [asdict(row) for row in rows], "us": parts}, indent=2) + "\n"
        )
        return
    console = Console(highlight=False, width=110)
    table = Table(
        "campaign", "s", "CPU s", "flights/s", "sha256", title=f"{options.flights} flights of {PLAN}"
    )
    for row in rows:
        table.add_row(
            row.how,
            f"{row.wall_s:.1f}",
            f"{row.cpu_s:.1f}",
            f"{options.flights / row.wall_s:.1f}",
            row.sha256[:16],
        )
    console.print(table)
    console.print("the same file" if len({row.sha256 for row in rows}) <= 1 else "files differ")
    table = Table("stage", "us", title="one control period: 4 sensor samples, navigation, control")
    for name, value in parts:
        table.add_row(name, f"{value:.1f}")
    console.print(table)


if __name__ == "__main__":
    main()
