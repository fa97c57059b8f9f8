"""Why the source found X_u = -1.07 and Y_v = -1.19 1/s: the arms' friction, identified at three speeds.

Run: python benchmarks/friction.py [--seed N] [--workers N] [--out PICTURE] [--json]. Flies the plan
arm_friction on three benches: with the friction of spec 2.1, with its viscous part alone, without friction.
In each flight the servo-rotor structure is estimated from the excited cyclics, then X_u, X_1, Y_v, Y_2 anew
from the doublets of the velocity reference and from the position steps. Dry friction F acts on a sine of
velocity of amplitude a like the damping 4 F / (pi m a); a is taken as sqrt(2) times the rms.
"""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from math import pi, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from identification_bench import FRICTIONLESS, bench_model
from matplotlib import rc_context
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from heli_bench_sim.arm_friction import ArmFrictionParameters
from heli_bench_sim.parameters import PARAMETER_SETS
from heli_common.errors import EXIT_FLOWN
from heli_common.flight_state import FlightState
from heli_control.controller_file import load_controller
from heli_flight.chain import AFTER, excited_segments
from heli_flight.flight_record import FlightRecord
from heli_flight.fly_in_process import fly_in_process
from heli_flight.identification import Choice, identify
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import load_plan
from heli_identification.parametrisation import Noise
from heli_identification.preparation import Segment

BENCHES = {
    "friction of spec 2.1": "",
    "viscous alone": "/**/bench_sim:\n  ros__parameters:\n    friction.coulomb: 0.0\n"
    "    friction.gimbal: 0.0\n",
    "no friction": FRICTIONLESS,
}
AGAIN = ("X_u", "X_1", "Y_v", "Y_2")
STEPS = "position steps of 0.6 m"


@dataclass(frozen=True)
class Found:
    """One estimate: of which bench and motion, speeds rms [m/s], X_u and Y_v [1/s] and standard errors."""

    bench: str
    motion: str
    speeds: tuple[float, float]
    values: tuple[float, float]
    errors: tuple[float, float]


class Motion(NamedTuple):
    """What is estimated from, and where it moves: ahead and to the right, or both at once."""

    pieces: tuple[Segment, ...]
    spans: tuple[Segment, ...]


def motions(record: FlightRecord) -> dict[str, Motion]:
    """The three kinds of motion in the flight."""
    plan = load_plan("arm_friction")
    cyclic = tuple(excited_segments(record, plan, ("B_1s", "A_1s")))
    doublets = tuple(excited_segments(record, plan, (name,))[0] for name in ("u", "v"))
    landing = next(each.start_ns for each in record.stages if each.state is FlightState.LANDING) * 1e-9
    begin, end = (doublets[1].end or 0.0) + AFTER + 2.0, landing - 2.0
    middle = 0.5 * (begin + end)
    return {
        "cyclic excited": Motion(cyclic, cyclic),
        "doublets of the velocity reference": Motion(doublets, doublets),
        STEPS: Motion((Segment(begin, end),), (Segment(begin, middle), Segment(middle, end))),
    }


def flown(job: tuple[str, int]) -> list[Found]:
    """Fly one bench and estimate."""
    bench, seed = job
    with TemporaryDirectory() as temporary:
        folder, parameters = Path(temporary), None
        if BENCHES[bench]:
            parameters = folder / "parameters.yaml"
            parameters.write_text(BENCHES[bench])
        plan = load_plan("arm_friction")
        name = plan.controllers[0]
        order = FlightOrder(
            plan, plan.name, Mode.INPROCESS, seed, load_controller(name), name, folder / "bag", parameters
        )
        end = fly_in_process(order, lambda _: None)
        if end.exit_code != EXIT_FLOWN:
            raise RuntimeError(f"{bench}: {end.reason}")
        record = FlightRecord.load(order.bag)
        found, prior = [], None
        for motion, (pieces, spans) in motions(record).items():
            choice = Choice(noise=Noise.OUTPUT_ERROR, estimate=pieces, free=AGAIN if prior else None)
            identified = identify([record], choice, prior)
            prior = prior or identified.model("cyclic", None)
            estimate = identified.estimate
            places = [estimate.names.index(each) for each in ("X_u", "Y_v")]
            found.append(
                Found(
                    bench,
                    motion,
                    speeds(record, spans),
                    (float(estimate.values[places[0]]), float(estimate.values[places[1]])),
                    (float(estimate.errors[places[0]]), float(estimate.errors[places[1]])),
                )
            )
        return found


