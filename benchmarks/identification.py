"""Identification on the linear twin: are claimed errors true, how near is the Cramer-Rao bound, what does
it cost.

Run: python benchmarks/identification.py [--seeds N] [--first SEED] [--workers N] [--json] [--approaches]
[--bench] [--peers PYTHON]. Flies the servo-rotor model with the arms' friction in closed loop at 100 Hz, with
gusts and the navigation's noise, once for each seed, as the identification plan (F5) does: 60 s under a PRBS
on both cyclics, 30 s under a multisine on the velocity references. Every flight is estimated from perturbed
start values. --approaches compares direct, projection, indirect and joint approach in white and in coloured
gusts instead. --bench flies the nonlinear bench instead, with friction and a fifth of the seeds without.
--peers names a Python that has sippy-unipi; its ARMAX is timed on the first 60 s of the same data.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from math import radians
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import Any

import numpy as np
from identification_bench import run_bench, show_bench
from rich.console import Console
from rich.table import Table

from heli_common.errors import InputError
from heli_identification.cramer_rao import bound
from heli_identification.excitation_signals import multisine
from heli_identification.helicopter_structures import SERVO_ROTOR
from heli_identification.indirect import indirect
from heli_identification.linear_twin import Disturbance, Twin, lq_feedback
from heli_identification.prediction_error import Estimate, prediction_error
from heli_identification.projection import projection
from heli_identification.records import Record
from heli_identification.structures import Structure
from heli_identification.uncertainty import QUANTILE_95

PERIOD, DELAY = 0.01, 1
SECONDS, REFERENCE_SECONDS = 60.0, 30.0
PEER_SCRIPT = Path(__file__).parent / "identification_peers.py"

FRICTION = {"X_u": -0.0148 - 7.7 / 7.3, "Y_v": -0.0148 - 8.6 / 7.3}
"""Speed damping with the arms' viscous friction on 7.3 kg (spec 2.1)."""

GUST = {"u": 0.003, "v": 0.003, "q": 0.01, "p": 0.01}
"""Process noise per step, standard deviation [m/s, rad/s]."""
NOISE = {"theta": 1e-3, "phi": 1e-3, "u": 5e-3, "v": 5e-3, "q": 1e-2, "p": 1e-2}
"""Measurement noise, standard deviation [rad, m/s, rad/s]: about that of the navigation."""
GUST_TIME = 1.5
"""Correlation time of coloured gusts [s] (spec 2.7)."""
START_ERROR = 0.2
"""Relative standard deviation of the start values."""
AMPLITUDE = radians(0.8)
"""Of the PRBS on each cyclic."""
REFERENCE, REFERENCE_BAND = 0.35, (1.0, 4.0)
"""Multisine on both velocity references: peak [m/s], band [rad/s]."""
APPROACHES = ("direct", "projection", "indirect", "joint")


def truth() -> Structure:
    """The bench's horizontal motion within the structure, friction included."""
    return SERVO_ROTOR.with_values(FRICTION)


def twin(correlation_time: float = 0.0) -> Twin:
    """The closed loop."""
    structure = truth()
    process = np.array([GUST.get(name, 0.0) for name in structure.states])
    measurement = np.array([NOISE[name] for name in structure.outputs])
    feedback = lq_feedback(structure, PERIOD)
    return Twin(structure, feedback, Disturbance(process, measurement, correlation_time), PERIOD, DELAY)


