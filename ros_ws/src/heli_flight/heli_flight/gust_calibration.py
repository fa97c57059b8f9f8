"""The room's gusts so strong that LQ hovers as the source's Table 5.2 says (spec 2.7, 5).

Four strengths and four figures, each figure growing with its own strength, in the plane faster than in
proportion, for dry friction keeps small gusts from moving anything. Every round flies the same seeds and
multiplies each strength by a power of what its figure lacks. The seeds stay, so the rounds differ by the
strengths alone. A round in which the supervisor stopped a flight went too far: half of its step is taken
back. A touch of the upper or lower stop is no loss here: the flight goes on, and is part of the figure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

from heli_bench_sim.room_air import RoomAirParameters
from heli_common import topics
from heli_common.errors import InputError, SafetyStop
from heli_flight.metrics import AXES, UNITS, hover_metrics, reference_legs
from heli_flight.parameter_file import NodeValues, yaml_number
from heli_flight.plan import GUSTY, Plan
from heli_flight.unrecorded_flight import fly_for_figures
from heli_flight.worker_pool import Workers

STRENGTHS = ("strength_x", "strength_y", "strength_z", "strength_yaw")
"""The only parameters that are calibrated, in the order of AXES."""
CONTROLLER = "lq"
TOLERANCE = 0.03
"""Largest relative difference of a mean sigma that ends the search."""
MOST_ROUNDS = 10
POWER = 0.65
"""Of what a figure lacks: figures grow with the strengths' powers 0.9 (psi) to 1.8 (x, y)."""
_LARGEST_FACTOR = 2.5

Four = tuple[float, float, float, float]
Fly = Callable[[Four, int], Four]
"""Sigmas of one hover [m, m, m, rad] with these strengths and this seed; SafetyStop if it is lost."""


@dataclass(frozen=True)
class Round:
    """Strengths tried [m/s, m/s, m/s, N m] and the mean sigmas they gave [m, m, m, rad], or why none."""

    strengths: Four
    sigmas: Four | None
    failure: str = ""


@dataclass(frozen=True)
class Calibration:
    """What came out: the last round holds the strengths found."""

    target: Four
    seeds: tuple[int, ...]
    rounds: tuple[Round, ...]

    @property
    def strengths(self) -> Four:
        """Found [m/s, m/s, m/s, N m]."""
        return self.rounds[-1].strengths

    @property
    def ratios(self) -> Four:
        """Mean sigma over target of the last round."""
        sigmas = self.rounds[-1].sigmas
        if sigmas is None:
            raise ValueError("the last round was lost")
        return _four(ours / wanted for ours, wanted in zip(sigmas, self.target, strict=True))


def _four(values: Iterable[float]) -> Four:
    first, second, third, fourth = values
    return (first, second, third, fourth)


def sigmas_of(strengths: Four, seed: int, plan: Plan, values: NodeValues) -> Four:
    """Standard deviations of one hover of LQ [m, m, m, rad].

    Args:
        strengths: of the gusts [m/s, m/s, m/s, N m].
        seed: of every random number.
        plan: a hover.
        values: parameters of the nodes; the strengths replace theirs.

    Raises:
        SafetyStop: the helicopter is lost.
    """
    flight = fly_for_figures(plan, CONTROLLER, seed, values.changed(topics.BENCH_SIM, room(strengths)))
    if flight.reason:
        raise SafetyStop(flight.reason)
    hovers = [hover_metrics(flight, leg) for leg in reference_legs(flight) if leg.jump is None]
    longest = max((found for found in hovers if found), key=lambda found: found["duration_s"], default=None)
    if longest is None:
        raise SafetyStop("no hover")
    return _four(longest[f"sigma_{axis}_{unit}"] for axis, unit in zip(AXES, UNITS, strict=True))


def room(strengths: Four) -> dict[str, float]:
    """The strengths as parameters of the bench."""
    return {f"room.{name}": value for name, value in zip(STRENGTHS, strengths, strict=True)}


def start_strengths(values: NodeValues) -> Four:
    """The strengths that the parameters have."""
    parameters = values.build(topics.BENCH_SIM, RoomAirParameters, "room.")
    return _four(float(getattr(parameters, name)) for name in STRENGTHS)


def require_gusty(plan: Plan) -> Plan:
    """The plan, if it is one to calibrate gusts on.

    Raises:
        InputError: it flies in still air, or changes its controller.
    """
    if plan.room != GUSTY:
        raise InputError(f"{plan.name} flies in a {plan.room} room", allowed=f"room: {GUSTY}", key="room")
    if len(plan.controllers) > 1:
        raise InputError(f"{plan.name} changes its controller", allowed="one controller", key="controller")
    return plan


