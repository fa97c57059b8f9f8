"""`heli design`: from a model file to a controller file."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_common.model_file import ModelFile
from heli_control.controller_designs import DESIGNS, DesignSummary, design

ABOUT = {
    "motor": "PI of the rotor speed from an H-infinity design of the drive (source sec. 3.1.1)",
    "lq": "linear quadratic attitude and velocity controller (sec. 3.2.2, 3.2.3)",
    "skst": "H-infinity S/KS/T, which the source drops (sec. 3.3.2)",
    "gst": "H-infinity GS/T (sec. 3.3.3)",
    "gst2": "H-infinity GS/T with two degrees of freedom (sec. 3.3.4)",
    "ncf": "H-infinity loop shaping (sec. 3.4)",
    "ncf2": "H-infinity loop shaping with two degrees of freedom (sec. 3.4)",
}


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
