"""Curves of a flight on one time base, and the same references flown on the linear plant beside it."""

from __future__ import annotations

from math import inf

import numpy as np

from heli_common.timing import PWM_PERIOD_NS
from heli_common.topics import SERVO_CHANNELS
from heli_control.controller_file import load_controller
from heli_flight.flight_record import Array, swap_body
from heli_flight.linear_flight import fly_linear
from heli_flight.parameter_file import NodeValues
from heli_flight.unrecorded_flight import FlownFlight

CURVES_EVERY = 2
"""Of 100 Hz samples."""

AXES = ("x", "y", "z", "psi", "theta", "phi", "u", "v", "w", "p", "q", "r")
LINEAR = ("x", "y", "theta", "phi", "u", "v")
"""What the linear plant gives, under the name with `linear_` in front."""


def true_motion(flight: FlownFlight) -> dict[str, Array]:
    """The true motion by name of AXES, at every control tick."""
    truth = flight.truth
    psi, theta, phi = truth.attitude.T
    every = (*truth.position.T, np.unwrap(psi), theta, phi, *truth.velocity.T, *truth.rates.T)
    return dict(zip(AXES, every, strict=True))


def curves_of(
    flight: FlownFlight, start: float, end: float = inf, every: int = CURVES_EVERY
) -> dict[str, Array]:
    """Motion, commands, references and fan on one time base that begins at `start` [s].

    Args:
        flight: flown.
        start: first time [s]. end: what comes before it is kept [s].
        every: of the control ticks.
    """
    time = flight.truth.time
    chosen = np.flatnonzero((time >= start - 1e-9) & (time < end))[::every]
    curves = {"time": time[chosen] - start}
    curves |= {name: column[chosen] for name, column in true_motion(flight).items()}
    curves |= {f"{name}_ref": flight.reference[1][chosen, i] for i, name in enumerate(AXES[:4])}
    curves |= {name: flight.command[chosen, i] for i, name in enumerate(SERVO_CHANNELS)}
    return curves | {"fan": flight.fan[chosen]}


def linear_curves(flight: FlownFlight, controller: str, start: float, values: NodeValues) -> dict[str, Array]:
    """The same references on the linear plant, as curves with `linear_` in front of their names.

    Args:
        flight: flown; what it added to the velocity reference is added here, too.
        controller: that flew it.
        start: first time of the curves [s].
        values: parameters of the nodes.
    """
    stamps, reference = flight.reference
    first_ns = round(start * 1e9 / PWM_PERIOD_NS) * PWM_PERIOD_NS
    chosen = stamps >= first_ns
    feed = np.zeros((len(stamps), 2))
    extra = None if flight.record is None else flight.record.series["reference_excitation"]
    if extra is not None and len(extra.stamps):
        turned = swap_body(extra.columns(extra.fields[:3]))
        _, ours, theirs = np.intersect1d(stamps, extra.stamps, return_indices=True)
        feed[ours] = turned[theirs, :2]
    flown = fly_linear(load_controller(controller), reference[chosen, :2], feed[chosen], values)
    time = flight.truth.time
    time = time[np.flatnonzero(time >= start - 1e-9)[::CURVES_EVERY]] - first_ns * 1e-9
    return {f"linear_{name}": np.interp(time, flown.time, flown.column(name)) for name in LINEAR}
