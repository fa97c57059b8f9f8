"""`heli predict`: how long to fly an excitation, from a prior model, before it is flown."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_flight.plan import load_plan
from heli_flight.prediction import Forecast, fitting, forecast
from heli_identification.excitation_words import excitation_from_text, excitation_mapping
from heli_identification.helicopter_structures import STRUCTURES

DURATIONS = "15,30,60,120"
SHORTEST, LONGEST = 5.0, 600.0
"""Of a flight that is looked at [s]."""
WANTED = 0.1
"""Relative standard error whose time is shown."""


def add_parser(words: Any) -> None:
    """Add `predict` to the command."""
    parser = words.add_parser(
        "predict",
        help="standard errors that an excitation will give, before it is flown",
        description="Fly an excitation on the linear twin of a prior model and print the smallest standard "
        "errors that any estimate can have (Cramer-Rao), for several durations.",
    )
    parser.add_argument("plan", nargs="?", help="its first excitation of the structure's inputs")
    parser.add_argument("--signal", metavar="YAML", help="an excitation as in a plan, instead of one")
    parser.add_argument("--structure", choices=tuple(STRUCTURES), default="servo_rotor")
    parser.add_argument(
        "--model", type=Path, help="prior model file (default: the source's linearised values)"
    )
    parser.add_argument("--controller", help="name or path (default: the plan's, else lq)")
    parser.add_argument("--seconds", default=DURATIONS, help="durations (default: %(default)s)")
    parser.add_argument("--json", action="store_true", help="print one JSON object in SI")
    parser.set_defaults(func=run)


def durations(text: str) -> list[float]:
    """Durations from words such as `15,30` [s].

    Raises:
        InputError: not numbers within 5 .. 600 s.
    """
    found = []
    for word in text.split(","):
        try:
            seconds = float(word)
        except ValueError:
            seconds = math.nan
        if not SHORTEST <= seconds <= LONGEST:
            allowed = f"{SHORTEST:g}-{LONGEST:g} s, with commas between"
            raise InputError(f"{word.strip()!r} is no duration", allowed=allowed, key="--seconds")
        found.append(seconds)
    return found


def run(options: argparse.Namespace) -> int:
    """Predict and print.

    Raises:
        InputError: no excitation or two of them, or one that does not fit the structure.
    """
    if (options.plan is None) == (options.signal is None):
        raise InputError("one excitation is needed", allowed="a plan, or --signal", key="predict")
    controller = options.controller or "lq"
    if options.plan is not None:
        plan = load_plan(options.plan)
        excitation = fitting(plan.excitations, options.structure)
        controller = options.controller or plan.controller
    else:
        excitation = excitation_from_text(options.signal)
    model = None if options.model is None else ModelFile.read(options.model)
    found = forecast(
        options.structure, excitation, durations(options.seconds), model=model, controller=controller
    )
    if options.json:
        sys.stdout.write(json.dumps(as_mapping(found), indent=2) + "\n")
    else:
        show(found)
    return 0


def as_mapping(found: Forecast) -> dict[str, Any]:
    """Everything that came out, ready for JSON, SI; what the data do not tell is null."""
    seconds = found.seconds_for(WANTED)
    first = found.predictions[0]
    return {
        "structure": found.structure.name,
        "excitation": excitation_mapping(found.excitation),
        "feedback": found.feedback,
        "noise": found.noise,
        "seconds": [prediction.duration for prediction in found.predictions],
        "parameters": {
            name: {
                "value": float(first.values[index]),
                "standard_errors": [_known(prediction.errors[index]) for prediction in found.predictions],
                "seconds_for_10_percent": _known(seconds[index]),
            }
            for index, name in enumerate(first.names)
        },
    }


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def show(found: Forecast) -> None:
    """Print a table of coefficients over durations."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=110)
    told = excitation_mapping(found.excitation)
    channels = told.get("channel") or ", ".join(found.excitation.channels)
    table = Table("coefficient", title=f"{found.structure.name}: {found.excitation.signal} on {channels}")
    table.add_column("prior", justify="right")
    for prediction in found.predictions:
        table.add_column(f"{prediction.duration:g} s", justify="right")
    table.add_column("for 10 %", justify="right")
    first, seconds = found.predictions[0], found.seconds_for(WANTED)
    for index, name in enumerate(first.names):
        value = float(first.values[index])
        errors = [f"{prediction.errors[index]:.2g}" for prediction in found.predictions]
        needed = "never" if not math.isfinite(seconds[index]) else _time(float(seconds[index]))
        table.add_row(name, f"{value:.4g}", *errors, needed)
    console.print(table)
    console.print(
        f"Smallest possible standard errors (Cramer-Rao), SI; feedback {found.feedback}, noise {found.noise}."
    )


def _time(seconds: float) -> str:
    if seconds < 1.0:
        return "< 1 s"
    if seconds < 600.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 36000.0 else f"{seconds / 3600.0:.0f} h"