def speeds(record: FlightRecord, spans: tuple[Segment, ...]) -> tuple[float, float]:
    """Rms of u and v, each over that span in which it moves more [m/s]."""
    time, velocity = record.truth.time, record.truth.velocity[:, :2]
    rms = [
        np.sqrt(np.mean(velocity[(time >= (span.begin or 0.0)) & (time <= (span.end or 0.0))] ** 2, axis=0))
        for span in spans
    ]
    u, v = np.array(rms).max(axis=0).tolist()
    return u, v


def expected(speed: float, viscous: float, coulomb: float) -> float:
    """-X_u or -Y_v by viscous and dry friction [1/s] at a speed rms [m/s]."""
    mass = PARAMETER_SETS["thesis"]().mass
    return (viscous + 4.0 * coulomb / (pi * sqrt(2.0) * speed)) / mass


def draw(found: list[Found], path: Path) -> None:
    """Damping found against speed, with what viscous and dry friction give."""
    arms = ArmFrictionParameters()
    figure = Figure(figsize=(7.5, 4.2), layout="constrained")
    axes = figure.add_subplot()
    grid = np.geomspace(0.015, 0.4, 80)
    for index, (name, viscous, colour) in enumerate(
        (("X_u", arms.viscous_x, "tab:blue"), ("Y_v", arms.viscous_y, "tab:orange"))
    ):
        label = f"-{name}: viscous + 4 F / ($\\pi$ m a)"
        axes.plot(grid, [expected(s, viscous, arms.coulomb) for s in grid], color=colour, lw=1, label=label)
        axes.axhline(viscous / PARAMETER_SETS["thesis"]().mass, color=colour, lw=1, ls=":")
        for bench, marker in zip(BENCHES, "osx", strict=True):
            rows = [each for each in found if each.bench == bench]
            axes.errorbar(
                [each.speeds[index] for each in rows],
                [-each.values[index] for each in rows],
                yerr=[1.96 * each.errors[index] for each in rows],
                fmt=marker,
                color=colour,
                label=f"-{name}, {bench}",
            )
    source = {"X_u": 1.0724, "Y_v": 1.1887}
    for (name, value), colour in zip(source.items(), ("tab:blue", "tab:orange"), strict=True):
        axes.annotate(f"source {name}", (0.42, value), color=colour, fontsize=8, va="center")
    axes.set(
        xscale="log",
        xlabel="speed, rms [m/s]",
        ylabel="damping found [1/s]",
        ylim=(-0.2, 2.5),
        xlim=(0.014, 0.62),
    )
    axes.set_xticks([0.02, 0.05, 0.1, 0.2, 0.4], labels=["0.02", "0.05", "0.1", "0.2", "0.4"])
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7, ncols=2)
    with rc_context({"svg.hashsalt": "arm_friction"}):  # the same bytes from the same figures
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def show(found: list[Found]) -> None:
    """Print the table."""
    arms = ArmFrictionParameters()
    table = Table("bench", "motion", "u rms [m/s]", "X_u [1/s]", "v rms [m/s]", "Y_v [1/s]", "4 F / (pi m a)")
    for each in found:
        (u, v), (x, y), (dx, dy) = each.speeds, each.values, each.errors
        dry = " / ".join(f"{expected(s, 0.0, arms.coulomb):.2f}" for s in (u, v))
        said = dry if each.bench == next(iter(BENCHES)) else ""
        table.add_row(
            each.bench,
            each.motion,
            f"{u:.3f}",
            f"{x:.3f} +- {dx:.3f}",
            f"{v:.3f}",
            f"{y:.3f} +- {dy:.3f}",
            said,
        )
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 150)
    console.print(table)
    for name, friction in (("with the arms' viscous friction", True), ("without friction", False)):
        model = bench_model(friction)
        u, v = (model.A[model.states.index(state), model.states.index(state)] for state in "uv")
        console.print(f"exact, the bench linearised {name}: X_u {u:.3f}, Y_v {v:.3f}")


def main() -> None:
    """Fly, estimate, print, draw."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=1, help="of the flights (default: 1)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--out", type=Path, metavar="PICTURE", help="damping against speed, .svg or .png")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    told, found = Console(stderr=True, highlight=False), []
    with ProcessPoolExecutor(options.workers) as pool:
        for done, rows in enumerate(pool.map(flown, [(bench, options.seed) for bench in BENCHES]), 1):
            found += rows
            told.print(f"{done} of {len(BENCHES)} benches")
    if options.out:
        draw(found, options.out)
    if options.json:
        sys.stdout.write(json.dumps([asdict(each) for each in found], indent=2) + "\n")
    else:
        show(found)


if __name__ == "__main__":
    main()
