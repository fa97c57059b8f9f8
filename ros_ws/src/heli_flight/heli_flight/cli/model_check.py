"""`heli model check`: the source's printed numbers beside ours, and its figures drawn from our model."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_bench_sim.parameters import PARAMETER_SETS
from heli_common.errors import InputError
from heli_flight.model_check import NOT_REPRODUCED, NOT_SCORED, REPRODUCED, ModelCheck, Row, check_model
from heli_flight.model_figures import write_figures

EXIT_UNEXPLAINED = 1
"""A number is missed and no known reason explains it: the model is not the source's."""

PLAIN_WIDTH = 112
"""Columns when nobody says how many there are: in a file or a pipe."""

HEADINGS = {
    "2.1": "lever gains",
    "2.2": "drive",
    "2.3": "hover",
    "2.4": "scaling",
    "2.5": "poles, zeros",
    "2.6": "derivatives",
}
SHORT = {REPRODUCED: "reproduced", NOT_REPRODUCED: "not reproduced", NOT_SCORED: "listed"}
COLOURS = {REPRODUCED: "green", NOT_REPRODUCED: "red", NOT_SCORED: "bright_black"}


def add_job(jobs: Any) -> None:
    """Add `check` to `heli model`."""
    text = "every number the thesis prints of its model beside ours, with verdict and reason"
    job = jobs.add_parser(
        "check",
        help=text,
        description=f"{text[0].upper()}{text[1:]} (source Tables 2.1 to 2.6, Figures 2.12 to 2.17).",
        epilog=f"Exit code {EXIT_UNEXPLAINED} if a number is missed without a known reason.",
    )
    job.add_argument(
        "--parameters",
        choices=sorted(PARAMETER_SETS),
        default="thesis",
        help="shipped parameter set (default: thesis)",
    )
    job.add_argument("--json", action="store_true", help="print one JSON object")
    job.add_argument("--out", type=Path, metavar="FOLDER", help="write Figures 2.12 to 2.17 there as PNG")
    job.set_defaults(func=run_check)


def run_check(options: argparse.Namespace) -> int:
    """Compute, judge, print, draw."""
    parameters = PARAMETER_SETS[options.parameters]()
    check = check_model(parameters, options.parameters)
    figures: list[Path] = []
    if options.out is not None:
        try:
            figures = write_figures(parameters, options.parameters, options.out)
        except OSError as error:
            raise InputError(f"cannot write figures: {error.strerror}", file=options.out) from None
    if options.json:
        mapping = check.mapping() | {"figures": [str(path) for path in figures]}
        sys.stdout.write(json.dumps(mapping, indent=2, allow_nan=False) + "\n")
    else:
        console = Console()
        show(check, console if console.is_terminal else Console(width=PLAIN_WIDTH))
        for path in figures:
            sys.stdout.write(f"figure {path}\n")
    return EXIT_UNEXPLAINED if check.unexplained else 0


def show(check: ModelCheck, console: Console) -> None:
    """Print the table, the reasons by number, and the count.

    Args:
        check: all rows.
        console: where to.
    """
    reasons: dict[str, int] = {}
    table = Table(title=f"the source's numbers and ours, parameters {check.parameter_set}")
    table.add_column("quantity", overflow="fold")
    for name in ("published", "rebuilt", "ours", "to publ.", "to rebuilt"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    before = ""
    for row in check.rows:
        if row.table != before:
            table.add_section()
            table.add_row(f"[bold]Table {row.table}[/] {HEADINGS[row.table]}")
            before = row.table
        number = reasons.setdefault(row.reason, len(reasons) + 1) if row.reason else None
        table.add_row(*_cells(row, number))
    console.print(table)
    for reason, number in reasons.items():
        console.print(f"{number:3d} {reason}", highlight=False, markup=False, soft_wrap=True)
    console.print(
        f"\n{check.count(REPRODUCED)} reproduced, {check.count(NOT_REPRODUCED)} not reproduced, "
        f"{check.count(NOT_SCORED)} listed without score; "
        f"{len(check.unexplained)} missed without a known reason",
        highlight=False,
        soft_wrap=True,
    )


def _cells(row: Row, reason: int | None) -> tuple[str, ...]:
    words = SHORT[row.verdict] if row.explained else "MISSED"
    note = f", {reason}" if reason else ""
    quantity = row.quantity if row.unit == "-" else f"{row.quantity} \\[{row.unit}]"
    return (
        quantity,
        _number(row.published),
        _number(row.rebuilt),
        _number(row.ours),
        _difference(row.to_published),
        _difference(row.to_rebuilt),
        f"[{COLOURS[row.verdict] if row.explained else 'bold red'}]{words}[/]{note}",
    )


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"


def _difference(value: float | None) -> str:
    if value is None:
        return ""
    return "0" if abs(value) < 1e-9 else f"{value:+.2g}"
