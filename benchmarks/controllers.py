"""The five flight controllers on the same plans, seed and room, in any way of running.

Run: python benchmarks/controllers.py [--plans P,P] [--controllers C,C] [--modes M,M] [--seed N] [--json].
Each controller flies from its shipped file; `heli fly` does it, so in lockstep and in real time every node is
a process of its own. The same plan, seed and controller have one hash in every way of running that lost
nothing.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from math import degrees
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.table import Table

CONTROLLERS = ("lq", "gst", "gst2", "ncf", "ncf2")
PLANS = ("hover_steps", "hover")


def fly(plan: str, controller: str, mode: str, seed: int | None) -> dict[str, Any]:
    """What `heli fly --json` says of one flight."""
    words = [
        "fly",
        plan,
        "--controller",
        controller,
        "--mode",
        mode,
        "--no-report",
        "--json",
        "--name",
        "one",
    ]
    if seed is not None:
        words += ["--seed", str(seed)]
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-m", "heli_flight.cli.main", *words, "--out", folder],
            capture_output=True,
            text=True,
            check=False,
        )
    if not done.stdout:
        raise SystemExit(f"{plan}, {controller}, {mode}: {done.stderr.strip()}")
    said: dict[str, Any] = json.loads(done.stdout)
    return said | {"plan": plan, "controller": controller, "mode": mode}


def columns(flight: dict[str, Any]) -> list[str]:
    """One row of the table."""
    metrics = flight["metrics"]
    hover = metrics["hover"][0] if metrics["hover"] else None
    sigma = "-"
    if hover:
        sizes = [100.0 * hover[f"sigma_{axis}_m"] for axis in "xyz"]
        sigma = " ".join(f"{size:.2f}" for size in sizes) + f" {degrees(hover['sigma_psi_rad']):.2f}"
    steps = " ".join(
        f"{step['rise_time_s']:.2f}/{step['overshoot_percent']:.0f}"
        for step in metrics["steps"]
        if step["rise_time_s"] is not None
    )
    late = sum(flight["late_commands"].values())
    speed = flight["simulated_s"] / max(flight["wall_s"], 1e-9)
    return [
        flight["plan"],
        flight["controller"],
        flight["mode"],
        flight["ended"],
        sigma,
        steps,
        f"{late}, {flight['lost_messages']}",
        f"{speed:.1f}",
        flight["sha256"][:12],
    ]


def main() -> None:
    """Fly and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--plans", default=",".join(PLANS), help="comma-separated")
    parser.add_argument("--controllers", default=",".join(CONTROLLERS), help="comma-separated")
    parser.add_argument("--modes", default="inprocess", help="of inprocess, lockstep, realtime")
    parser.add_argument("--seed", type=int, help="of every random number (default: the plan's)")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    options = parser.parse_args()
    told = Console(stderr=True, highlight=False)
    jobs = [
        (plan, controller, mode)
        for plan in options.plans.split(",")
        for controller in options.controllers.split(",")
        for mode in options.modes.split(",")
    ]
    flights: list[dict[str, Any]] = []
    begin = perf_counter()
    for number, job in enumerate(jobs, 1):
        flights.append(fly(*job, options.seed))
        left = (perf_counter() - begin) / number * (len(jobs) - number)
        told.print(
            f"{' '.join(job)}: {flights[-1]['ended']} ({number} of {len(jobs)}, about {left:.0f} s left)"
        )
    if options.json:
        sys.stdout.write(json.dumps(flights, indent=2) + "\n")
        return
    table = Table(
        "plan", "controller", "way", "ended", "sigma x y z [cm] psi [deg]", "steps: rise [s]/overshoot [%]",
        "late, lost", "x real time", "sha256",
    )  # fmt: skip
    for flight in flights:
        table.add_row(*columns(flight))
    Console(highlight=False, width=170).print(table)


if __name__ == "__main__":
    main()
