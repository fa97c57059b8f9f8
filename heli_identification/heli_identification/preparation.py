"""From recorded signals to data for an estimation (source 2.5.1, preparatory work).

Signals are joined on their stamps, cut to a segment, averaged if wanted, freed of their mean or of the
operating point, and refused when nothing can be learnt from them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.timing import CONTROL_PERIOD, CONTROL_PERIOD_NS
from heli_identification.flight_signals import Channel, FlightSignals
from heli_identification.helicopter_structures import SCALES, SHAFT_REACTION, VERTICAL
from heli_identification.records import Record
from heli_identification.servo_timing import after_converter, as_late_as_speed, servo_positions
from heli_identification.structures import Structure

Array = NDArray[np.float64]

AVERAGED = 10
"""Points of the source's averaging filter (eq. 2.68)."""
SHORTEST = 2.0
"""A piece of data shorter than this tells nothing about the slow motion [s]."""
SAMPLES_PER_PARAMETER = 10
"""Fewer samples per coefficient are refused."""
LEAST_MOTION = 0.017
"""An input that moves less than this share of its scale is at rest: a cyclic by one microsecond of pulse."""
LEAST_VOLTAGE = 0.01
"""The same for the control voltage [V]: the drive is linear over 0.06 V above hover only."""


class InputSource(Enum):
    """Where the plant's input is taken from."""

    ACTUATOR = "actuator"
    COMMAND = "command"


@dataclass(frozen=True)
class Segment:
    """A part of a flight, begin .. end [s]; None is the flight's own."""

    begin: float | None = None
    end: float | None = None

    def __str__(self) -> str:
        begin = "" if self.begin is None else f"{self.begin:g}"
        return f"{begin}-{'' if self.end is None else f'{self.end:g}'}"


def prepare(
    signals: FlightSignals,
    structure: Structure,
    segment: Segment,
    *,
    source: InputSource = InputSource.ACTUATOR,
    averaging: bool = False,
    operating_point: Mapping[str, float] | None = None,
    excited: bool = True,
) -> tuple[Record, dict[str, float]]:
    """One record for a structure, and the operating point about which it holds.

    Args:
        signals: of a flight.
        structure: says which inputs and outputs are wanted.
        segment: part of the flight.
        source: measured actuators, or commands with the servos' timing.
        averaging: the source's filter, forward and backward; coarse, see `averaged`.
        operating_point: values that are subtracted, by signal name; by default the means of the segment.
        excited: whether data are refused that do not bear an estimate; validation needs no excitation.

    Raises:
        InputError: a signal is missing, empty, too short, sampled otherwise, constant, or not excited.
    """
    named = signals.actuators if source is InputSource.ACTUATOR else signals.commands
    inputs = [_channel(named, name, source.value, signals.name) for name in structure.inputs]
    measured = signals.measured
    if structure.inputs == VERTICAL.inputs:
        measured = with_shaft_held(signals)
    outputs = [_channel(measured, name, "measured", signals.name) for name in structure.outputs]
    external = [signals.excitation[name] for name in structure.inputs if name in signals.excitation]
    stamps, columns = _joined([*inputs, *outputs, *external], segment, signals.name)
    m, p = len(inputs), len(outputs)
    u = columns[:, :m]
    if structure.inputs == ("U_mot",):
        u = after_converter(u, CONTROL_PERIOD)
        if "M_A" in structure.outputs:
            place = m + structure.outputs.index("M_A")
            columns[:, place] = as_late_as_speed(columns[:, place], CONTROL_PERIOD)
    elif source is InputSource.COMMAND:
        u = servo_positions(stamps, u, structure.inputs)
    r = columns[:, m + p :] if len(external) == m else None
    record = Record(
        signals.name, CONTROL_PERIOD, structure.inputs, structure.outputs, u, columns[:, m : m + p], r
    )
    if averaging:
        record = averaged(record)
    if excited:
        require_excited(record, structure)
    return centred(record, operating_point)


def with_shaft_held(signals: FlightSignals) -> Mapping[str, Channel]:
    """The measured signals with the yaw rate that would be seen at constant rotor speed.

    The structures of the vertical axis know no rotor speed; the shaft's acceleration acts on the body by
    r' = SHAFT_REACTION Omega', of which the measured speed relieves the yaw rate. Without it the governor's
    answer to the collective hides in N_0 and N_w.

    Args:
        signals: of a flight; one that did not record the rotor speed stays as it is.
    """
    if "r" not in signals.measured or "Omega" not in signals.measured:
        return signals.measured
    yaw, rotor = signals.measured["r"], signals.measured["Omega"]
    stamps, here, there = np.intersect1d(yaw.stamps, rotor.stamps, return_indices=True)
    if not len(stamps):
        return signals.measured
    speed = rotor.values[there]
    held = yaw.values[here] - SHAFT_REACTION * (speed - np.median(speed))
    return {**signals.measured, "r": Channel(stamps, held)}