def calibrate(
    fly: Fly,
    target: Four,
    start: Four,
    seeds: Sequence[int],
    *,
    tolerance: float = TOLERANCE,
    most_rounds: int = MOST_ROUNDS,
    workers: int = 1,
    tell: Callable[[Round], None] = lambda _: None,
) -> Calibration:
    """Find the strengths whose mean sigmas over the seeds are those asked for.

    Args:
        fly: flies one hover; picklable if there are several workers.
        target: sigmas [m, m, m, rad], each positive.
        start: strengths, each positive.
        seeds: of the hovers, at least one.
        tolerance: largest relative difference that ends the search.
        most_rounds: how often is tried.
        workers: processes.
        tell: called with every round.

    Raises:
        InputError: nothing to fly, or the target is not met within the rounds.
    """
    if not seeds or min(*target, *start) <= 0.0 or not all(map(math.isfinite, (*target, *start))):
        raise InputError(
            f"target {target}, start {start}, {len(seeds)} seeds", allowed="positive numbers, 1 seed or more"
        )
    rounds: list[Round] = []
    strengths, safe = rounded(start), None
    with Workers(workers) as pool:
        for _ in range(most_rounds):
            rounds.append(_round(pool, fly, strengths, seeds))
            tell(rounds[-1])
            found = rounds[-1].sigmas
            if found is None:
                floor = safe or _four(0.5 * value for value in start)
                strengths = _four(math.sqrt(a * b) for a, b in zip(strengths, floor, strict=True))
                strengths = rounded(strengths)
                continue
            lacking = [wanted / ours for wanted, ours in zip(target, found, strict=True)]
            if all(abs(1.0 / factor - 1.0) <= tolerance for factor in lacking):
                return Calibration(target, tuple(seeds), tuple(rounds))
            safe = strengths
            factors = (min(max(lack**POWER, 1.0 / _LARGEST_FACTOR), _LARGEST_FACTOR) for lack in lacking)
            strengths = rounded(_four(a * b for a, b in zip(strengths, factors, strict=True)))
    last = rounds[-1]
    raise InputError(
        f"not within {100.0 * tolerance:g} % after {most_rounds} rounds: "
        + (last.failure or f"sigmas {last.sigmas} instead of {target}"),
        allowed="strengths with which LQ hovers so wide",
    )


def _round(pool: Workers, fly: Fly, strengths: Four, seeds: Sequence[int]) -> Round:
    failure, sums = "", [0.0] * 4
    # added up in the order of the seeds, whoever is ready first
    outcomes = dict(pool.results(partial(_attempt, fly, strengths), list(seeds)))
    for seed in seeds:
        outcome = outcomes[seed]
        if isinstance(outcome, str):
            failure = failure or f"seed {seed}: {outcome}"
        else:
            sums = [total + value for total, value in zip(sums, outcome, strict=True)]
    if failure:
        return Round(strengths, None, failure)
    return Round(strengths, _four(total / len(seeds) for total in sums))


def _attempt(fly: Fly, strengths: Four, seed: int) -> tuple[int, Four | str]:
    try:
        return seed, fly(strengths, seed)
    except SafetyStop as error:
        return seed, str(error)


def parameter_text(found: Calibration, plan: Plan, command: str) -> str:
    """The strengths as a parameter file for the nodes, with how they were found.

    Args:
        found: calibration.
        plan: that was flown.
        command: that found them.
    """
    shown = [_row(found.target, "asked for: Table 5.2, LQ")]
    shown += [
        _row(entry.sigmas, "from " + _numbers(entry.strengths))
        if entry.sigmas
        else f"# lost: {entry.failure}"
        for entry in found.rounds
    ]
    seeds = ", ".join(map(str, found.seeds))
    lines = [
        f"# Strengths of the room's gusts, found by `{command}`.",
        f"# Plan {plan.name}, controller {CONTROLLER}, means over seeds {seeds}; no other row was used.",
        "# sigma x y z [cm], psi [deg]    strengths x y z [m/s], yaw [N m]",
        *shown,
        "# Use: heli fly PLAN --params-file THIS",
        f"/**/{topics.BENCH_SIM}:",
        "  ros__parameters:",
        *(f"    {name}: {yaml_number(value)}" for name, value in room(found.strengths).items()),
    ]
    return "\n".join(lines) + "\n"


def rounded(strengths: Four) -> Four:
    """To three digits: a percent of a strength is a percent of its sigma."""
    return _four(float(f"{value:.3g}") for value in strengths)


def _row(sigmas: Four, words: str) -> str:
    x, y, z, psi = sigmas
    return f"# {100 * x:6.2f} {100 * y:6.2f} {100 * z:6.2f}  {math.degrees(psi):6.2f}    {words}"


def _numbers(strengths: Four) -> str:
    return " ".join(f"{value:.4g}" for value in strengths)
