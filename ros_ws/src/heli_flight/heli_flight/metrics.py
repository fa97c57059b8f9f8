"""Figures of merit of a flight: hover, steps, rotor speed, commands, estimation, wind (spec 5, F1 and F2).

Everything is SI, with the unit in the key; what cannot be said of a flight is None and named in `missing`.
Position is the true one, against the supervisor's reference; axes are earth north, east, down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from heli_common.flight_state import FlightState
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import data_topics
from heli_flight.flight_record import Array, FlightRecord, Flown, Motion, Stage, Stamps, seconds
from heli_flight.flight_statistics import command_metrics, controlled, estimation_metrics, wind_metrics

AXES = ("x", "y", "z", "psi")
UNITS = ("m", "m", "m", "rad")

SETTLING_BAND = {"m": 0.02, "rad": math.radians(2.0)}
"""A step has settled when the error stays within this."""

HOVER_SETTLING = 2.0
"""What is left out at the beginning of a hover [s], at most a third of it: the end of the climb."""

SHORTEST_HOVER = 1.0
STEP_ERROR_TIME = 6.0
FINAL_WINDOW = 0.5
"""The final error of a step is the mean over its last so many seconds."""

ON_THE_STOP = 0.42
"""A reference deeper than this [m] is not flown: the lower stop is at 0.45 m, the lowest plan at 0.40 m."""

_JUMP = np.array([0.01, 0.01, 0.01, math.radians(1.0)])
"""A reference that moves more than this in one control period jumps; the fastest ramp moves 5 mm."""


@dataclass(frozen=True)
class Leg:
    """A stretch of flight with a constant reference.

    Attributes:
        start_ns: first stamp of this reference.
        end_ns: first stamp of the next one, or of the next stage.
        reference: north, east, down [m], yaw [rad].
        jump: change of the reference at its start if it was a step, else None.
    """

    start_ns: int
    end_ns: int
    reference: Array
    jump: Array | None

    @property
    def duration(self) -> float:
        """Seconds."""
        return (self.end_ns - self.start_ns) * 1e-9


class Pose(NamedTuple):
    """`Flown` from arrays at hand."""

    truth: Motion
    reference: tuple[Stamps, Array]
    stages: tuple[Stage, ...]


def flight_metrics(record: FlightRecord) -> dict[str, Any]:
    """All figures of merit as plain numbers, texts, lists and mappings, ready for JSON."""
    stages = record.stages
    missing: list[str] = list(record.bag.problems)
    missing += [f"topic {name} is empty" for name in _NEEDED if not len(record.series[name].stamps)]
    if stages and FlightState.FLYING not in {stage.state for stage in stages}:
        missing.append("the helicopter was never flying")
    legs = reference_legs(record)
    hovers = [hover_metrics(record, leg) for leg in legs if leg.jump is None]
    steps = [step_metrics(record, leg) for leg in legs if leg.jump is not None]
    if not any(hovers):
        missing.append("no hover")
    ended = stages[-1].state if stages else None
    if ended is not None and ended is not FlightState.STOPPED:
        reason = record.custom_data.get("result", "")
        missing.append(f"the flight did not end in stopped but in {ended.word}" + (reason and f": {reason}"))
    start, end = record.span
    return {
        "flight": {
            "bag": record.bag.folder.resolve().name,
            "duration_s": end - start,
            "ended": ended.word if ended is not None else None,
            "complete": record.bag.complete,
        },
        "stages": [
            {"state": stage.state.word, "start_s": stage.start_ns * 1e-9, "duration_s": stage.duration}
            for stage in stages
        ],
        "hover": [hover for hover in hovers if hover],
        "steps": [step for step in steps if step],
        "rotor": rotor_metrics(record),
        "commands": command_metrics(record),
        "estimation": estimation_metrics(record),
        "wind": wind_metrics(record),
        "missing": missing,
    }


_NEEDED = tuple(name for name in data_topics() if name not in ("encoders", "rotor_state"))


def reference_legs(record: Flown) -> list[Leg]:
    """The stretches of constant reference while flying, without those on the lower stop."""
    stamps, reference = record.reference
    legs: list[Leg] = []
    for stage in record.stages:
        if stage.state is FlightState.FLYING:
            inside = (stamps >= stage.start_ns) & (stamps < stage.end_ns)
            legs += _legs(stamps[inside], reference[inside], stage.end_ns)
    return [leg for leg in legs if leg.reference[2] < ON_THE_STOP]


def _legs(stamps: Stamps, reference: Array, end_ns: int) -> list[Leg]:
    if not len(stamps):
        return []
    change = np.diff(reference, axis=0)
    change[:, 3] = (change[:, 3] + math.pi) % (2.0 * math.pi) - math.pi
    periods = np.maximum(np.diff(stamps) / CONTROL_PERIOD_NS, 1.0)[:, None]
    moved = np.any(np.abs(change) > 1e-7, axis=1)
    jumped = np.any(np.abs(change) > _JUMP * periods, axis=1)
    starts = [0, *(np.flatnonzero(moved) + 1).tolist()]
    ends = [*starts[1:], len(stamps)]
    legs = []
    for start, end in zip(starts, ends, strict=True):
        jump = change[start - 1] if start and jumped[start - 1] else None
        last_ns = int(stamps[end]) if end < len(stamps) else end_ns
        leg = Leg(int(stamps[start]), last_ns, reference[start], jump)
        if jump is not None or leg.duration >= SHORTEST_HOVER:
            legs.append(leg)
    return legs


def _errors(record: Flown, leg: Leg, start_ns: int, end_ns: int) -> tuple[Array, Array, Array]:
    """Time since the leg's start [s], true pose minus reference (n, 4), and attitude (n, 3)."""
    truth = record.truth
    inside = (truth.stamps >= start_ns) & (truth.stamps <= end_ns)
    pose = np.column_stack((truth.position, truth.attitude[:, 0]))[inside]
    error = pose - leg.reference
    error[:, 3] = (error[:, 3] + math.pi) % (2.0 * math.pi) - math.pi
    return seconds(truth.stamps[inside] - leg.start_ns), error, truth.attitude[inside]