def excitation(rng: np.random.Generator, seconds: float = SECONDS) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Independent random binary signals on both cyclics, held for 80 ms [rad], shape (N, 2)."""
    count, hold = round(seconds / PERIOD), 8
    signs = rng.choice([-1.0, 1.0], size=(count // hold + 1, 2))
    return AMPLITUDE * np.repeat(signs, hold, axis=0)[:count]


def reference_excitation(rng: np.random.Generator) -> np.ndarray[Any, np.dtype[np.float64]]:
    """What a multisine on the references of u and v makes of the cyclics [rad], shape (N, 2)."""
    count = round(REFERENCE_SECONDS / PERIOD)
    lines = [multisine(count, REFERENCE_BAND, rng, place, 2) for place in range(2)]
    feedback = lq_feedback(truth(), PERIOD)
    gain = -feedback.D[:, [feedback.inputs.index(name) for name in ("u", "v")]]
    return REFERENCE * np.column_stack(lines) @ gain.T


def flight(seed: int, correlation_time: float = 0.0) -> list[Record]:
    """The data of one seed: cyclics excited, then the references."""
    rng = np.random.default_rng([seed, 6])
    flown = twin(correlation_time)
    return [flown.fly(each(rng), rng, f"seed {seed}") for each in (excitation, reference_excitation)]


def start(seed: int) -> Structure:
    """The structure with perturbed values."""
    rng, structure = np.random.default_rng([seed, 7]), truth()
    index = structure.index(structure.free_names)
    moved = structure.values[index] * (1.0 + START_ERROR * rng.standard_normal(len(index)))
    return structure.with_values(dict(zip(structure.free_names, moved.tolist(), strict=True)))


def estimated(approach: str, seed: int, records: list[Record]) -> Estimate:
    """An estimate by one approach."""
    if approach == "direct":
        return prediction_error(start(seed), records)
    if approach == "projection":
        return projection(start(seed), records)
    feedback = lq_feedback(truth(), PERIOD)
    return indirect(start(seed), records, feedback, delay=DELAY, joint=approach == "joint")


@dataclass(frozen=True)
class Trial:
    """One estimate; errors, bounds: standard errors claimed and smallest possible; None if it failed."""

    seed: int
    seconds: float
    values: tuple[float, ...] | None
    errors: tuple[float, ...] = ()
    bounds: tuple[float, ...] = ()
    white: bool = True
    failure: str = ""


def trial(job: tuple[str, int, float]) -> Trial:
    """Fly and estimate one seed."""
    approach, seed, correlation_time = job
    records = flight(seed, correlation_time)
    begin = process_time()
    try:
        found = estimated(approach, seed, records)
    except InputError as error:
        return Trial(seed, process_time() - begin, None, failure=error.problem)
    used = process_time() - begin
    if not found.converged:
        return Trial(seed, used, None, failure="did not converge")
    bounds = np.sqrt(np.diag(bound(twin(correlation_time), records)))
    return Trial(
        seed,
        used,
        tuple(found.values.tolist()),
        tuple(found.errors.tolist()),
        tuple(bounds.tolist()),
        found.white,
    )


def fly(jobs: list[tuple[str, int, float]], workers: int, console: Console) -> list[Trial]:
    """All trials; tells how far it is."""
    found: list[Trial] = []
    begin = perf_counter()
    with ProcessPoolExecutor(workers) as pool:
        for done, result in enumerate(pool.map(trial, jobs), 1):
            found.append(result)
            left = (len(jobs) - done) * (perf_counter() - begin) / done
            if done % 5 == 0 or done == len(jobs):
                console.print(f"{done} of {len(jobs)} estimates, about {left:.0f} s left", highlight=False)
    return found


def statistics(trials: list[Trial]) -> dict[str, Any]:
    """Bias, spread, claims and coverage by coefficient, pooled coverage, time and failures."""
    good = [each for each in trials if each.values is not None]
    failures = [f"seed {each.seed}: {each.failure}" for each in trials if each.values is None]
    if len(good) < 2:
        return {"failures": failures, "parameters": {}, "estimates": len(good)}
    structure = truth()
    true = structure.values[structure.index(structure.free_names)]
    values = np.array([each.values for each in good])
    errors, bounds = np.array([each.errors for each in good]), np.array([each.bounds for each in good])
    inside = np.abs(values - true) <= QUANTILE_95 * errors
    parameters = {}
    for index, name in enumerate(structure.free_names):
        spread, least = float(values[:, index].std(ddof=1)), float(np.sqrt(np.mean(bounds[:, index] ** 2)))
        parameters[name] = {
            "true": float(true[index]),
            "bias": float(values[:, index].mean() - true[index]),
            "spread": spread,
            "claimed": float(errors[:, index].mean()),
            "cramer_rao": least,
            "spread_by_bound": spread / least,
            "inside": int(inside[:, index].sum()),
        }
    return {
        "estimates": len(good),
        "parameters": parameters,
        "pooled_inside": float(inside.mean()),
        "white": int(sum(each.white for each in good)),
        "seconds_median": median(each.seconds for each in good),
        "failures": failures,
    }


def speed() -> float:
    """Best of five estimates of 60 s after compilation [CPU s], on one core."""
    record = flight(1)[0]
    times = []
    for _ in range(5):
        begin = process_time()
        prediction_error(start(1), [record])
        times.append(process_time() - begin)
    return min(times)


def peer(python: str) -> dict[str, Any]:
    """What SIPPY's ARMAX takes and fits on the data of seed 1, in an environment of its own."""
    record = flight(1)[0]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "record.npz"
        np.savez(path, u=record.u, y=record.y, period=record.period)
        answer = subprocess.run(
            [python, str(PEER_SCRIPT), str(path)],
            capture_output=True,
            text=True,
            check=False,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": ""},
        )
    try:
        found: dict[str, Any] = json.loads(answer.stdout.strip().splitlines()[-1])
    except (IndexError, json.JSONDecodeError):
        found = {"missing": (answer.stderr.strip().splitlines() or ["no answer"])[-1]}
    return found


