"""Curves of a flight on one time base, and the same references flown on the linear plant beside it."""

from __future__ import annotations

from math import inf

import numpy as np

from heli_common.timing import PWM_PERIOD_NS
from heli_control.controller_file import load_controller
from heli_flight.flight_record import Array, FlightRecord, Stamps, swap_body
from heli_flight.parameter_file import NodeValues

CURVES_EVERY = 2
"""Of 100 Hz samples."""

AXES = ("x", "y", "z", "psi", "theta", "phi", "u", "v", "w", "p", "q", "r")
LINEAR = ("x", "y", "theta", "phi", "u", "v")
"""What the linear plant gives, under the name with `linear_` in front."""


def true_motion(record: FlightRecord) -> dict[str, Array]:
    """The true motion by name of AXES, at its own stamps."""
    truth = record.truth
    psi, theta, phi = truth.attitude.T
    every = (*truth.position.T, np.unwrap(psi), theta, phi, *truth.velocity.T, *truth.rates.T)
    return dict(zip(AXES, every, strict=True))


def curves_of(
    record: FlightRecord, start: float, end: float = inf, every: int = CURVES_EVERY
) -> dict[str, Array]:
    """Motion, commands and references on one time base that begins at `start` [s]."""
    truth = record.truth
    chosen = np.flatnonzero((truth.time >= start - 1e-9) & (truth.time < end))[::every]
    time = truth.time[chosen]
    curves = {name: column[chosen] for name, column in true_motion(record).items()}
    stamps, reference = record.reference
    curves |= {
        f"{name}_ref": _at(time, stamps, reference[:, i]) for i, name in enumerate(("x", "y", "z", "psi"))
    }
    stamps, command = record.servo_command
    curves |= {
        name: _at(time, stamps, command[:, i])
        for i, name in enumerate(("B_1s", "A_1s", "theta_0", "theta_t"))
    }
    stamps, wanted = record.velocity_reference
    curves |= {f"{name}_ref": _at(time, stamps, wanted[:, i]) for i, name in enumerate(("u", "v"))}
    return {"time": time - start} | curves


def _at(time: Array, stamps: Stamps, values: Array) -> Array:
    """The newest value at each time; a reference jumps, and is not to be drawn as a slope."""
    places = np.searchsorted(stamps * 1e-9, time + 1e-9, side="right") - 1
    return np.asarray(values[np.maximum(places, 0)], dtype=np.float64)


def linear_curves(
    record: FlightRecord, controller: str, start: float, values: NodeValues
) -> dict[str, Array]:
    """The same references on the linear plant, as curves with `linear_` in front of their names."""
    stamps, reference = record.reference
    first_ns = round(start * 1e9 / PWM_PERIOD_NS) * PWM_PERIOD_NS
    chosen = stamps >= first_ns
    extra = record.series["reference_excitation"]
    feed = np.zeros((len(stamps), 2))
    if len(extra.stamps):
        turned = swap_body(extra.columns(extra.fields[:3]))
        _, ours, theirs = np.intersect1d(stamps, extra.stamps, return_indices=True)
        feed[ours] = turned[theirs, :2]
    flown = fly_linear(load_controller(controller), reference[chosen, :2], feed[chosen], values)
    truth = record.truth
    time = truth.time[np.flatnonzero(truth.time >= start - 1e-9)[::CURVES_EVERY]] - first_ns * 1e-9
    return {f"linear_{name}": np.interp(time, flown.time, flown.column(name)) for name in LINEAR}
