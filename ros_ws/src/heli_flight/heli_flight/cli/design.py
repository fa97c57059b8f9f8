"""`heli design`: from a model file to a controller file, or to the report of all controllers."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Table

from heli_common.model_file import ModelFile
from heli_control.controller_designs import ABOUT, DESIGNS, DesignSummary, design


def add_parser(words: Any) -> None:
    """Add `design` to the command."""
    top = words.add_parser("design", help="design a controller from a model file")
    kinds = top.add_subparsers(dest="kind", required=True, metavar="KIND")
    for kind in DESIGNS:
        job = kinds.add_parser(
            kind, help=ABOUT[kind], description=f"{ABOUT[kind][0].upper()}{ABOUT[kind][1:]}."
        )
        job.add_argument("--model", type=Path, required=True, help="model file (heli model linearize --out)")
        job.add_argument("--out", type=Path, required=True, help="controller file to write")
        job.add_argument("--weights", type=Path, help="weights file: what differs from the shipped one")
        job.add_argument("--json", action="store_true", help="print the file and its figures as one object")
        job.set_defaults(func=run)
    _add_report(kinds)


def _add_report(kinds: Any) -> None:
    text = "every controller of a model side by side, the source's figures beside ours: one HTML file"
    job = kinds.add_parser("report", help=text, description=f"{text[0].upper()}{text[1:]}.")
    job.add_argument("--model", type=Path, required=True, help="model file (heli model linearize --out)")
    job.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write")
    job.add_argument(
        "--kinds", default=",".join(DESIGNS), help="which, with commas between (default: %(default)s)"
    )
    job.add_argument(
        "--weights", type=Path, metavar="DIR", help="folder with KIND.yaml for those that differ"
    )
    job.add_argument("--static", action="store_true", help="pictures instead of interactive plots: no script")
    job.add_argument("--json", action="store_true", help="print everything in numbers as JSON")
    job.set_defaults(func=report)


def report(options: argparse.Namespace) -> int:
    """Design all kinds and write the report; a line on stderr says what is being done."""
    from heli_flight.design_report import write_design_report  # drawing libraries are slow to load

    kinds = [kind.strip() for kind in options.kinds.split(",") if kind.strip()]
    model = ModelFile.read(options.model)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        line = progress.add_task("starts", total=None)
        made = write_design_report(
            model,
            options.out,
            kinds,
            options.weights,
            static=options.static,
            told=lambda job, done, all_of: progress.update(
                line, description=job, completed=done, total=all_of
            ),
        )
    if options.json:
        sys.stdout.write(json.dumps(made.metrics, allow_nan=False) + "\n")
        return 0
    published = made.metrics["published"]
    sys.stdout.write(f"{published['reproduced']} of {published['of']} published figures reproduced\n")
    sys.stdout.write(f"report {made.page}\n")
    return 0


def run(options: argparse.Namespace) -> int:
    """Design, write, say what came out."""
    summary = design(options.kind, ModelFile.read(options.model), options.weights)
    summary.file.write(options.out)
    if options.json:
        figures = {axis: dict(entries) for axis, entries in summary.figures.items()}
        sys.stdout.write(json.dumps(summary.file.mapping() | {"figures": figures}) + "\n")
    else:
        _print(summary)
        sys.stdout.write(f"controller {options.out}\n")
    return 0


def _print(summary: DesignSummary) -> None:
    """Every figure of every axis, with what the source prints beside it."""
    table = Table("axis", "figure", "ours", "published", "", title=f"{summary.kind}: {summary.model.name}")
    printed = {(row.published.axis, row.published.name): row for row in summary.published}
    for axis, figures in summary.figures.items():
        for name, value in _with_missing(axis, figures, printed).items():
            row = printed.get((axis, name))
            verdict = "" if row is None else "reproduced" if row.reproduced else "differs"
            ours = "-" if value is None else f"{value:.4g}"
            table.add_row(axis, name, ours, "" if row is None else f"{row.published.value:g}", verdict)
    Console(highlight=False).print(table)


def _with_missing(
    axis: str, figures: Mapping[str, float], printed: Mapping[tuple[str, str], object]
) -> dict[str, float | None]:
    missing = {name: None for place, name in printed if place == axis and name not in figures}
    return dict(figures) | missing
