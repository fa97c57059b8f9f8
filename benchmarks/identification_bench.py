"""The identification flight on the nonlinear bench, seed after seed: bias, spread, claims, and where bias
comes from. Called by `identification.py --bench`.

Truth is the bench linearised at its own trim with the arms' viscous friction. The same estimate from
noiseless data of exactly that linear model shows what the structure and the search alone do to a coefficient;
what is left beyond it is the bench's: dry friction, navigation, servos, large angles, not told apart here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from heli_bench_sim import linearize
from heli_bench_sim.arm_friction import ArmFrictionParameters
from heli_bench_sim.parameters import PARAMETER_SETS
from heli_bench_sim.trim import trim
from heli_common.errors import EXIT_FLOWN, InputError
from heli_control.controller_file import load_controller
from heli_control.rig_plant import with_friction
from heli_flight.chain import excited_segments
from heli_flight.flight_record import FlightRecord
from heli_flight.fly_in_process import fly_in_process
from heli_flight.identification import Choice, identify
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import Plan, parse_plan
from heli_identification.helicopter_structures import SERVO_ROTOR
from heli_identification.linear_twin import Disturbance, Twin, lq_feedback
from heli_identification.parametrisation import Noise
from heli_identification.prediction_error import prediction_error
from heli_identification.structures import Structure, Term
from heli_identification.uncertainty import QUANTILE_95

CYCLIC = ("B_1s", "A_1s")
PLAN = """
name: cyclic
about: the part of the identification flight that the horizontal axis is estimated from
seed: {seed}
controller: lq
phases:
  - home: {{duration: 8.0}}
  - run_up: {{duration: 6.0}}
  - take_off: {{height: 0.0, speed: 0.15}}
  - hover: {{duration: 3.0}}
  - excite:
      signal: prbs
      channels: [B_1s, A_1s]
      amplitude_deg: 0.8
      band_rad_s: [0.5, 12]
      duration: 60.0
      seed: {seed}
  - land: {{speed: 0.4}}
  - run_down: {{duration: 0.5}}
"""
FRICTIONLESS = "/**/bench_sim:\n  ros__parameters:\n" + "".join(
    f"    friction.{name}: 0.0\n" for name in ("viscous_x", "viscous_y", "viscous_z", "coulomb", "gimbal")
)
SAME = 0.25
"""A cause is named where it explains the bias but for this share of it, or for two standard errors."""


@dataclass(frozen=True)
class Flown:
    """One seed; `values`, claimed `errors` and `bounds` (Cramer-Rao), empty with a `failure`."""

    seed: int
    values: tuple[float, ...] = ()
    errors: tuple[float, ...] = ()
    bounds: tuple[float, ...] = ()
    failure: str = ""


def bench_model(friction: bool) -> Any:
    """The bench's linear horizontal motion, with the arms' viscous friction or without."""
    helicopter = PARAMETER_SETS["thesis"]()
    model = linearize.horizontal(helicopter, trim(helicopter))
    arms = ArmFrictionParameters()
    viscous = {"u": arms.viscous_x, "v": arms.viscous_y} if friction else {"u": 0.0, "v": 0.0}
    return with_friction(model, viscous, helicopter.mass)


def truth(friction: bool) -> Structure:
    """The structure with the bench's values."""
    return SERVO_ROTOR.from_model(bench_model(friction))


def structure_alone(friction: bool, excitation: Any) -> dict[str, float]:
    """What the structure makes of data that the bench's linear model itself has flown, without noise."""
    model = bench_model(friction)
    terms = [
        Term(row, column, float(matrix[i, j]))
        for matrix, columns in ((model.A, model.states), (model.B, model.inputs))
        for i, row in enumerate(model.states)
        for j, column in enumerate(columns)
        if matrix[i, j] != 0.0
    ]
    whole = Structure("bench", model.states, model.inputs, model.outputs, (), tuple(terms), ())
    quiet = Disturbance(np.zeros(len(model.states)), np.full(len(model.outputs), 1e-5))
    twin = Twin(whole, lq_feedback(whole, 0.01), quiet, 0.01, 1)
    record = twin.fly(excitation, np.random.default_rng(1), "linear bench")
    found = prediction_error(truth(friction), [record], noise=Noise.OUTPUT_ERROR)
    return dict(zip(found.names, found.values.tolist(), strict=True))


def fly(seed: int, folder: Path, friction: bool) -> tuple[FlightRecord, Plan] | str:
    """The flight of a seed, or why it ended early."""
    plan, parameters = parse_plan(PLAN.format(seed=seed)), None
    if not friction:
        parameters = folder / f"parameters_{seed}.yaml"
        parameters.write_text(FRICTIONLESS)
    order = FlightOrder(
        plan, plan.name, Mode.INPROCESS, seed, load_controller("lq"), "lq", folder / f"{seed}", parameters
    )
    end = fly_in_process(order, lambda _: None)
    return (FlightRecord.load(order.bag), plan) if end.exit_code == EXIT_FLOWN else end.reason


