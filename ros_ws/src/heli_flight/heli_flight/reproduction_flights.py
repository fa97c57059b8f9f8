"""What is flown for the reproduction and what is kept of each flight (spec 5): figures of merit and curves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, radians
from typing import Any

import numpy as np

from heli_common.errors import InputError
from heli_common.flight_state import FlightState
from heli_common.timing import CONTROL_PERIOD_NS
from heli_control.controller_file import load_controller
from heli_control.sampled_loop import sampled_margins
from heli_flight.chain import excited_segments, identified_blocks
from heli_flight.flight_record import Array, FlightRecord, Stamps
from heli_flight.flown_curves import AXES, LINEAR, curves_of, linear_curves, true_motion
from heli_flight.flown_margin import linear_loop
from heli_flight.metrics import Leg, hover_metrics, hover_start, reference_legs, step_metrics
from heli_flight.noise_level import CHANNEL, RESOLUTION, flown_noise_level, fly_noise
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Plan, load_plan
from heli_flight.published_flights import DEAD_TIME
from heli_flight.unrecorded_flight import KEPT, fly_for_figures, lost

PLANS = {
    "F1": "hover_steps",
    "F2": "hover",
    "F3": "wind_front",
    "F4": "noise",
    "F4b": "noise_5_hz",
    "F4n": "noise",
    "F5": "identification",
    "F7": "velocity_steps",
    "F8": "wireless_link",
}
"""Plan of each experiment; F4 and F4b search a level, F4n flies one level to be drawn. F6 comes from F2."""

DRAWN_NOISE = {"lq": 1.0, "ncf2": 1.1}
"""Sigma of Figures 5.13 and 5.14 [deg]; 1.0 for the other controllers."""

IDENTIFYING = (*KEPT, "odometry", "motor_command", "motor_excitation", "reference_excitation")
LATE_NS = 2_500_000_000
"""So long after a step the attitude should be calm again [ns]."""

PLATEAU = 9.0
"""How much of a step of the wind is judged, its end [s]."""


@dataclass(frozen=True)
class Job:
    """One experiment with one controller and one seed.

    Attributes:
        experiment: key of PLANS. controller: shipped name or path. seed: of every random number.
        drawn: whether curves are kept. resolution: of F4 [rad].
    """

    experiment: str
    controller: str
    seed: int
    drawn: bool = False
    resolution: float = RESOLUTION

    @property
    def key(self) -> str:
        """Name of its file."""
        drawn = "_drawn" if self.drawn else ""
        fine = f"_{self.resolution:.4f}" if self.experiment in ("F4", "F4b") else ""
        return f"{self.experiment}_{self.controller}_{self.seed}{fine}{drawn}"


@dataclass(frozen=True, eq=False)
class Outcome:
    """What is kept of a job.

    Attributes:
        lost: why the helicopter was lost, empty if it was not.
        figures: of merit, plain values, SI, ready for JSON.
        curves: by name, shape (n,) each, with a `time` [s].
    """

    lost: str
    figures: dict[str, Any]
    curves: dict[str, Array] = field(default_factory=dict)


def fly_job(job: Job, values: NodeValues) -> Outcome:
    """Fly a job.

    Args:
        job: what to fly.
        values: parameters of the nodes.

    Raises:
        InputError: no such experiment or controller.
    """
    if job.experiment not in PLANS:
        raise InputError(f"{job.experiment!r} is no experiment", allowed=", ".join(PLANS), key="experiment")
    return _FLOWN[job.experiment](job, load_plan(PLANS[job.experiment]), values)


def _steps(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    record = fly_for_figures(plan, job.controller, job.seed, values)
    legs = [leg for leg in reference_legs(record) if leg.jump is not None]
    steps = [found | _calm(record, leg) for leg in legs if (found := step_metrics(record, leg))]
    if not steps:
        return Outcome(lost(record) or "no step", {})
    curves: dict[str, Array] = {}
    if job.drawn:
        start = legs[0].start_ns * 1e-9 - 1.0
        curves = curves_of(record, start) | linear_curves(record, job.controller, start, values)
    return Outcome(lost(record), {"steps": steps}, curves)


def _calm(record: FlightRecord, leg: Leg) -> dict[str, float]:
    """Attitude when the step should be over, and how fast the body turned in all of it, root mean squares."""
    truth, columns = record.truth, true_motion(record)
    inside = (truth.stamps >= leg.start_ns) & (truth.stamps < leg.end_ns)
    late = inside & (truth.stamps >= leg.start_ns + LATE_NS)
    found = {f"late_{name}_rad": float(columns[name][late].std()) for name in ("theta", "phi")}
    rates = {f"rms_{name}_rad_s": float(np.sqrt(np.mean(columns[name][inside] ** 2))) for name in ("q", "p")}
    return found | rates


def _hover(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    record = fly_for_figures(plan, job.controller, job.seed, values)
    reason = lost(record)
    legs = [leg for leg in reference_legs(record) if leg.jump is None]
    if reason or not legs:
        return Outcome(reason or "no hover", {})
    leg = max(legs, key=lambda one: one.duration)
    start_ns = hover_start(leg)
    found: dict[str, Any] = dict(hover_metrics(record, leg))
    stamps, actuators = record.actuator_state
    inside = (stamps >= start_ns) & (stamps < leg.end_ns)
    names = ("B_1s", "A_1s", "theta_0", "theta_t")
    found |= {f"mean_{name}_rad": float(actuators[inside, i].mean()) for i, name in enumerate(names)}
    return Outcome("", found, curves_of(record, start_ns * 1e-9, leg.end_ns * 1e-9) if job.drawn else {})


def _wind(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    """Means over the end of every step of the wind that was flown through."""
    record = fly_for_figures(plan, job.controller, job.seed, values)
    truth, state, condition = record.truth, record.series["flight_state"], record.series["bench_condition"]
    asked, fan = state.column("velocity.fan"), condition.column("position.fan")
    reference_stamps, reference = record.velocity_reference
    columns, plateaus = true_motion(record), []
    end_ns = _air(record)[1]
    for begin, end in constant_stretches(state.stamps, asked, round(PLATEAU * 1e9)):
        first, last = end - round(PLATEAU * 1e9), min(end, end_ns)
        if begin < _air(record)[0] or last < end:
            continue
        chosen = (truth.stamps >= first) & (truth.stamps < last)
        wanted = (reference_stamps >= first) & (reference_stamps < last)
        blowing = (condition.stamps >= first) & (condition.stamps < last)
        entry = {
            "asked": float(asked[np.searchsorted(state.stamps, first)]),
            "fan": float(fan[blowing].mean()),
            "mean_u_ref": float(reference[wanted, 0].mean()),
        }
        for name in AXES:
            entry[f"mean_{name}"] = float(columns[name][chosen].mean())
            entry[f"sigma_{name}"] = float(columns[name][chosen].std())
        plateaus.append(entry)
    reason = lost(record)
    figures: dict[str, Any] = {"plateaus": plateaus, "lost_at": float(fan.max()) if reason else None}
    curves: dict[str, Array] = {}
    if job.drawn:
        start = _air(record)[0] * 1e-9
        curves = curves_of(record, start, end_ns * 1e-9)
        curves["fan"] = np.interp(curves["time"] + start, condition.time, fan)
    return Outcome(reason, figures, curves)


def constant_stretches(stamps: Stamps, values: Array, shortest_ns: int) -> list[tuple[int, int]]:
    """First stamp and first stamp after every stretch in which a value stays, if it is long enough [ns]."""
    if not len(stamps):
        return []
    changes = [0, *(np.flatnonzero(np.diff(values) != 0.0) + 1).tolist(), len(stamps)]
    ends = [*(int(stamps[index]) for index in changes[1:-1]), int(stamps[-1]) + CONTROL_PERIOD_NS]
    found = [(int(stamps[index]), end) for index, end in zip(changes[:-1], ends, strict=True)]
    return [(begin, end) for begin, end in found if end - begin >= shortest_ns]


def _noise(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    level = flown_noise_level(plan, job.controller, job.seed, values, job.resolution)
    figures = {"borne": level.borne, "lost": level.lost, "level": level.level, "reason": level.reason}
    return Outcome("", figures)


def _drawn_noise(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    sigma = radians(DRAWN_NOISE.get(job.controller, 1.0))
    record = fly_noise(plan, job.controller, sigma, job.seed, values)
    excitation = record.series["excitation"]
    column = excitation.column(f"position.{CHANNEL}")
    acting = np.flatnonzero(column != 0.0)
    if not len(acting):
        return Outcome(lost(record) or "nothing was excited", {"sigma": sigma})
    start = excitation.stamps[acting[0]] * 1e-9 - 2.0
    curves = curves_of(record, start, every=1)
    curves["noise"] = np.interp(curves["time"] + start, excitation.time, column)
    return Outcome(lost(record), {"sigma": sigma}, curves)


def _identification(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    """What the flight was like, and what its data say of the helicopter."""
    record = fly_for_figures(plan, job.controller, job.seed, values, IDENTIFYING)
    reason = lost(record)
    figures: dict[str, Any] = {
        "flown": len({*record.series["flight_state"].column("effort.flight_state")} - {0.0})
    }
    figures["planned"] = len(plan.excitations)
    if not reason:
        try:
            _, blocks, remarks = identified_blocks(record, plan, lambda *_: None)
        except InputError as error:
            figures["remark"] = str(error)
        else:
            figures["remark"] = "; ".join(remarks)
            for name, block in blocks.items():
                pairs = zip(block.estimate.names, block.estimate.errors, strict=True)
                errors = {key: float(value) for key, value in pairs}
                parameters = block.estimate.structure.parameters
                figures[name] = {
                    "fit": {}
                    if block.fit is None
                    else dict(zip(block.fit.outputs, block.fit.percent.tolist(), strict=True)),
                    "values": {p.name: float(p.value) for p in parameters if p.name in errors},
                    "errors": errors,
                }
    return Outcome(reason, figures)


def _velocity(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    record = fly_for_figures(plan, job.controller, job.seed, values, (*KEPT, "reference_excitation"))
    pieces = [excited_segments(record, plan, (name,)) for name in ("u", "v")]
    if not all(pieces):
        return Outcome(lost(record) or "nothing was excited", {})
    start = float(pieces[0][0].begin or 0.0) - 1.5
    linear = linear_curves(record, job.controller, start, values)
    curves = curves_of(record, start) | linear
    apart = {
        name: float(np.sqrt(np.mean((curves[name] - curves[name][0] - curves[f"linear_{name}"]) ** 2)))
        for name in LINEAR
    }
    return Outcome(lost(record), {"apart": apart}, curves if job.drawn else {})


def _wireless(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    record = fly_for_figures(plan, job.controller, job.seed, values)
    stamps = record.truth.stamps
    begun = plan.faults[0].start_ns
    margins = sampled_margins(linear_loop(load_controller(job.controller), "horizontal", values))
    figures = {
        "dead_time": DEAD_TIME,
        "after": max(0.0, float(stamps[-1] - begun) * 1e-9) if len(stamps) else inf,
        "delay_margin": 1e-3 * margins.delay_ms,
    }
    return Outcome(lost(record), figures, curves_of(record, begun * 1e-9 - 2.0) if job.drawn else {})


_FLOWN: dict[str, Callable[[Job, Plan, NodeValues], Outcome]] = {
    "F1": _steps,
    "F2": _hover,
    "F3": _wind,
    "F4": _noise,
    "F4b": _noise,
    "F4n": _drawn_noise,
    "F5": _identification,
    "F7": _velocity,
    "F8": _wireless,
}


def _air(record: FlightRecord) -> tuple[int, int]:
    """First stamp after the take-off and last one of flying [ns]; both 0 of a flight that never flew."""
    legs = reference_legs(record)
    flown = [stage.end_ns for stage in record.stages if stage.state is FlightState.FLYING]
    return (legs[0].start_ns, flown[-1]) if legs and flown else (0, 0)
