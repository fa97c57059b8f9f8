"""`heli campaign`: many flights of one plan; parameters, seeds, wind, room, faults, controllers vary."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import sys
from pathlib import Path
from time import perf_counter
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from heli_common.errors import EXIT_FLOWN, EXIT_SAFETY_STOP, InputError
from heli_control.controller_file import load_controller
from heli_control.motor_controller_file import load_motor_controller
from heli_flight.campaign import run_campaign
from heli_flight.campaign_draws import check_campaign
from heli_flight.campaign_flight import Campaign
from heli_flight.campaign_pictures import write_pictures
from heli_flight.campaign_results import SUMMARY, TABLE, WORST, command, write_results
from heli_flight.cli.limits import require_between
from heli_flight.flight_log import log_of_bag
from heli_flight.flight_record import FlightRecord
from heli_flight.plan import load_plan
from heli_flight.vary_file import Vary, read_vary

_MOST_FLIGHTS, _MOST_WORKERS = 1_000_000, 256


def add_parser(words: Any) -> None:
    """Add `campaign` to the command."""
    parser = words.add_parser(
        "campaign",
        help="fly a plan many times with parameters, seeds, wind, faults and controllers varied",
        description="Monte Carlo over the flights of a plan, in process; interrupted, the same command goes "
        "on where it was. Leaves a Parquet file, a summary, pictures, the worst flight (docs/campaigns.md).",
    )
    parser.add_argument("plan", help="shipped plan or path of a plan file")
    parser.add_argument("--flights", type=int, required=True, metavar="N", help="how many in all")
    parser.add_argument("--vary", type=Path, metavar="FILE", help="what varies (default: the seed alone)")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="for everything it leaves")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, default=1, metavar="W", help="processes (default: 1)")
    where.add_argument(
        "--dask", default="", metavar="ADDRESS", help="of a dask scheduler that has the workers"
    )
    parser.add_argument("--controller", help="in place of the plan's: shipped controller or controller file")
    parser.add_argument("--motor", default="motor", help="shipped motor controller or its file")
    parser.add_argument(
        "--check",
        type=Path,
        metavar="BAG",
        help="fly nothing: is this bag the worst flight of FOLDER?",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object in SI")
    parser.set_defaults(func=run)


def run(options: argparse.Namespace) -> int:
    """Fly the campaign and print what came out.

    Raises:
        InputError: a number out of range, a plan or vary file that is none, a folder of something else.
    """
    if options.check is not None:
        return check(options.check, options.out / WORST, options.json)
    require_between(options.flights, 1, _MOST_FLIGHTS, "--flights")
    require_between(options.workers, 1, _MOST_WORKERS, "--workers")
    campaign = read_campaign(options)
    if options.flights % campaign.vary.cells:
        allowed = f"a multiple of {campaign.vary.cells}, the combinations of the grid"
        raise InputError(f"{options.flights}", allowed=allowed, key="--flights")
    out = options.out.absolute()
    with CampaignProgress(options.json) as live:
        rows = run_campaign(
            campaign, options.flights, out, live.show, workers=options.workers, dask=options.dask
        )
    found = write_results(out, rows, campaign)
    pictures = write_pictures(out, rows, campaign)
    if options.json:
        sys.stdout.write(json.dumps(found, indent=2) + "\n")
    else:
        show(found, out, pictures)
    return EXIT_FLOWN


def read_campaign(options: argparse.Namespace) -> Campaign:
    """Everything that the options name, checked.

    Raises:
        InputError: what is wrong.
    """
    plan = load_plan(options.plan)
    if options.controller:
        plan = dataclasses.replace(plan, controller=options.controller)
    vary = read_vary(options.vary) if options.vary else Vary(seed=plan.seed)
    try:
        check_campaign(plan, vary)
    except InputError as error:
        raise InputError(error.problem, allowed=error.allowed, file=options.vary, key=error.key) from None
    names = dict.fromkeys((*plan.controllers, *vary.controllers))
    controllers = {name: load_controller(name) for name in names}
    return Campaign(plan, vary, controllers, load_motor_controller(options.motor))


def check(bag: Path, worst: Path, as_json: bool) -> int:
    """Whether a bag holds the worst flight of a campaign; 0 if it does bit by bit, else 3.

    Raises:
        InputError: no bag, or no worst flight.
    """
    try:
        wanted = json.loads((worst / "flight.json").read_text())
    except OSError:
        raise InputError(
            "no flight.json", allowed="the folder of a campaign", file=worst, key="--out"
        ) from None
    log = log_of_bag(FlightRecord.load(bag))
    same = log.trace == wanted["trace"]
    found = {"flight": wanted["flight"], "same": same, "trace": wanted["trace"], "of_bag": log.trace}
    if as_json:
        sys.stdout.write(json.dumps(found, indent=2) + "\n")
    else:
        verdict = "the same bits" if same else "another flight"
        sys.stdout.write(
            f"flight {wanted['flight']}: {verdict}\ntrace  {wanted['trace']}\nof bag {log.trace}\n"
        )
    return EXIT_FLOWN if same else EXIT_SAFETY_STOP


class CampaignProgress:
    """How many flights there are, on standard error: a bar, or a line for every tenth of them.

    Args:
        quiet: show nothing.
    """

    def __init__(self, quiet: bool) -> None:
        self._console = Console(stderr=True, quiet=quiet, highlight=False)
        self._bar = Progress(
            TextColumn("flights"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            console=self._console,
            disable=not self._console.is_terminal,
        )
        self._task = self._bar.add_task("flights", total=None)
        self._begin, self._before, self._tenth = perf_counter(), 0, -1

    def __enter__(self) -> CampaignProgress:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def show(self, done: int, total: int) -> None:
        """So many flights of so many."""
        if self._tenth < 0:
            self._begin, self._before = perf_counter(), done
        self._bar.update(self._task, completed=done, total=total)
        tenth = 10 * done // total
        if self._console.is_terminal or tenth == self._tenth:
            return
        self._tenth = tenth
        text = f"{done} of {total} flights"
        if done > self._before:
            left = (total - done) * (perf_counter() - self._begin) / (done - self._before)
            text += f", about {left:.0f} s left"
        self._console.print(text, markup=False, soft_wrap=True)


def show(found: dict[str, Any], out: Path, pictures: list[Path]) -> None:
    """Print the table of a campaign and where its results are."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=130)
    title = f"{found['flights']} flights of {found['plan']}, campaign seed {found['campaign_seed']}"
    table = Table("controller", title=title)
    for name in (
        "flights",
        "success",
        "95 % interval",
        "sigma x, y, z [cm] (median)",
        "psi [deg]",
        "largest error [cm]: median",
        "95 %",
        "max",
    ):
        table.add_column(escape(name), justify="right")
    groups = found["controllers"]
    for name, figures in (groups | ({"all": found["all"]} if len(groups) > 1 else {})).items():
        share = figures["success"]
        sigmas = [_shown(figures, f"sigma_{axis}_m", "median", 100.0, 2) for axis in "xyz"]
        table.add_row(
            name,
            f"{share['flights']}",
            f"{100.0 * share['rate']:.1f} %",
            f"{100.0 * share['low']:.1f} .. {100.0 * share['high']:.1f} %",
            ", ".join(sigmas),
            _shown(figures, "sigma_psi_rad", "median", math.degrees(1.0), 2),
            *(_shown(figures, "max_position_m", which, 100.0, 1) for which in ("median", "p95", "max")),
        )
    console.print(table)
    for reason, count in found["losses"].items():
        console.print(f"{count} x {reason}", markup=False)
    console.print(f"table {out / TABLE}\nsummary {out / SUMMARY}", soft_wrap=True, markup=False)
    for picture in pictures:
        console.print(f"picture {picture}", soft_wrap=True, markup=False)
    console.print(f"worst flight {found['worst']}, to be flown again by", markup=False)
    console.print(f"  {command(out / WORST)}", soft_wrap=True, markup=False)


def _shown(figures: dict[str, Any], name: str, which: str, factor: float, digits: int) -> str:
    return f"{factor * figures[name][which]:.{digits}f}" if name in figures else "-"