def averaged(record: Record, points: int = AVERAGED) -> Record:
    """The source's averaging filter forward and backward on all signals: no phase, ends cut off.

    Together both passes are a triangle of 2 `points` - 1 samples: -6 dB at 28 rad/s for 10 points at 100
    Hz. It takes away much of what tells servo rotor and swash plate apart, and colours the residuals.

    Args:
        record: raw data.
        points: of the average.

    Raises:
        InputError: the record is shorter than the filter.
    """
    width = 2 * points - 1
    if len(record) < 2 * width:
        problem = f"{len(record)} samples are too few for an average of {points} points both ways"
        raise InputError(problem, allowed=f"at least {2 * width}", key=record.name)
    once = np.full(points, 1.0 / points)
    triangle = np.convolve(once, once)

    def smooth(columns: Array) -> Array:
        return np.column_stack([np.convolve(column, triangle, "valid") for column in columns.T])

    r = None if record.r is None else smooth(record.r)
    return replace(record, u=smooth(record.u), y=smooth(record.y), r=r)


def centred(record: Record, point: Mapping[str, float] | None = None) -> tuple[Record, dict[str, float]]:
    """Deviations from an operating point, or from the means; the point comes back.

    Args:
        record: absolute values.
        point: by signal name; names that are missing count as zero. None takes the means.
    """
    names = (*record.inputs, *record.outputs)
    whole = np.hstack((record.u, record.y))
    if point is None:
        centre = whole.mean(axis=0)
    else:
        centre = np.array([float(point.get(name, 0.0)) for name in names])
    m = len(record.inputs)
    r = None if record.r is None else record.r - record.r.mean(axis=0)
    moved = replace(record, u=record.u - centre[:m], y=record.y - centre[m:], r=r)
    return moved, dict(zip(names, centre.tolist(), strict=True))


def require_excited(record: Record, structure: Structure) -> None:
    """Refuse data from which the structure's coefficients cannot be learnt.

    Raises:
        InputError: says what is missing.
    """
    place = record.name
    if record.duration < SHORTEST or len(record) < SAMPLES_PER_PARAMETER * len(structure.free_names):
        wanted = max(SHORTEST, SAMPLES_PER_PARAMETER * len(structure.free_names) * record.period)
        raise InputError(
            f"{record.duration:.2f} s of data are too short for {len(structure.free_names)} coefficients",
            allowed=f"at least {wanted:.1f} s",
            key=place,
        )
    for names, columns, kind in ((record.outputs, record.y, "output"), (record.inputs, record.u, "input")):
        for name, column in zip(names, columns.T, strict=True):
            if not np.all(np.isfinite(column)):
                raise InputError(f"{kind} {name} is not finite", allowed="numbers", key=place)
            if np.ptp(column) == 0.0:
                raise InputError(f"{kind} {name} is constant", allowed="a signal that moves", key=place)
    for name, column in zip(record.inputs, record.u.T, strict=True):
        least = LEAST_VOLTAGE if name == "U_mot" else LEAST_MOTION * SCALES.get(name, 1.0)
        moved = float(np.std(column))
        if moved < least:
            problem = f"input {name} is not excited: it moves by {moved:.2g} rms"
            raise InputError(problem, allowed=f"at least {least:.2g}; add an excitation", key=place)
    order = 2 * (len(structure.states) + 1)
    u = (record.u - record.u.mean(axis=0)) / record.u.std(axis=0)
    lags = np.hstack([u[lag : len(u) - order + lag] for lag in range(order)])
    lags -= lags.mean(axis=0)
    strengths = np.linalg.svd(lags / np.sqrt(len(lags)), compute_uv=False)
    if strengths[-1] < 1e-9 * strengths[0]:
        allowed = "noise, PRBS, multisine, or inputs that move independently"
        rank = int(np.sum(strengths >= 1e-9 * strengths[0]))
        problem = f"the inputs excite {rank} of {len(strengths)} directions only"
        raise InputError(problem, allowed=allowed, key=place)


def _channel(named: Mapping[str, Channel], name: str, kind: str, flight: str) -> Channel:
    if name not in named or not len(named[name].stamps):
        raise InputError(f"no {kind} signal {name}", allowed="a flight that recorded it", key=flight)
    return named[name]


def _joined(channels: Sequence[Channel], segment: Segment, flight: str) -> tuple[NDArray[np.int64], Array]:
    """Stamps all channels share within the segment, shape (N,), and their values, shape (N, channels)."""
    stamps = channels[0].stamps
    for channel in channels[1:]:
        stamps = np.intersect1d(stamps, channel.stamps)
    if not len(stamps):
        raise InputError("inputs and outputs share no stamp", allowed="signals of one flight", key=flight)
    first, last = stamps[0] * 1e-9, stamps[-1] * 1e-9
    begin = first if segment.begin is None else segment.begin
    end = last if segment.end is None else segment.end
    inside = stamps[(stamps >= round(begin * 1e9)) & (stamps <= round(end * 1e9))]
    if not len(inside):
        allowed = f"within {first:.2f}-{last:.2f} s"
        raise InputError(f"segment {segment} holds no data", allowed=allowed, key=flight)
    steps = np.diff(inside)
    if len(steps) and np.any(steps != CONTROL_PERIOD_NS):
        usual, worst = int(np.median(steps)), int(np.max(steps))
        allowed = f"every {CONTROL_PERIOD * 1e3:g} ms"
        if usual != CONTROL_PERIOD_NS:
            problem = f"samples come every {usual * 1e-6:g} ms"
        else:
            at = inside[int(np.argmax(steps != CONTROL_PERIOD_NS))] * 1e-9
            problem = f"a gap of {worst * 1e-6:g} ms at {at:.2f} s"
        raise InputError(problem, allowed=allowed, key=flight)
    columns = []
    for channel in channels:
        columns.append(channel.values[np.searchsorted(channel.stamps, inside)])
    return inside, np.column_stack(columns)
