"""`heli model`: the operating point of hover, the linear models about it, and what is known of both."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_bench_sim import linearize
from heli_bench_sim.parameters import PARAMETER_SETS
from heli_bench_sim.trim import Trim, trim
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_flight.cli import encoders, model_check

ANGLES = ("theta_0", "theta_t", "phi", "theta", "B_1s", "A_1s", "a_1p", "b_1p")
UNITS = {"V_i": "m/s", "V_t": "m/s", "M_A": "N m", "U_mot": "V", "I_motor": "A", "Omega": "rad/s"}


def add_parser(words: Any) -> None:
    """Add `model` to the command."""
    model = words.add_parser("model", help="trim and linearise the helicopter")
    jobs = model.add_subparsers(dest="job", required=True, metavar="JOB")
    for name, text, function in (
        ("trim", "operating point of steady hover", show_trim),
        ("linearize", "linear models about hover: horizontal, vertical, full", show_linear),
    ):
        job = jobs.add_parser(name, help=text, description=text.capitalize() + ".")
        job.add_argument(
            "--parameters",
            choices=sorted(PARAMETER_SETS),
            default="thesis",
            help="shipped parameter set (default: thesis)",
        )
        job.add_argument("--json", action="store_true", help="print one JSON object in SI")
        if function is show_linear:
            job.add_argument("--out", type=Path, help="write a model file, for `heli design`")
        job.set_defaults(func=function)
    model_check.add_job(jobs)
    encoders.add_job(jobs)


def show_trim(options: argparse.Namespace) -> int:
    """Print the operating point."""
    point = asdict(trim(PARAMETER_SETS[options.parameters]()))
    if options.json:
        sys.stdout.write(json.dumps(point, indent=2) + "\n")
        return 0
    table = Table("quantity", "value", "unit", title=f"hover, parameters {options.parameters}")
    for name, value in point.items():
        in_degrees = name in ANGLES
        shown = value * 57.29577951308232 if in_degrees else value
        table.add_row(name, f"{shown:.3f}", "deg" if in_degrees else UNITS[name])
    Console().print(table)
    return 0


def show_linear(options: argparse.Namespace) -> int:
    """Print the linear models, and write them to a model file if asked."""
    parameters = PARAMETER_SETS[options.parameters]()
    point = trim(parameters)
    models = {
        "horizontal": linearize.horizontal(parameters, point),
        "vertical": linearize.vertical(parameters, point),
        "full": linearize.linearize(parameters, point),
    }
    if options.out is not None:
        model_file(f"{options.parameters}_linearized", point, models).write(options.out)
    if options.json:
        sys.stdout.write(json.dumps({name: as_mapping(model) for name, model in models.items()}) + "\n")
        return 0
    for name, model in models.items():
        table = Table("pole [rad/s]", title=f"{name}: {' '.join(model.states)}")
        for pole in model.poles:
            table.add_row(f"{pole.real:9.4f} {pole.imag:+9.4f}i")
        Console().print(table)
    return 0


def as_mapping(model: StateSpace) -> dict[str, Any]:
    """Names, matrices as nested lists, and poles as [real, imaginary] pairs."""
    poles = [[float(pole.real), float(pole.imag)] for pole in model.poles]
    return model.mapping() | {"poles": poles}


def model_file(name: str, point: Trim, models: dict[str, StateSpace]) -> ModelFile:
    """A model file of the bench linearised at its own trim."""
    source = {
        "method": "central differences of the nonlinear bench at its hover trim",
        "heli_bench_sim": version("heli_bench_sim"),
    }
    return ModelFile(
        name=name,
        source=source,
        operating_point=point,
        **models,
    )