def hover_start(leg: Leg) -> int:
    """Stamp [ns] from which a hover is judged."""
    return leg.start_ns + round(min(HOVER_SETTLING, leg.duration / 3.0) * 1e9)


def hover_metrics(record: Flown, leg: Leg) -> dict[str, float]:
    """Deviation of the true pose from a constant reference; empty without ground truth."""
    start_ns = hover_start(leg)
    _, error, attitude = _errors(record, leg, start_ns, leg.end_ns)
    if not len(error):
        return {}
    found: dict[str, float] = {"start_s": start_ns * 1e-9, "duration_s": (leg.end_ns - start_ns) * 1e-9}
    for axis, unit, column in zip(AXES, UNITS, error.T, strict=True):
        found[f"sigma_{axis}_{unit}"] = float(np.std(column))
        found[f"rms_{axis}_{unit}"] = float(np.sqrt(np.mean(column**2)))
        found[f"mean_{axis}_{unit}"] = float(np.mean(column))
        found[f"max_{axis}_{unit}"] = float(np.max(np.abs(column)))
    found["max_xy_m"] = float(np.max(np.hypot(error[:, 0], error[:, 1])))
    for name, column in zip(("theta", "phi"), attitude[:, 1:].T, strict=True):
        found[f"sigma_{name}_rad"] = float(np.std(column))
        found[f"mean_{name}_rad"] = float(np.mean(column))
    return found


def step_metrics(record: Flown, leg: Leg) -> dict[str, Any]:
    """Response of the true pose to a step of the reference; empty without ground truth.

    The response counts from the old reference (0) to the new one (1).
    """
    if leg.jump is None:
        raise ValueError("the leg does not begin with a step")
    time, error, attitude = _errors(record, leg, leg.start_ns, leg.end_ns)
    if not len(time):
        return {}
    axis = step_axis(leg)
    name, unit, amplitude = AXES[axis], UNITS[axis], float(leg.jump[axis])
    response = 1.0 + error[:, axis] / amplitude
    first, last = _crossing(time, response, 0.1), _crossing(time, response, 0.9)
    at_six = np.flatnonzero(np.abs(time - STEP_ERROR_TIME) < 0.5 * CONTROL_PERIOD_NS * 1e-9)
    found: dict[str, Any] = {
        "axis": name,
        "start_s": leg.start_ns * 1e-9,
        "duration_s": leg.duration,
        f"amplitude_{unit}": amplitude,
        "rise_time_s": last - first if first is not None and last is not None else None,
        "overshoot_percent": 100.0 * max(0.0, float(np.max(response)) - 1.0),
        "settling_time_s": _settling(time, error[:, axis], SETTLING_BAND[unit]),
        f"settling_band_{unit}": SETTLING_BAND[unit],
        f"final_error_{unit}": float(np.mean(error[time > time[-1] - FINAL_WINDOW, axis])),
        f"error_at_6s_{unit}": float(error[at_six[0], axis]) if len(at_six) else None,
    }
    for other, other_unit, column in zip(AXES, UNITS, error.T, strict=True):
        if other != name:
            found[f"cross_{other}_max_{other_unit}"] = float(np.max(np.abs(column)))
    before = attitude[time < leg.duration]
    for angle, column in zip(("theta", "phi"), before[:, 1:].T, strict=True):
        found[f"{angle}_range_rad"] = float(np.ptp(column))
    return found


def step_axis(leg: Leg) -> int:
    """Which of the axes steps: its place in `AXES`.

    Raises:
        ValueError: the leg does not begin with a step.
    """
    if leg.jump is None:
        raise ValueError("the leg does not begin with a step")
    return int(np.argmax(np.abs(leg.jump) / _JUMP))


def _crossing(time: Array, response: Array, level: float) -> float | None:
    """When the response first reaches a level, between samples by a straight line; None if it never does."""
    reached = np.flatnonzero(response >= level)
    if not len(reached):
        return None
    index = int(reached[0])
    if index == 0:
        return float(time[0])
    before, after = float(response[index - 1]), float(response[index])
    part = (level - before) / (after - before)
    return float(time[index - 1] + part * (time[index] - time[index - 1]))


def _settling(time: Array, error: Array, band: float) -> float | None:
    """From when on the error stays within the band; None if it is outside at the end."""
    outside = np.flatnonzero(np.abs(error) > band)
    if not len(outside):
        return 0.0
    index = int(outside[-1])
    return float(time[index + 1]) if index + 1 < len(time) else None


def rotor_metrics(record: FlightRecord) -> dict[str, float]:
    """Rotor speed against its reference while controlled in the air; empty if never or unknown."""
    stamps, speed = record.rotor_speed
    reference_stamps, reference = record.rotor_reference
    _, here, there = np.intersect1d(stamps, reference_stamps, return_indices=True)
    wanted = reference[there]
    chosen = controlled(record, stamps[here]) & (wanted > 0.0)
    if not np.any(chosen):
        return {}
    speed, wanted = speed[here][chosen], wanted[chosen]
    deviation = 100.0 * (speed - wanted) / wanted
    return {
        "mean_rad_s": float(np.mean(speed)),
        "reference_rad_s": float(wanted[-1]),
        "max_deviation_percent": float(np.max(np.abs(deviation))),
        "rms_deviation_percent": float(np.sqrt(np.mean(deviation**2))),
    }
