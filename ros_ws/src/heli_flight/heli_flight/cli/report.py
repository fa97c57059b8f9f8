"""`heli report`: the report of one flight, or of several laid over each other."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_common.errors import EXIT_FLOWN


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Describe the sub-command to the `heli` command."""
    parser = subparsers.add_parser(
        "report",
        help="write the report of a flight from its bag",
        description="Write report.html and metrics.json from one bag, or compare several.",
    )
    parser.add_argument("bags", nargs="+", type=Path, metavar="BAG", help="folder of a bag")
    parser.add_argument(
        "--compare",
        nargs="+",
        action="extend",
        default=[],
        type=Path,
        metavar="BAG",
        help="flights to be laid over it; the first one's reference is shown",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="where to write (default: `report` in the bag's folder, `./report` for several bags)",
    )
    parser.add_argument(
        "--static",
        action="store_true",
        help="pictures instead of interactive plots: a small page, PNG and SVG beside it",
    )
    parser.add_argument("--json", action="store_true", help="print the figures of merit as JSON")
    parser.set_defaults(func=run)


def run(arguments: argparse.Namespace) -> int:
    """Write the report and say where it is.

    Raises:
        InputError: a bag is unreadable, empty or not to be compared, or the report cannot be written.
    """
    from heli_flight.report import write_report  # drawing libraries are slow to load

    bags: list[Path] = [*arguments.bags, *arguments.compare]
    default = bags[0] / "report" if len(bags) == 1 and bags[0].is_dir() else Path("report")
    report = write_report(bags, arguments.out or default, arguments.static)
    if arguments.json:
        sys.stdout.write(json.dumps(report.summaries, indent=2) + "\n")
        return EXIT_FLOWN
    console = Console(highlight=False)
    console.print(_table(report.summaries))
    for summary in report.summaries:
        for item in summary["metrics"]["missing"]:
            console.print(f"{summary['name']}: {item}", style="yellow", markup=False)
    console.print(f"report: {report.page}", soft_wrap=True, markup=False)
    return EXIT_FLOWN


def _table(summaries: list[dict[str, Any]]) -> Table:
    table = Table("flight", "ended", box=None, pad_edge=False)
    for title in ("σ x cm", "σ y cm", "σ z cm", "σ ψ deg", "steps", "overshoot %", "lost"):
        table.add_column(title, justify="right")
    for summary in summaries:
        metrics = summary["metrics"]
        hover = metrics["hover"][0] if metrics["hover"] else {}
        overshoots = [step["overshoot_percent"] for step in metrics["steps"]]
        table.add_row(
            summary["name"],
            metrics["flight"]["ended"] or "-",
            *(_scaled(hover.get(f"sigma_{axis}_m"), 100.0) for axis in "xyz"),
            _scaled(hover.get("sigma_psi_rad"), 57.29577951308232),
            str(len(metrics["steps"])),
            _scaled(max(overshoots, default=None), 1.0),
            str(summary["provenance"]["lost_messages"]),
        )
    return table


def _scaled(value: float | None, factor: float) -> str:
    return "-" if value is None else f"{value * factor:.2f}"