def bench_trial(job: tuple[int, bool, str]) -> Flown:
    """Fly and estimate one seed."""
    seed, friction, noise = job
    with TemporaryDirectory() as folder:
        flight = fly(seed, Path(folder), friction)
        if isinstance(flight, str):
            return Flown(seed, failure=flight)
        segments = tuple(excited_segments(*flight, CYCLIC))
        try:
            found = identify([flight[0]], Choice(noise=Noise(noise), estimate=segments)).estimate
        except InputError as error:
            return Flown(seed, failure=error.problem)
    if not found.converged:
        return Flown(seed, failure="did not converge")
    bounds = np.sqrt(np.diag(found.fisher))
    return Flown(seed, *(tuple(column.tolist()) for column in (found.values, found.errors, bounds)))


def bench_statistics(trials: Sequence[Flown], friction: bool, alone: dict[str, float]) -> dict[str, Any]:
    """By coefficient: truth, mean, bias, spread, claims, share inside, the structure's part, cause."""
    good = [each for each in trials if each.values]
    failures = [f"seed {each.seed}: {each.failure}" for each in trials if each.failure]
    structure, parameters = truth(friction), {}
    true = structure.values[structure.index(structure.free_names)]
    columns = [np.array([getattr(each, name) for each in good]) for name in ("values", "errors", "bounds")]
    for index, name in enumerate(structure.free_names):
        values, errors, bounds = (column[:, index] for column in columns)
        bias, spread = float(values.mean() - true[index]), float(values.std(ddof=1))
        parameters[name] = {
            "true": float(true[index]),
            "mean": float(values.mean()),
            "bias": bias,
            "spread": spread,
            "claimed": float(errors.mean()),
            "spread_by_bound": spread / float(np.sqrt(np.mean(bounds**2))),
            "inside": int(np.sum(np.abs(values - true[index]) <= QUANTILE_95 * errors)),
            "structure_alone": alone[name] - float(true[index]),
            "cause": cause(
                name, bias, spread / np.sqrt(len(good)), alone[name] - float(true[index]), friction
            ),
        }
    kept = {each.name: each.reason for each in structure.parameters if not each.free}
    return {"estimates": len(good), "parameters": parameters, "not_identifiable": kept, "failures": failures}


def cause(name: str, bias: float, error: float, structure: float, friction: bool) -> str:
    """Which part of the bias noiseless data show; `structure` is their bias."""
    if abs(bias) <= 2.0 * error:
        return "none seen"
    if abs(bias - structure) <= max(SAME * abs(bias), 2.0 * error):
        return "structure"
    left = "bench beyond its linear model"
    if friction and name in ("X_u", "Y_v") and bias - structure < 0.0:
        left = "friction beyond the viscous"
    return left if abs(structure) < SAME * abs(bias) else f"structure, {left}"


def run_bench(seeds: Sequence[int], workers: int, noise: str, tell: Callable[[str], None]) -> dict[str, Any]:
    """Every seed with friction, the first fifth without; statistics of both.

    Args:
        seeds: two or more.
        workers: processes.
        noise: model of the disturbances.
        tell: how far it is.
    """
    few = seeds[: max(2, len(seeds) // 5)]
    jobs = [(seed, True, noise) for seed in seeds] + [(seed, False, noise) for seed in few]
    trials, begin = [], perf_counter()
    with ProcessPoolExecutor(workers) as pool:
        for done, each in enumerate(pool.map(bench_trial, jobs), 1):
            trials.append(each)
            left = (len(jobs) - done) * (perf_counter() - begin) / done
            tell(f"{done} of {len(jobs)} flights, about {left:.0f} s left")
    rng = np.random.default_rng([1, 6])
    signs = np.repeat(rng.choice([-1.0, 1.0], size=(750, 2)), 8, axis=0)
    found = {}
    for friction, part in ((True, trials[: len(seeds)]), (False, trials[len(seeds) :])):
        name = "friction of spec 2.1" if friction else "friction.* zero"
        found[name] = bench_statistics(part, friction, structure_alone(friction, np.radians(0.8) * signs))
    return found


def show_bench(found: dict[str, Any], console: Console) -> None:
    """Print both tables."""
    for title, part in found.items():
        count = part["estimates"]
        table = Table("coefficient", title=f"{title}: {count} flights of 60 s on the nonlinear bench")
        for column in ("true", "mean", "bias", "of it structure", "spread", "claimed", "spread / bound"):
            table.add_column(column, justify="right")
        table.add_column("inside 95 %")
        table.add_column("cause of bias")
        for name, row in part["parameters"].items():
            numbers = [
                f"{row[key]:.4g}"
                for key in ("true", "mean", "bias", "structure_alone", "spread", "claimed", "spread_by_bound")
            ]
            table.add_row(name, *numbers, f"{row['inside']} of {count}", row["cause"])
        console.print(table)
        for name, reason in part["not_identifiable"].items():
            console.print(f"{name} is not identifiable: {reason}")
        for failure in part["failures"]:
            console.print(f"failed: {failure}")
