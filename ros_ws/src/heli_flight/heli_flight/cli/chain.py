"""`heli chain`: identification flight, models, controllers, and hovers with them, as one command."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_common.errors import InputError
from heli_flight.chain import AXES, KINDS, LARGEST_RATIO, MODELS, Chain, run_chain
from heli_flight.cli.limits import MOST_WORKERS, require_between

_LARGEST_SEED = 2**31 - 1


def add_parser(words: Any) -> None:
    """Add `chain` to the command."""
    parser = words.add_parser(
        "chain",
        help="fly F5, identify, design, hover with what came out and with the shipped controllers",
        description="Fly the identification plan, identify both axes, design gst2 and ncf2 from the model, "
        "and compare their hovers with those of the controllers of the linearised model, all in process.",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="new folder for everything")
    parser.add_argument("--seeds", type=int, default=10, metavar="N", help="hovers each (default: 10)")
    parser.add_argument("--first", type=int, default=1, metavar="SEED", help="first seed (default: 1)")
    parser.add_argument("--plan", default="identification", help="identification flight")
    parser.add_argument("--hover", default="hover", help="plan of the hovers (default: hover)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--json", action="store_true", help="print one JSON object in SI")
    parser.set_defaults(func=run)


def run(options: argparse.Namespace) -> int:
    """Run the chain and print; the exit code says nothing of the ratio.

    Raises:
        InputError: a number out of range, a plan that is none, a folder in use, data that bear nothing.
    """
    last = options.first + options.seeds - 1
    if options.seeds < 1:
        raise InputError(f"{options.seeds}", allowed="1 or more", key="--seeds")
    if options.first < 0 or last > _LARGEST_SEED:
        raise InputError(f"{options.first}", allowed=f"0 .. {_LARGEST_SEED}", key="--first")
    require_between(options.workers, 1, MOST_WORKERS, "--workers")
    found = run_chain(
        options.out.absolute(),
        range(options.first, last + 1),
        plan=options.plan,
        hover=options.hover,
        workers=options.workers,
        tell=Told().line,
    )
    if options.json:
        sys.stdout.write(json.dumps(found.mapping(), indent=2) + "\n")
    else:
        show(found, options.seeds)
    return 0


class Told:
    """Lines of progress on standard error; an estimate of what is left from the pace of the hovers so far."""

    def __init__(self) -> None:
        self._console = Console(stderr=True, highlight=False)
        self._begin = perf_counter()

    def line(self, text: str, done: int, total: int) -> None:
        """What is being done; `done` hovers of `total`, zeros before the first."""
        if not total:
            self._begin = perf_counter()
        else:
            left = (total - done) * (perf_counter() - self._begin) / done
            text = f"{text}: {done} of {total}, about {left:.0f} s left"
        self._console.print(text, soft_wrap=True, markup=False)


def show(found: Chain, seeds: int) -> None:
    """Print fits, sigmas, ratios and the verdict."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=110)
    for block, part in found.blocks.items():
        fits = "not validated"
        if part.fit is not None:
            pairs = zip(part.fit.outputs, part.fit.percent.tolist(), strict=True)
            fits = "fit on validation data [%] " + ", ".join(f"{name} {value:.1f}" for name, value in pairs)
        console.print(f"{block} by {part.estimate.structure.name}: {fits}")
    for remark in found.remarks:
        console.print(remark)
    title = f"mean sigma of the true pose, {seeds} hovers each"
    table = Table("controller", "model", "x cm", "y cm", "z cm", "psi deg", "ratio", title=title)
    for kind in KINDS:
        for model in MODELS:
            sigmas = found.mean_sigmas(kind, model)
            shown = [f"{100.0 * s:.3f}" for s in sigmas[:3]] + [f"{57.29578 * s:.3f}" for s in sigmas[3:]]
            table.add_row(kind, model, *(shown or ["-"] * len(AXES)), "")
        ratio = found.ratio(kind)
        each = [f"{r:.3f}" for r in found.ratios(kind)] or ["-"] * len(AXES)
        table.add_row(kind, "ratio", *each, "-" if ratio is None else f"{ratio:.3f}", end_section=True)
    console.print(table)
    for hover in found.hovers:
        if hover.failure:
            console.print(f"{hover.kind} {hover.model} seed {hover.seed}: {hover.failure}")
    verdict = "holds" if found.holds else "does not hold"
    console.print(f"ratio at most {LARGEST_RATIO:g}: {verdict}\nmodel {found.model}")
