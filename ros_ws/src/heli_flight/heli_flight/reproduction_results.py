"""The flown outcomes by experiment and controller: figures of merit over the seeds."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees
from statistics import fmean

from heli_flight.published_flights import CONTROLLERS
from heli_flight.reproduction_flights import Job, Outcome
from heli_flight.reproduction_statistics import Interval

Outcomes = Mapping[Job, Outcome]

AXES = ("x", "y", "z", "psi")
SIGMAS = ("sigma_x_m", "sigma_y_m", "sigma_z_m", "sigma_psi_rad")
UNITS = ("cm", "cm", "cm", "deg")
FACTORS = (100.0, 100.0, 100.0, degrees(1.0))


def of(outcomes: Outcomes, experiment: str, controller: str) -> dict[int, Outcome]:
    """Outcomes of an experiment and a controller by seed."""
    chosen = [job for job in outcomes if (job.experiment, job.controller) == (experiment, controller)]
    return {job.seed: outcomes[job] for job in sorted(chosen, key=lambda job: (job.seed, job.drawn))}


def flown_controllers(outcomes: Outcomes, experiment: str) -> list[str]:
    """Controllers of an experiment in the source's order, others behind them."""
    named = {job.controller for job in outcomes if job.experiment == experiment}
    return [name for name in CONTROLLERS if name in named] + sorted(named - set(CONTROLLERS))


def hover_figure(outcomes: Outcomes, controller: str, name: str) -> dict[int, float]:
    """One figure of merit of F2 by seed, of the flights that were not lost."""
    found = of(outcomes, "F2", controller)
    return {seed: float(one.figures[name]) for seed, one in found.items() if name in one.figures}


def step_figures(outcomes: Outcomes, controller: str, axis: str, name: str) -> list[float]:
    """One figure of merit of F1 of each seed: the mean over both directions of an axis; None is left out."""
    values = []
    for outcome in of(outcomes, "F1", controller).values():
        steps = [step for step in outcome.figures.get("steps", ()) if step["axis"] == axis]
        known = [float(step[name]) for step in steps if step.get(name) is not None]
        if known:
            values.append(fmean(known))
    return values


def plateau_figures(outcomes: Outcomes, controller: str, speed: float, name: str) -> list[float]:
    """One figure of F3 of each seed at a speed asked of the fan; only of those that flew through it."""
    return [
        float(plateau[name])
        for outcome in of(outcomes, "F3", controller).values()
        for plateau in outcome.figures.get("plateaus", ())
        if abs(plateau["asked"] - speed) < 1e-6
    ]


def shown(found: Interval | None, digits: int = 2, unit: str = "") -> str:
    """A mean with its interval in words."""
    if found is None:
        return "–"
    text = f"{found.mean:.{digits}f}"
    if found.count > 1:
        text += f" [{found.low:.{digits}f}, {found.high:.{digits}f}]"
    return (text + (f" {unit}" if unit else "")).replace("-", "−")
