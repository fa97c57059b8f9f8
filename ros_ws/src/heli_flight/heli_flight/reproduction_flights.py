"""What is flown for the reproduction and what is kept of each flight: figures of merit, curves (spec 5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, radians
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.flight_state import FlightState
from heli_common.timing import CONTROL_PERIOD, CONTROL_PERIOD_NS
from heli_common.topics import SERVO_CHANNELS
from heli_control.controller_file import load_controller
from heli_control.sampled_loop import sampled_margins
from heli_flight.chain import excited_segments, identified_blocks
from heli_flight.flight_record import Array
from heli_flight.flown_curves import AXES, LINEAR, curves_of, linear_curves, true_motion
from heli_flight.flown_margin import linear_loop
from heli_flight.metrics import Leg, hover_metrics, hover_start, reference_legs, step_metrics
from heli_flight.noise_level import CHANNEL, RESOLUTION, flown_noise_level, fly_noise
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Plan, load_plan
from heli_flight.plan_phases import STRONGEST_WIND
from heli_flight.published_flights import DEAD_TIME
from heli_flight.unrecorded_flight import KEPT, FlownFlight, fly_for_figures, lost, messages_of, stopped

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

IDENTIFYING = (*KEPT, "odometry", "motor_command", "motor_excitation", "rotor")
LATE_NS = 2_500_000_000
"""So long after a step the attitude should be calm again [ns]."""

PLATEAU = 8.5
"""How much of a step of the wind is judged, its end [s]."""

FAN_TOLERANCE = 0.1
"""How near the fan is to the speed asked for [m/s]."""


Ticks = NDArray[np.int64]


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
    flight = fly_for_figures(plan, job.controller, job.seed, values)
    legs = [leg for leg in reference_legs(flight) if leg.jump is not None]
    steps = [found | _calm(flight, leg) for leg in legs if (found := step_metrics(flight, leg))]
    if not steps:
        return Outcome(lost(flight) or "no step", {})
    curves: dict[str, Array] = {}
    if job.drawn:
        start = legs[0].start_ns * 1e-9 - 1.0
        curves = curves_of(flight, start) | linear_curves(flight, job.controller, start, values)
    return Outcome(lost(flight), {"steps": steps}, curves)


def _calm(flight: FlownFlight, leg: Leg) -> dict[str, float]:
    """Attitude when the step should be over, and how fast the body turned in all of it, root mean squares."""
    truth, columns = flight.truth, true_motion(flight)
    inside = (truth.stamps >= leg.start_ns) & (truth.stamps < leg.end_ns)
    late = inside & (truth.stamps >= leg.start_ns + LATE_NS)
    found = {f"late_{name}_rad": float(columns[name][late].std()) for name in ("theta", "phi")}
    rates = {f"rms_{name}_rad_s": float(np.sqrt(np.mean(columns[name][inside] ** 2))) for name in ("q", "p")}
    return found | rates


def _hover(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    """A touch of a stop is told, and is no loss: the flight goes on."""
    flight = fly_for_figures(plan, job.controller, job.seed, values)
    legs = [leg for leg in reference_legs(flight) if leg.jump is None]
    if (reason := stopped(flight)) or not legs:
        return Outcome(reason or "no hover", {})
    leg = max(legs, key=lambda one: one.duration)
    start_ns = hover_start(leg)
    found: dict[str, Any] = {**hover_metrics(flight, leg), "touched": lost(flight)}
    inside = (flight.truth.stamps >= start_ns) & (flight.truth.stamps < leg.end_ns)
    means = flight.actuators[inside].mean(axis=0).tolist()
    found |= {f"mean_{name}_rad": mean for name, mean in zip(SERVO_CHANNELS, means, strict=True)}
    return Outcome("", found, curves_of(flight, start_ns * 1e-9, leg.end_ns * 1e-9) if job.drawn else {})


def _wind(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    """Means over the end of every step of the wind that was flown through."""
    flight = fly_for_figures(plan, job.controller, job.seed, values)
    columns, start, end = true_motion(flight), *_air(flight)
    plateaus = []
    for speed in range(round(STRONGEST_WIND) + 1):
        chosen = _plateau(flight.fan, float(speed), start, end)
        if not len(chosen):
            continue
        entry = {"asked": float(speed), "fan": float(flight.fan[chosen].mean())}
        for name in AXES:
            entry[f"mean_{name}"] = float(columns[name][chosen].mean())
            entry[f"sigma_{name}"] = float(columns[name][chosen].std())
        plateaus.append(entry)
    reason = lost(flight)
    figures: dict[str, Any] = {"plateaus": plateaus}
    figures["lost_at"] = float(flight.fan[-1]) if reason else None
    first, last = start * CONTROL_PERIOD, end * CONTROL_PERIOD
    return Outcome(reason, figures, curves_of(flight, first, last) if job.drawn else {})


def _plateau(fan: Array, speed: float, start: int, end: int) -> Ticks:
    """Ticks of the last PLATEAU of the first stretch at a speed of the fan; none if it is shorter."""
    at_speed = np.flatnonzero(np.abs(fan[start:end] - speed) < FAN_TOLERANCE) + start
    if not len(at_speed):
        return at_speed
    breaks = np.flatnonzero(np.diff(at_speed) > 1)
    stretch = at_speed[: int(breaks[0]) + 1] if len(breaks) else at_speed
    count = round(PLATEAU / CONTROL_PERIOD)
    return stretch[-count:] if len(stretch) >= count else stretch[:0]


def _noise(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    level = flown_noise_level(plan, job.controller, job.seed, values, job.resolution)
    figures = {"borne": level.borne, "lost": level.lost, "level": level.level, "reason": level.reason}
    return Outcome("", figures)


def _drawn_noise(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    sigma = radians(DRAWN_NOISE.get(job.controller, 1.0))
    flight = fly_noise(plan, job.controller, sigma, job.seed, values)
    acting = np.flatnonzero(flight.excitation.any(axis=1))
    if not len(acting):
        return Outcome(lost(flight) or "nothing was excited", {"sigma": sigma})
    start = float(flight.truth.time[acting[0]]) - 2.0
    curves = curves_of(flight, start, every=1)
    noise = flight.excitation[:, SERVO_CHANNELS.index(CHANNEL)]
    curves["noise"] = noise[len(noise) - len(curves["time"]) :]
    return Outcome(lost(flight), {"sigma": sigma}, curves)


def _identification(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    """What the flight was like, and what its data say of the helicopter."""
    flight = fly_for_figures(plan, job.controller, job.seed, values, IDENTIFYING)
    record, reason = messages_of(flight), lost(flight)
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
    flight = fly_for_figures(plan, job.controller, job.seed, values)
    pieces = [excited_segments(messages_of(flight), plan, (name,)) for name in ("u", "v")]
    if not all(pieces):
        return Outcome(lost(flight) or "nothing was excited", {})
    start = float(pieces[0][0].begin or 0.0) - 1.5
    linear = linear_curves(flight, job.controller, start, values)
    curves = curves_of(flight, start) | linear
    apart = {
        name: float(np.sqrt(np.mean((curves[name] - curves[name][0] - curves[f"linear_{name}"]) ** 2)))
        for name in LINEAR
    }
    return Outcome(lost(flight), {"apart": apart}, curves if job.drawn else {})


def _wireless(job: Job, plan: Plan, values: NodeValues) -> Outcome:
    flight = fly_for_figures(plan, job.controller, job.seed, values)
    stamps = flight.truth.stamps
    begun = plan.faults[0].start_ns
    margins = sampled_margins(linear_loop(load_controller(job.controller), "horizontal", values))
    figures = {
        "dead_time": DEAD_TIME,
        "after": max(0.0, float(stamps[-1] - begun) * 1e-9) if len(stamps) else inf,
        "delay_margin": 1e-3 * margins.delay_ms,
    }
    return Outcome(lost(flight), figures, curves_of(flight, begun * 1e-9 - 2.0) if job.drawn else {})


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


def _air(flight: FlownFlight) -> tuple[int, int]:
    """Ticks from the end of the climb to the end of flying; both 0 of a flight that did not get there."""
    legs = reference_legs(flight)
    flying = np.flatnonzero(flight.state == FlightState.FLYING)
    return (legs[0].start_ns // CONTROL_PERIOD_NS, int(flying[-1]) + 1) if legs and len(flying) else (0, 0)
