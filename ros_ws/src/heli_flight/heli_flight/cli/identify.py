"""`heli identify`: from flown bags to a plant model with honest error bars."""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_flight.flight_record import FlightRecord
from heli_flight.identification import METHODS, Choice, Identified, identify
from heli_identification.helicopter_structures import STRUCTURES
from heli_identification.identified_model import described
from heli_identification.parametrisation import Noise
from heli_identification.preparation import InputSource, Segment


def add_parser(words: Any) -> None:
    """Add `identify` to the command."""
    parser = words.add_parser(
        "identify",
        help="identify a plant model from flown bags",
        description="Estimate the coefficients of a structure from flights, validate them on other data and "
        "write a model file for `heli design` (source sec. 2.5).",
    )
    parser.add_argument("bags", type=Path, nargs="+", metavar="BAG", help="folders of bags")
    parser.add_argument("--structure", choices=tuple(STRUCTURES), default="servo_rotor")
    parser.add_argument("--method", choices=METHODS, default="pem")
    parser.add_argument(
        "--noise",
        choices=[each.value for each in Noise],
        default=Noise.KALMAN.value,
        help="model of the disturbances for pem",
    )
    parser.add_argument("--input", choices=[each.value for each in InputSource], default="actuator")
    parser.add_argument("--averaged", action="store_true", help="the source's 10-point filter both ways")
    parser.add_argument("--free", nargs="+", metavar="NAME", help="estimate exactly these coefficients")
    parser.add_argument(
        "--fix", nargs="+", metavar="NAME", default=[], help="keep these at their prior value"
    )
    parser.add_argument("--estimate", metavar="A-B[,A-B]", help="seconds, flight time")
    parser.add_argument("--validate", metavar="C-D[,C-D]")
    parser.add_argument("--controller", default="lq", help="flown controller, for indirect and joint")
    parser.add_argument("--prior", type=Path, help="model file: start values and everything not identified")
    parser.add_argument("--out", type=Path, help="model file to write")
    parser.add_argument("--report", type=Path, metavar="DIR", help="folder for the validation report")
    parser.add_argument("--static", action="store_true", help="pictures instead of interactive plots in it")
    parser.add_argument("--json", action="store_true", help="print one JSON object in SI")
    parser.set_defaults(func=run)


def segments(text: str | None, key: str) -> tuple[Segment, ...] | None:
    """Segments from words such as `20-80` or `20-50,60-80` [s]; None from None.

    Raises:
        InputError: not of this form, or an end before its beginning.
    """
    if text is None:
        return None
    found = []
    for word in text.split(","):
        begin, dash, end = word.strip().partition("-")
        try:
            first, last = float(begin), float(end)
        except ValueError:
            first = last = math.nan
        if not dash or not first < last:
            raise InputError(f"{word!r} is no segment", allowed="A-B in seconds, A before B", key=key)
        found.append(Segment(first, last))
    return tuple(found)


def run(options: argparse.Namespace) -> int:
    """Read, estimate, validate, write, print.

    Raises:
        InputError: no readable bag, or data that do not bear the estimate.
    """
    choice = Choice(
        structure=options.structure,
        method=options.method,
        noise=Noise(options.noise),
        source=InputSource(options.input),
        averaging=options.averaged,
        free=None if options.free is None else tuple(options.free),
        fixed=tuple(options.fix),
        estimate=segments(options.estimate, "--estimate"),
        validate=segments(options.validate, "--validate"),
        controller=options.controller,
    )
    prior = None if options.prior is None else ModelFile.read(options.prior)
    found = identify([FlightRecord.load(folder) for folder in options.bags], choice, prior)
    if options.out is not None:
        found.model(options.out.stem, prior).write(options.out)
    report = None
    if options.report is not None:
        # drawing libraries are slow to load
        from heli_flight.identification_report import write_identification_report

        report = write_identification_report(
            found, as_mapping(found), options.report, prior, static=options.static
        )
    if options.json:
        sys.stdout.write(json.dumps(as_mapping(found), indent=2) + "\n")
    else:
        show(found)
        if options.out is not None:
            sys.stdout.write(f"model {options.out}\n")
        if report is not None:
            sys.stdout.write(f"report {report.page}\n")
    return 0


def as_mapping(found: Identified) -> dict[str, Any]:
    """Everything that came out, ready for JSON, SI."""
    return {
        "choice": found.remarks(),
        **described(found.estimate, found.records, found.fit),
        "poles": [[pole.real, pole.imag] for pole in found.estimate.structure.model().poles.tolist()],
        "means": found.means,
        "search": [asdict(step) for step in found.estimate.steps],
    }


def show(found: Identified) -> None:
    """Print coefficients with their intervals, fit, residuals, poles and what the data do not tell."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=110)
    estimate = found.estimate
    seconds = sum(record.duration for record in found.records)
    table = Table(
        "coefficient", title=f"{estimate.structure.name} by {found.choice.method}, {seconds:.1f} s of data"
    )
    for title in ("value", "standard error", "95 % interval", "unit"):
        table.add_column(title, justify="left" if title == "unit" else "right")
    for parameter in estimate.structure.parameters:
        if parameter.name not in estimate.names:
            table.add_row(parameter.name, f"{parameter.value:.5g}", "fixed", "", parameter.unit)
            continue
        index = estimate.names.index(parameter.name)
        low, high = estimate.intervals[index]
        error = f"{estimate.errors[index]:.3g}"
        table.add_row(
            parameter.name, f"{parameter.value:.5g}", error, f"{low:.4g} .. {high:.4g}", parameter.unit
        )
    console.print(table)
    kind = "white" if estimate.white else "coloured; standard errors are the robust ones"
    console.print(f"residuals are {kind}; {len(estimate.steps)} steps, converged: {estimate.converged}")
    if found.fit is not None:
        fits = ", ".join(
            f"{n} {v:.1f}" for n, v in zip(found.fit.outputs, found.fit.percent.tolist(), strict=True)
        )
        console.print(f"fit on {len(found.fit.segments)} validation segments [%]: {fits}")
    poles = ", ".join(f"{p.real:.3f}{p.imag:+.3f}i" for p in estimate.structure.model().poles)
    console.print(f"poles [rad/s]: {poles}")
    for each in estimate.weak:
        deviation = f"{100.0 * each.deviation:.0f} %" if math.isfinite(each.deviation) else "infinite"
        console.print(f"not identified: {', '.join(each.names)} ({deviation} of its size): {each.reason}")
