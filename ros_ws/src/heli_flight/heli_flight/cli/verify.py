"""`heli verify`: does a plan give the same bytes in every way of running?"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

from heli_common.errors import EXIT_DIFFERENT, EXIT_FLOWN, EXIT_SAFETY_STOP, InputError
from heli_flight.cli.limits import require_between
from heli_flight.cli.live import LiveProgress
from heli_flight.cli.planned import planned_order
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.verification import REPRODUCIBLE, Flown, Run, differences, fly_run, runs

MOST_TIMES = 20
_WAYS = ",".join(mode.value for mode in REPRODUCIBLE)


def add_parser(words: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the word to the command."""
    verify = words.add_parser(
        "verify",
        help="whether a plan gives the same bytes in every way of running",
        description="Fly a plan in several ways and compare the hashes; exit code 1 if they differ.",
    )
    verify.add_argument("plan", nargs="?", default="short_hover", help="shipped plan or path of a plan file")
    verify.add_argument("--seed", type=int, help="seed of every random number (default: the plan's)")
    verify.add_argument("--modes", default=_WAYS, metavar="A,B", help=f"ways of running (default: {_WAYS})")
    verify.add_argument("--times", type=int, default=2, help="flights of each without load (default: 2)")
    verify.add_argument("--no-load", action="store_true", help="no further flight with every core busy")
    verify.add_argument("--params-file", type=Path, help="ROS 2 parameter file for the nodes")
    verify.add_argument("--out", type=Path, help="folder to keep the bags in (default: kept if they differ)")
    verify.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    verify.set_defaults(func=run)


def run(options: argparse.Namespace) -> int:
    """Fly and compare; returns the exit code.

    Raises:
        InputError: plan, seed, parameters or a way of running is not allowed.
    """
    order = planned_order(options.plan, options.seed, options.params_file)
    require_between(options.times, 1, MOST_TIMES, "--times")
    wanted = runs(_modes(options.modes), options.times, not options.no_load)
    folder = options.out.absolute() if options.out else Path(tempfile.mkdtemp(prefix="heli_verify_"))
    kept = options.out is not None
    try:
        flown = [
            _flown(order, each, folder, f"flight {number} of {len(wanted)}", options.json)
            for number, each in enumerate(wanted, start=1)
        ]
        found = [(other, str(first)) for other, first in differences(flown)]
        _say(flown, found, options.json)
        kept = kept or bool(found)
    except RuntimeError as error:
        sys.stderr.write(f"heli verify: {error}\n")
        return EXIT_SAFETY_STOP
    finally:
        if not kept:
            shutil.rmtree(folder, ignore_errors=True)
    if found:
        sys.stderr.write(f"bags {folder}\n")
    return EXIT_DIFFERENT if found else EXIT_FLOWN


def _flown(order: FlightOrder, which: Run, folder: Path, title: str, quiet: bool) -> Flown:
    with LiveProgress(order.plan.duration, quiet) as live:
        live.warn(f"{title}: {which}")
        return fly_run(order, which, folder, live.show, live.warn)


def _modes(text: str) -> list[Mode]:
    known = {mode.value: mode for mode in REPRODUCIBLE}
    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        if name not in known:
            raise InputError(f"{name!r}", allowed=", ".join(known), key="--modes")
    if not names:
        raise InputError("none given", allowed=", ".join(known), key="--modes")
    return [known[name] for name in dict.fromkeys(names)]


def _say(flown: list[Flown], found: list[tuple[Flown, str]], as_json: bool) -> None:
    if as_json:
        flights = [
            {
                "way": each.run.mode.value,
                "loaded": each.run.loaded,
                "simulated_s": round(each.simulated_seconds, 3),
                "wall_s": round(each.wall_seconds, 3),
                "reason": each.reason,
                "sha256": each.sha256,
            }
            for each in flown
        ]
        said = {"same": not found, "flights": flights, "differences": [text for _, text in found]}
        sys.stdout.write(json.dumps(said, indent=2) + "\n")
        return
    table = Table("flight", box=None, pad_edge=False)
    for title in ("simulated s", "took s", "x real time", "sha256"):
        table.add_column(title, justify="right")
    for each in flown:
        speed = each.simulated_seconds / max(each.wall_seconds, 1e-9)
        row = (f"{each.simulated_seconds:.2f}", f"{each.wall_seconds:.1f}", f"{speed:.1f}", each.sha256[:16])
        table.add_row(str(each.run), *row)
    Console(highlight=False).print(table)
    if flown[0].reason:
        sys.stdout.write(f"stopped: {flown[0].reason}\n")
    sys.stdout.writelines(f"{other.run} differs from {flown[0].run}: {text}\n" for other, text in found)
    sys.stdout.write(f"{len(flown)} flights: {'not the same' if found else 'the same bytes'}\n")
