"""One flight of a campaign, flown and put into one row of plain values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heli_common.flight_state import FlightState
from heli_common.timing import CONTROL_PERIOD
from heli_control.controller_file import ControllerFile
from heli_control.motor_controller_file import MotorControllerFile
from heli_flight.campaign_draws import Drawn, draw
from heli_flight.flight_log import FlightLog
from heli_flight.metrics import AXES, ON_THE_STOP, UNITS, Pose, hover_metrics, hover_start, reference_legs
from heli_flight.plan import Plan
from heli_flight.swift_flight import SwiftFlight, is_swift, plain_flight
from heli_flight.vary_file import Vary

TOUCH = 0.01
"""A helicopter so near to the depth of the lower stop while it hovers has touched it [m]."""

SIGMAS = tuple(f"sigma_{axis}_{unit}" for axis, unit in zip(AXES, UNITS, strict=True))
FIGURES = (*SIGMAS, "rms_position_m", "max_position_m", "max_xy_m", "max_tilt_rad")
"""Of the hovers of a flight; NaN where it had none."""


@dataclass(frozen=True, eq=False)
class Campaign:
    """All that a worker needs to fly any flight of a campaign.

    Attributes:
        plan: that is flown.
        vary: what varies.
        controllers: by the name that plan or vary file gives.
        motor: controller of the motor.
    """

    plan: Plan
    vary: Vary
    controllers: Mapping[str, ControllerFile]
    motor: MotorControllerFile

    def drawn(self, number: int) -> Drawn:
        """What one flight is."""
        return draw(self.plan, self.vary, number)

    def fly(self, number: int) -> dict[str, Any]:
        """One flight as a row of plain values: number, what was drawn, how it ended, its figures."""
        drawn = self.drawn(number)
        return row(drawn, self.log(drawn), self.vary.max_xy)

    def log(self, drawn: Drawn) -> FlightLog:
        """Fly."""
        plan, values = drawn.plan, drawn.values
        first, *later = [self.controllers[name] for name in plan.controllers]
        if is_swift(plan):
            return SwiftFlight(plan, plan.seed, first, values, self.motor).fly()
        return plain_flight(plan, plan.seed, first, values, self.motor, later)


def row(drawn: Drawn, log: FlightLog, max_xy: float = math.inf) -> dict[str, Any]:
    """One flight as plain values.

    Args:
        drawn: what was flown.
        log: of the flight.
        max_xy: largest distance from the reference in the plane of a success [m].
    """
    found, down = figures(log), touched(log)
    flown = not log.reason
    within = found["max_xy_m"] <= max_xy if flown else False
    return {
        "flight": drawn.number,
        "seed": drawn.plan.seed,
        **drawn.varied,
        "faults": ", ".join(fault.kind for fault in drawn.faults),
        "flown": flown,
        "touched": down,
        "success": flown and within and not down,
        "reason": log.reason,
        "duration_s": round(len(log.state) * CONTROL_PERIOD, 9),
        **found,
        "left_regime": ", ".join(name.removeprefix("regime_") for name in log.remarks),
        "trace": log.trace,
    }


def figures(log: FlightLog) -> dict[str, float]:
    """`FIGURES` over all hovers, weighted by their lengths."""
    flight = Pose(log.motion, (log.stamps, log.reference), log.stages)
    hovers = [hover_metrics(flight, leg) for leg in reference_legs(flight) if leg.jump is None]
    hovers = [hover for hover in hovers if hover]
    found: dict[str, float] = dict.fromkeys(FIGURES, math.nan)
    if not hovers:
        return found
    lengths = np.array([hover["duration_s"] for hover in hovers])
    share = lengths / lengths.sum()

    def rms(name: str) -> float:
        return math.sqrt(sum(w * hover[name] ** 2 for w, hover in zip(share.tolist(), hovers, strict=True)))

    for name in SIGMAS:
        found[name] = rms(name)
    found["rms_position_m"] = math.sqrt(sum(rms(f"rms_{axis}_m") ** 2 for axis in "xyz"))
    found["max_xy_m"] = max(hover["max_xy_m"] for hover in hovers)
    flying = in_hover(log)
    away = log.truth[flying, :3] - log.reference[flying, :3]
    found["max_position_m"] = float(np.max(np.linalg.norm(away, axis=1)))
    found["max_tilt_rad"] = float(np.max(np.abs(log.truth[flying, 4:])))
    return found


def in_hover(log: FlightLog) -> NDArray[np.bool_]:
    """(n,) whether a tick belongs to the judged part of a hover."""
    flight = Pose(log.motion, (log.stamps, log.reference), log.stages)
    chosen = np.zeros(len(log.state), dtype=np.bool_)
    for leg in reference_legs(flight):
        if leg.jump is None:
            chosen |= (log.stamps >= hover_start(leg)) & (log.stamps < leg.end_ns)
    return chosen


def touched(log: FlightLog) -> bool:
    """Whether the helicopter came down to the lower stop while it should have hovered."""
    flying = log.state == FlightState.FLYING
    hovering = flying & (log.reference[:, 2] < ON_THE_STOP)
    deepest = float(log.truth[0, 2]) - TOUCH if len(log.state) else math.inf
    was_up = np.maximum.accumulate(hovering & (log.truth[:, 2] < deepest - 4.0 * TOUCH))
    return bool(np.any(hovering & was_up & (log.truth[:, 2] > deepest)))
