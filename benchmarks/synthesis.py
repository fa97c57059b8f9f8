"""How long a certified H-infinity design takes, beside the library's own call on the same problem.

Run: python benchmarks/synthesis.py [--model FILE] [--runs N] [--json]. The horizontal plant with eight
states and two inputs: S/KS/T and GS/T certified by both routes, loop shaping in closed form, and
`control.mixsyn` with the weights of S/KS/T, whose result is certified here too, for it says nothing of
itself. Processor times.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import control
from rich.console import Console
from rich.table import Table

from heli_common.model_file import ModelFile
from heli_control.certificate import certify
from heli_control.flight_plants import flight_plant
from heli_control.realisation import Realisation
from heli_control.schemes import mixed_sensitivity_problem, synthesis
from heli_control.weights_file import default_weights

MODEL = Path(__file__).parent.parent / "heli_control" / "test" / "data" / "hover_model.yaml"
AXIS = "horizontal"


def timed(work: Callable[[], Any], runs: int) -> tuple[float, Any]:
    """Median processor time of a call [ms] after one to warm up, and its last result."""
    work()
    times, result = [], None
    for _ in range(runs):
        begin = process_time()
        result = work()
        times.append(process_time() - begin)
    return 1e3 * median(times), result


def ours(kind: str, model: ModelFile, runs: int) -> dict[str, Any]:
    """A certified design of one axis."""
    weights = default_weights(kind).axes[AXIS]
    plant = flight_plant(model, AXIS, weights.scales)
    time, made = timed(lambda: synthesis(kind, plant, weights), runs)
    return {
        "design": f"{kind}, certified",
        "plant_states": plant.scaled.order,
        "controller_states": len(made.controller.states),
        "ms": time,
        "gamma_claimed": made.gamma,
        "norm_certified": made.norm,
    }


def mixsyn(model: ModelFile, runs: int) -> dict[str, Any]:
    """The library's mixed sensitivity synthesis with the weights of S/KS/T, and what its loop really is."""
    weights = default_weights("skst").axes[AXIS]
    plant = flight_plant(model, AXIS, weights.scales)
    parts = [weights.stacked(name) for name in ("W_e", "W_u", "W_y")]
    g, *w = (control.ss(*system) for system in (plant.scaled, *parts))
    time, (found, _, (gamma, *_)) = timed(lambda: control.mixsyn(g, *w), runs)
    controller = Realisation(found.A, found.B, found.C, found.D)
    said = float(gamma)
    problem = mixed_sensitivity_problem("skst", plant, weights)
    certificate = certify(problem, controller, said)
    return {
        "design": "control.mixsyn, as it is",
        "plant_states": plant.scaled.order,
        "controller_states": controller.order,
        "ms": time,
        "gamma_claimed": said,
        "norm_certified": certificate.norm,
    }


def main() -> None:
    """Time and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--model", type=Path, default=MODEL, help="model file (default: the linearised bench)"
    )
    parser.add_argument("--runs", type=int, default=10, help="timed runs of each (default: 10)")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    options = parser.parse_args()
    warnings.simplefilter("ignore", FutureWarning)  # what the library says of its own calls
    model = ModelFile.read(options.model)
    rows = [ours(kind, model, options.runs) for kind in ("skst", "gst", "ncf", "ncf2")]
    rows.append(mixsyn(model, options.runs))
    if options.json:
        sys.stdout.write(json.dumps(rows, indent=2) + "\n")
        return
    table = Table("design", "plant states", "controller states", "ms", "gamma claimed", "norm certified")
    for row in rows:
        table.add_row(
            row["design"],
            str(row["plant_states"]),
            str(row["controller_states"]),
            f"{row['ms']:.1f}",
            f"{row['gamma_claimed']:.4f}",
            f"{row['norm_certified']:.4f}",
        )
    Console(highlight=False).print(table)


if __name__ == "__main__":
    main()
