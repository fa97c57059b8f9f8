"""`heli calibrate gusts`: the room's gusts so strong that LQ hovers as in the source's Table 5.2."""

from __future__ import annotations

import argparse
import math
import sys
from functools import partial
from pathlib import Path
from typing import Any

from heli_common.errors import InputError
from heli_common.files import write_atomically
from heli_flight.cli.limits import MOST_WORKERS, require_between
from heli_flight.components import DEFAULTS
from heli_flight.parameter_file import read_parameters
from heli_flight.plan import load_plan

_MOST_SEEDS, _LARGEST_SEED = 1000, 2**31 - 1


def add_parser(words: Any) -> None:
    """Add `calibrate` to the command."""
    about = "Find parameters of the bench that are known by their effect only."
    parser = words.add_parser("calibrate", help="find the strengths of the room's gusts", description=about)
    what = parser.add_subparsers(dest="what", required=True, metavar="WHAT")
    gusts = what.add_parser(
        "gusts",
        help="by the LQ row of Table 5.2",
        description="Fly F2 with LQ in process, again and again, until the means of its four sigmas over the "
        "seeds are those of Table 5.2. Writes a parameter file that says how it was found.",
    )
    gusts.add_argument("--out", type=Path, required=True, metavar="FILE", help="parameter file to write")
    gusts.add_argument("--plan", default="hover", help="plan of the hovers (default: hover)")
    gusts.add_argument("--seeds", type=int, default=8, metavar="N", help="hovers in each round (default: 8)")
    gusts.add_argument("--first", type=int, default=101, metavar="SEED", help="first seed (default: 101)")
    gusts.add_argument("--rounds", type=int, default=10, help="most rounds (default: 10)")
    gusts.add_argument(
        "--tolerance", type=float, default=3.0, metavar="PERCENT", help="of the means (default: 3)"
    )
    gusts.add_argument("--params-file", type=Path, help="parameters of the nodes to begin with")
    gusts.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    gusts.set_defaults(func=run)


def run(options: argparse.Namespace) -> int:
    """Calibrate, say every round, write the file.

    Raises:
        InputError: a number out of range, a plan in still air, a target that is not met, no file.
    """
    from heli_flight import gust_calibration as gusts  # slow to load
    from heli_flight.published_flights import LQ_HOVER

    last = options.first + options.seeds - 1
    require_between(options.seeds, 1, _MOST_SEEDS, "--seeds")
    if options.first < 0 or last > _LARGEST_SEED:
        raise InputError(f"{options.first}", allowed=f"0 .. {_LARGEST_SEED}", key="--first")
    require_between(options.rounds, 1, 100, "--rounds")
    require_between(options.tolerance, 0.1, 50, "--tolerance")
    require_between(options.workers, 1, MOST_WORKERS, "--workers")
    plan = gusts.require_gusty(load_plan(options.plan))
    values = read_parameters(options.params_file) if options.params_file else DEFAULTS
    if options.out.is_dir() or not options.out.absolute().parent.is_dir():
        raise InputError("cannot be written", allowed="a file in a folder that is there", file=options.out)
    say = sys.stdout.write
    say("sigma x y z [cm], psi [deg]     strengths x y z [m/s], yaw [N m]\n")

    def tell(entry: gusts.Round) -> None:
        strengths = " ".join(f"{value:8.4g}" for value in entry.strengths)
        if entry.sigmas is None:
            say(f"lost: {entry.failure}   {strengths}\n")
        else:
            x, y, z, psi = entry.sigmas
            say(f"{100 * x:6.2f} {100 * y:6.2f} {100 * z:6.2f}  {math.degrees(psi):6.2f}   {strengths}\n")
        sys.stdout.flush()

    found = gusts.calibrate(
        partial(gusts.sigmas_of, plan=plan, values=values),
        LQ_HOVER,
        gusts.start_strengths(values),
        range(options.first, last + 1),
        tolerance=0.01 * options.tolerance,
        most_rounds=options.rounds,
        workers=options.workers,
        tell=tell,
    )
    command = f"heli calibrate gusts --plan {plan.name} --seeds {options.seeds} --first {options.first}"
    write_atomically(options.out, gusts.parameter_text(found, plan, command))
    say(f"ours over printed: {' '.join(f'{ratio:.3f}' for ratio in found.ratios)}\n{options.out}\n")
    return 0
