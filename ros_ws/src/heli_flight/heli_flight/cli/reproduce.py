"""`heli reproduce`: the thesis's flights with all its controllers, and one page beside what it prints."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

from heli_common.errors import InputError
from heli_flight.cli.limits import MOST_WORKERS, require_between

_MOST_SEEDS = 1000


def add_parser(words: Any) -> None:
    """Add `reproduce` to the command."""
    parser = words.add_parser(
        "reproduce",
        help="fly the thesis's experiments and compare",
        description="Fly F1 to F8 with all controllers and seeds, in process, and write reproduction.html "
        "and reproduction.json. Flights that the folder holds already are not flown again.",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="for flights and page")
    parser.add_argument("--quick", action="store_true", help="few seeds, in minutes")
    parser.add_argument(
        "--seeds", type=int, metavar="N", help="hovers (F2) with each controller (20; quick 3)"
    )
    parser.add_argument(
        "--only",
        metavar="F1,F2",
        help="some of the experiments; the page shows what the folder holds of them",
    )
    parser.add_argument("--params-file", type=Path, help="parameters of the nodes")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.set_defaults(func=run)


def run(options: argparse.Namespace) -> int:
    """Fly what is missing, write the page, print the comparison.

    Raises:
        InputError: a number out of range, an experiment that is none, a folder that cannot be written.
    """
    require_between(options.workers, 1, MOST_WORKERS, "--workers")
    if options.seeds is not None:
        require_between(options.seeds, 1, _MOST_SEEDS, "--seeds")
    # slow to load
    from heli_flight import reproduction_run as extents
    from heli_flight.reproduction_flights import PLANS
    from heli_flight.reproduction_report import write_reproduction
    from heli_flight.reproduction_store import flown, flying_hash

    extent = extents.QUICK if options.quick else extents.COMPLETE
    if options.seeds is not None:
        extent = dataclasses.replace(extent, seeds=extent.seeds | {"F2": options.seeds})
    chosen = options.only.split(",") if options.only else list(PLANS)
    for name in chosen:
        if name not in PLANS:
            raise InputError(f"{name!r} is no experiment", allowed=", ".join(PLANS), key="--only")
    if options.out.exists() and not options.out.is_dir():
        raise InputError("is no folder", allowed="a folder, new or of a reproduction", file=options.out)
    jobs = [job for job in extents.jobs(extent) if job.experiment in chosen]
    begin = perf_counter()
    outcomes = flown(jobs, options.out, options.workers, _Told(), options.params_file)
    provenance = {
        "command": "heli reproduce" + (" --quick" if options.quick else ""),
        "flights and searches": str(len(outcomes)),
        "hovers with each controller": str(extent.seeds["F2"]),
        "parameters": str(options.params_file or "defaults"),
        "sources and parameters, SHA-256": flying_hash(options.params_file),
    }
    written = write_reproduction(outcomes, options.out, provenance)
    show(written.rows)
    sys.stdout.write(f"{written.page}\n{written.numbers}\n")
    sys.stderr.write(f"{perf_counter() - begin:.0f} s\n")
    return 0


class _Told:
    """One line for every flight on standard error."""

    def __init__(self) -> None:
        self._flown = 0
        self._begin = perf_counter()

    def __call__(self, job: Any, done: int, total: int) -> None:
        self._flown += 1
        left = (total - done) * (perf_counter() - self._begin) / self._flown
        sys.stderr.write(
            f"{done} of {total}: {job.experiment} {job.controller} seed {job.seed}, about {left:.0f} s left\n"
        )


def show(rows: Any) -> None:
    """Print the comparison."""
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=200)
    table = Table(
        "flight", "what", "published", "ours: mean [95 %]", "ratio", "verdict", box=None, pad_edge=False
    )
    for row in rows:
        ratio = "-" if row.ratio is None else f"{row.ratio:.2f}"
        verdict = "-" if row.holds is None else "reproduced" if row.holds else "no"
        table.add_row(row.experiment, row.what, row.published, row.ours, ratio, verdict)
    console.print(table)
    held = sum(row.holds is True for row in rows)
    console.print(f"{held} of {len(rows)} reproduced")
