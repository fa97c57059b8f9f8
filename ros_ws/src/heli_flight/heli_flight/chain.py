"""From a flight to a controller and back: fly F5, identify, design, fly F2 with both models' controllers.

The identified model's controllers are judged in the same hovers as the shipped ones, which were designed from
the linearised bench: same seeds, same gusts. The identified model starts from the source's values, never
from those of the bench.
"""

from __future__ import annotations

import dataclasses
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np

from heli_common.errors import EXIT_FLOWN, InputError
from heli_common.model_file import ModelFile
from heli_common.topics import TOPICS
from heli_control.controller_designs import design
from heli_control.controller_file import load_controller
from heli_flight.flight_record import FlightRecord
from heli_flight.fly_in_process import fly_in_process
from heli_flight.identification import Choice, Identified, identify
from heli_flight.metrics import flight_metrics
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import Plan, load_plan
from heli_flight.worker_pool import Workers
from heli_identification.parametrisation import Noise
from heli_identification.preparation import Segment

KINDS = ("gst2", "ncf2")
"""Controllers of the chain (spec 4)."""
MODELS = ("identified", "linearised")
AXES = ("sigma_x_m", "sigma_y_m", "sigma_z_m", "sigma_psi_rad")
LARGEST_RATIO = 1.1
"""Of the mean sigmas of hover, identified over linearised (issue: shows)."""
PARTS = (
    ("horizontal", "servo_rotor", ("B_1s", "A_1s"), ()),
    ("vertical", "vertical", ("theta_0", "theta_t"), ("k_w", "k_r")),
)
"""Block, structure, channels that excite it, coefficients kept: the inflow's answer to motion is not seen."""
LEAST_FIT = 50.0
"""A block that explains less of every validation output stays as its prior [%]."""
BEFORE, AFTER = 0.5, 0.0
"""What is left out at the ends of an excitation [s]."""

Tell = Callable[[str, int, int], None]
"""Called with what is being done, how many hovers are flown and of how many; zeros before the first."""


@dataclass(frozen=True)
class Hover:
    """One hover: `sigmas` in the order of AXES, empty with a `failure` if it was not flown to its end."""

    kind: str
    model: str
    seed: int
    sigmas: tuple[float, ...]
    failure: str = ""


@dataclass(frozen=True, eq=False)
class Chain:
    """What came out; `blocks` are those identified, `remarks` say what was not."""

    model: Path
    blocks: dict[str, Identified]
    remarks: tuple[str, ...]
    hovers: tuple[Hover, ...]

    def mean_sigmas(self, kind: str, model: str) -> tuple[float, ...]:
        """Mean over the seeds, in the order of AXES; empty if no hover was flown."""
        flown = [each.sigmas for each in self.hovers if (each.kind, each.model) == (kind, model)]
        return tuple(mean(column) for column in zip(*[row for row in flown if row], strict=True))

    def ratios(self, kind: str) -> tuple[float, ...]:
        """Identified over linearised for each of AXES; empty if either is missing."""
        ours, theirs = (self.mean_sigmas(kind, model) for model in MODELS)
        return tuple(a / b for a, b in zip(ours, theirs, strict=True)) if ours and theirs else ()

    def ratio(self, kind: str) -> float | None:
        """Geometric mean of the axes' ratios; None if a hover is missing."""
        found = self.ratios(kind)
        failed = any(each.failure for each in self.hovers if each.kind == kind)
        return None if failed or not found else float(np.exp(np.mean(np.log(found))))

    @property
    def holds(self) -> bool:
        """Whether every kind hovers at most LARGEST_RATIO times as far."""
        found = [self.ratio(kind) for kind in KINDS]
        return all(ratio is not None and ratio <= LARGEST_RATIO for ratio in found)

    def mapping(self) -> dict[str, Any]:
        """Everything in plain values, SI."""
        return {
            "model": str(self.model),
            "identified": {
                block: None
                if found.fit is None
                else dict(zip(found.fit.outputs, found.fit.percent.tolist(), strict=True))
                for block, found in self.blocks.items()
            },
            "remarks": list(self.remarks),
            "controllers": {
                kind: {
                    **{
                        model: dict(zip(AXES, self.mean_sigmas(kind, model), strict=False))
                        for model in MODELS
                    },
                    "ratios": dict(zip(AXES, self.ratios(kind), strict=False)),
                    "ratio": self.ratio(kind),
                }
                for kind in KINDS
            },
            "largest_ratio": LARGEST_RATIO,
            "holds": self.holds,
            "hovers": [dataclasses.asdict(each) for each in self.hovers],
        }


