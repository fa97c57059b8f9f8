"""All steps of a flight over each other from the moment of the step."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

import numpy as np
from numpy.typing import NDArray

from heli_flight.flight_record import Array, FlightRecord, Stamps, seconds
from heli_flight.graphs import GREY, Curve, Graph, Kind, Plot
from heli_flight.metrics import AXES, Leg, reference_legs, step_axis

LONGEST = 10.0
"""Of a step's response in the figure [s]."""

BEFORE = 0.5
"""Shown before the step [s]."""

_DEGREE = degrees(1.0)
_ANGLE = {"x": 1, "y": 2, "z": None, "psi": None}
"""Column of the attitude that moves the helicopter along an axis."""
_CHANNEL = {"x": 0, "y": 1, "z": 2, "psi": 3}


def step_graph(records: Sequence[FlightRecord], names: Sequence[str]) -> Graph | None:
    """Response, motion of the other axes, attitude and command of every step; None without steps.

    Args:
        records: flights, at least one.
        names: one for each flight.
    """
    columns: dict[str, list[Curve]] = {"response": [], "cross": [], "angle": [], "command": []}
    longest = number = 0
    for flight, (record, name) in enumerate(zip(records, names, strict=True)):
        for leg in reference_legs(record):
            if leg.jump is None or not len(record.truth.stamps):
                continue
            axis = step_axis(leg)
            amplitude = float(leg.jump[axis])
            colour = flight if len(records) > 1 else number
            label = name if len(records) > 1 else _label(leg, axis, amplitude)
            _add(columns, record, leg, axis, label, colour)
            longest, number = max(longest, int(leg.duration)), number + 1
    if not number:
        return None
    window = (-BEFORE, min(LONGEST, max(1.0, float(longest))))
    wanted = Curve("reference", np.array([-BEFORE, 0.0, 0.0, window[1]]), np.array([0.0, 0.0, 100.0, 100.0]),
                   GREY, Kind.DASHED)  # fmt: skip
    titles = {
        "response": ("along the step", "[% of the step]"),
        "cross": ("off the step, in space", "[cm]"),
        "angle": ("pitch or roll towards the step", "[deg]"),
        "command": ("command of the step's axis", "[deg]"),
    }
    plots = [
        Plot(
            title,
            "since the step [s]",
            unit,
            (*columns[key], *((wanted,) if key == "response" else ())),
            x_range=window,
        )
        for key, (title, unit) in titles.items()
    ]
    caption = (
        "Every step turned to the same side; pitch, roll and command from before it on. Off the step: "
        "distance from the line along which the reference moved."
    )
    return Graph("steps", "Step responses", caption, (tuple(plots[:2]), tuple(plots[2:])), row_height=240)


def _label(leg: Leg, axis: int, amplitude: float) -> str:
    size = f"{degrees(amplitude):+.0f}°" if AXES[axis] == "psi" else f"{100.0 * amplitude:+.0f} cm"
    name = "ψ" if AXES[axis] == "psi" else AXES[axis]
    return f"{name} {size} at {leg.start_ns * 1e-9:.1f} s".replace("-", "−")


def _add(
    columns: dict[str, list[Curve]], record: FlightRecord, leg: Leg, axis: int, label: str, colour: int
) -> None:
    """The curves of one step."""
    if leg.jump is None:
        raise ValueError("the leg does not begin with a step")
    truth, amplitude = record.truth, float(leg.jump[axis])
    side = 1.0 if amplitude > 0.0 else -1.0
    rows, time = _window(leg, truth.stamps)
    pose = np.column_stack((truth.position, np.unwrap(truth.attitude[:, 0])))[rows]
    off = pose - leg.reference
    off[:, 3] = (off[:, 3] + np.pi) % (2.0 * np.pi) - np.pi
    if not len(time):
        return
    columns["response"].append(Curve(label, time, 100.0 * (1.0 + off[:, axis] / amplitude), colour))
    others = [column for column in range(3) if column != axis]
    columns["cross"].append(Curve(label, time, 100.0 * np.linalg.norm(off[:, others], axis=1), colour))
    angle = _ANGLE[AXES[axis]]
    if angle is not None:
        # forward is nose down, to the right is right side down
        lean = side * (-1.0 if angle == 1 else 1.0) * _DEGREE
        tilt = truth.attitude[rows, angle]
        columns["angle"].append(Curve(label, time, lean * (tilt - _at_step(time, tilt)), colour))
    stamps, commands = record.servo_command
    rows, time = _window(leg, stamps)
    if len(time):
        asked = commands[rows, _CHANNEL[AXES[axis]]]
        change = side * _DEGREE * (asked - _at_step(time, asked))
        columns["command"].append(Curve(label, time, change, colour))


def _window(leg: Leg, stamps: Stamps) -> tuple[NDArray[np.bool_], Array]:
    """Which rows are shown, and their time since the step [s]."""
    time = seconds(stamps - leg.start_ns)
    rows = (time >= -BEFORE) & (time <= min(LONGEST, leg.duration))
    return rows, time[rows]


def _at_step(time: Array, values: Array) -> float:
    """The last value before the step, to which nothing can have answered yet."""
    before = values[time < 0.0]
    return float(before[-1]) if len(before) else float(values[0])