def show(title: str, found: dict[str, Any]) -> None:
    """Print statistics as a table."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=120)
    table = Table("coefficient", title=f"{title}: {found['estimates']} estimates")
    for column in ("true", "bias", "spread", "claimed", "bound", "spread / bound", "inside 95 %"):
        table.add_column(column, justify="right")
    for name, row in found["parameters"].items():
        numbers = [f"{row[key]:.4g}" for key in ("true", "bias", "spread", "claimed", "cramer_rao")]
        table.add_row(
            name, *numbers, f"{row['spread_by_bound']:.2f}", f"{row['inside']} of {found['estimates']}"
        )
    console.print(table)
    if found["parameters"]:
        console.print(
            f"pooled inside {100.0 * found['pooled_inside']:.1f} %, white residuals {found['white']}, "
            f"median {found['seconds_median']:.2f} CPU s"
        )
    for failure in found["failures"]:
        console.print(f"failed: {failure}")


def main() -> None:
    """Fly, estimate, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--bench", action="store_true", help="fly the nonlinear bench, not the linear twin")
    parser.add_argument("--noise", default="output_error", help="model of the disturbances for --bench")
    parser.add_argument("--seeds", type=int, default=50, help="flights (default: 50)")
    parser.add_argument("--first", type=int, default=1, help="first seed (default: 1)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--approaches", action="store_true", help="compare the four approaches")
    parser.add_argument("--peers", metavar="PYTHON", help="a Python that has sippy-unipi")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    if options.seeds < 2:
        parser.error(f"--seeds {options.seeds} is less than 2")
    told, seeds = Console(stderr=True), range(options.first, options.first + options.seeds)
    result: dict[str, Any] = {}
    if options.bench:
        found = run_bench(
            seeds, options.workers, options.noise, lambda text: told.print(text, highlight=False)
        )
        if options.json:
            sys.stdout.write(json.dumps(found, indent=2) + "\n")
        else:
            show_bench(found, Console(highlight=False, width=None if sys.stdout.isatty() else 150))
        return
    if options.approaches:
        for gust, time in (("white", 0.0), ("coloured", GUST_TIME)):
            for approach in APPROACHES:
                told.print(f"{approach}, {gust} gusts", highlight=False)
                trials = fly([(approach, seed, time) for seed in seeds], options.workers, told)
                result[f"{approach}, {gust} gusts"] = statistics(trials)
    else:
        trials = fly([("direct", seed, 0.0) for seed in seeds], options.workers, told)
        result["direct, white gusts"] = statistics(trials)
    tables = dict(result)
    result["seconds_for_60_s"] = speed()
    if options.peers:
        result["sippy_armax"] = peer(options.peers)
    if options.json:
        sys.stdout.write(json.dumps(result, indent=2) + "\n")
        return
    for title, found in tables.items():
        show(title, found)
    said = Console(highlight=False)
    said.print(f"servo-rotor structure, 60 s at 100 Hz: {result['seconds_for_60_s']:.2f} CPU s (best of 5)")
    if options.peers:
        said.print(f"SIPPY ARMAX on the same data: {result['sippy_armax']}")


if __name__ == "__main__":
    main()