def run_chain(out: Path, seeds: Sequence[int], *, plan: str, hover: str, workers: int, tell: Tell) -> Chain:
    """Fly, identify, design, fly again; everything it makes stays in a folder.

    Args:
        out: folder, new or empty. Of the hovers it keeps the bags of the first seed and of failures.
        seeds: of the hovers; the first is that of the identification flight, too.
        plan: of the identification flight. hover: of the hovers.
        workers: processes.
        tell: what is being done and how far it is.

    Raises:
        InputError: a folder that holds something, a plan without excitation, data that bear no estimate.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError("is not empty", allowed="a new folder", file=out, key="--out")
    first, second = load_plan(plan), load_plan(hover)
    _require_excited(first)
    tell(f"flies {first.name}, about {first.duration:.0f} s simulated", 0, 0)
    bag = out / first.name
    end = _fly(first, seeds[0], "", bag)
    if end:
        raise InputError(f"flight ended early: {end}", allowed="a flight to its end", key=first.name)
    record = FlightRecord.load(bag)
    model, blocks, remarks = identified_blocks(record, first, tell)
    path = out / "model.yaml"
    model.write(path)
    files: dict[str, str] = {}
    for kind in KINDS:
        tell(f"designs {kind}", 0, 0)
        file = out / f"{kind}.yaml"
        design(kind, model).file.write(file)
        files[kind] = str(file)
    jobs = [
        (
            kind,
            which,
            seed,
            files[kind] if which == MODELS[0] else kind,
            second,
            out / "hovers",
            seed == seeds[0],
        )
        for seed in seeds
        for kind in KINDS
        for which in MODELS
    ]
    hovers = tuple(sorted(_flown(jobs, workers, tell), key=lambda each: (each.kind, each.model, each.seed)))
    return Chain(path, blocks, remarks, hovers)


def _require_excited(plan: Plan) -> None:
    flown = {channel for excitation in plan.excitations for channel in excitation.channels}
    for _, _, channels, _ in PARTS[:1]:
        if missing := [name for name in channels if name not in flown]:
            allowed = f"a plan that excites {', '.join(channels)}"
            raise InputError(f"does not excite {', '.join(missing)}", allowed=allowed, key=plan.name)


def excited_segments(record: FlightRecord, plan: Plan, channels: Sequence[str]) -> list[Segment]:
    """Where the plan's excitations of exactly these channels were flown, in order.

    Args:
        record: of the flight.
        plan: that was flown.
        channels: names.
    """
    layout = TOPICS["flight_state"].layout
    stamps, values = layout.read(record.bag.messages["flight_state"])
    number = values[:, layout.fields.index("effort.flight_state")]
    found = []
    for index, excitation in enumerate(plan.excitations, 1):
        flown = stamps[number == index] * 1e-9
        if set(excitation.channels) == set(channels) and len(flown):
            found.append(Segment(float(flown[0]) + BEFORE, float(flown[-1]) - AFTER))
    return found


def identified_blocks(
    record: FlightRecord, plan: Plan, tell: Tell
) -> tuple[ModelFile, dict[str, Identified], tuple[str, ...]]:
    """The model with every block that the flight tells, and what it does not tell.

    Args:
        record: of an identification flight.
        plan: that was flown: the first excitation of a block estimates, the others validate.
        tell: what is being done.

    Raises:
        InputError: the horizontal axis bears no estimate.
    """
    model: ModelFile | None = None
    blocks: dict[str, Identified] = {}
    remarks: list[str] = []
    for block, structure, channels, fixed in PARTS:
        tell(f"identifies {block}", 0, 0)
        pieces = excited_segments(record, plan, channels)
        if not pieces:
            remarks.append(f"{block}: not excited, stays as the prior model has it")
            continue
        choice = Choice(
            structure=structure,
            noise=Noise.OUTPUT_ERROR,
            fixed=fixed,
            estimate=tuple(pieces[:1]),
            validate=tuple(pieces[1:]),
        )
        try:
            found = identify([record], choice)
        except InputError as error:
            if block == "horizontal":
                raise
            remarks.append(f"{block}: {error}; stays as the prior model has it")
            continue
        worst = 100.0 if found.fit is None else float(min(found.fit.percent))
        if block == "vertical" and (worst < LEAST_FIT or not found.estimate.converged):
            remarks.append(f"{block}: explains {worst:.0f} % only, stays as the prior model has it")
            continue
        blocks[block] = found
        model = found.model("identified", model)
    if model is None:
        raise InputError("nothing identified", allowed="a plan that excites the cyclic", key=plan.name)
    return model, blocks, tuple(remarks)


def _fly(plan: Plan, seed: int, controller: str, bag: Path) -> str:
    """Fly and leave the bag; a reason if it ended early."""
    named = controller or plan.controller
    order = FlightOrder(
        plan=dataclasses.replace(plan, seed=seed),
        plan_name=plan.name,
        mode=Mode.INPROCESS,
        seed=seed,
        controller=load_controller(named),
        controller_name=named,
        bag=bag,
    )
    end = fly_in_process(order, lambda _: None)
    return "" if end.exit_code == EXIT_FLOWN else end.reason


Job = tuple[str, str, int, str, Plan, Path, bool]


def _hover(job: Job) -> Hover:
    kind, which, seed, controller, plan, folder, kept = job
    bag = folder / f"{kind}_{which}_{seed}"
    reason = _fly(plan, seed, controller, bag)
    found = [] if reason else flight_metrics(FlightRecord.load(bag))["hover"]
    if found and not kept:
        shutil.rmtree(bag)
    if not found:
        return Hover(kind, which, seed, (), reason or "no hover")
    weights = [each["duration_s"] for each in found]
    sigmas = [
        sqrt(sum(w * each[name] ** 2 for w, each in zip(weights, found, strict=True)) / sum(weights))
        for name in AXES
    ]
    return Hover(kind, which, seed, tuple(sigmas))


def _flown(jobs: Sequence[Job], workers: int, tell: Tell) -> Iterator[Hover]:
    with Workers(min(workers, os.cpu_count() or 1)) as pool:
        for done, hover in enumerate(pool.results(_hover, jobs), 1):
            tell("hovers", done, len(jobs))
            yield hover
