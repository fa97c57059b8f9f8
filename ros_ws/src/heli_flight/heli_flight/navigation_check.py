"""How good the navigation of a flight was: errors, delays, honesty, beside the plain differentiator.

Errors are those of `odometry` against `ground_truth` at the control ticks of free flight. The normalised
estimation error squared (NEES) per degree of freedom is e' P^-1 e / n with the covariance in the message: 1
for a filter that knows its own error. A delay is the shift of the truth that leaves the least error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_common.flight_state import FlightState
from heli_common.rig_geometry import RigGeometry
from heli_common.rotations import wrap
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_flight.bag_reader import Bag
from heli_flight.flight_record import (
    FlightRecord,
    Motion,
    Series,
    attitude_ned,
    motion_of,
    seconds,
    swap_body,
    swap_earth,
)
from heli_navigation.differentiating_navigator import DifferentiatingNavigator, DifferentiatorParameters

Array = NDArray[np.float64]

BANDWIDTHS = (20.0, 40.0, 80.0, 160.0, 400.0)
"""Of the differentiator's velocity filter, the one that flew first among them [rad/s]."""

SETTLING = 2.0
"""Left out after take-off began [s]."""

SHIFTS: tuple[float, ...] = tuple(1e-3 * step for step in range(-10, 121))
"""Delays that are tried [s]."""


@dataclass(frozen=True)
class Row:
    """One navigation over one or several flights; rms over all axes."""

    name: str
    position: float
    """[m]"""
    velocity: float
    """[m/s]"""
    velocity_delay: float
    """[s]"""
    attitude: float
    """[rad]"""
    rates: float
    """[rad/s]"""
    rates_delay: float
    """[s]"""


@dataclass(frozen=True)
class Samples:
    """Errors of one flight at its control ticks in free flight."""

    position: Array
    """(n, 3) NED [m]"""
    velocity: Array
    """(n, 3) body FRD [m/s]"""
    attitude: Array
    """(n, 3) rotations about north, east, down [rad]"""
    rates: Array
    """(n, 3) body FRD [rad/s]"""
    velocity_delay: float
    rates_delay: float


def free_flight(record: FlightRecord) -> tuple[float, float]:
    """Begin and end of the free flight of a record [s], take-off's first seconds left out.

    Raises:
        ValueError: it never flew.
    """
    flown = [stage for stage in record.stages if stage.state is FlightState.FLYING]
    if not flown:
        raise ValueError(f"{record.bag.folder}: never flew")
    return flown[0].start_ns * 1e-9 + SETTLING, flown[-1].end_ns * 1e-9


def errors(record: FlightRecord, estimate: Motion) -> Samples:
    """Errors of an estimate at the control ticks against the flight's truth."""
    begin, end = free_flight(record)
    truth = record.truth
    stamps, ours, theirs = np.intersect1d(estimate.stamps, truth.stamps, return_indices=True)
    chosen = (stamps * 1e-9 >= begin) & (stamps * 1e-9 < end)
    ours, theirs, time = ours[chosen], theirs[chosen], seconds(stamps[chosen])
    turned = np.array(
        [
            _rotation_between(estimate.attitude[one], truth.attitude[other])
            for one, other in zip(ours, theirs, strict=True)
        ]
    )
    return Samples(
        estimate.position[ours] - truth.position[theirs],
        estimate.velocity[ours] - truth.velocity[theirs],
        turned,
        estimate.rates[ours] - truth.rates[theirs],
        delay(time, estimate.velocity[ours], truth.time, truth.velocity),
        delay(time, estimate.rates[ours], truth.time, truth.rates),
    )


def delay(time: Array, seen: Array, true_time: Array, true: Array) -> float:
    """Shift of the truth that explains best what was seen [s].

    Args:
        time: (n,) [s].
        seen: (n, 3).
        true_time: (m,) [s].
        true: (m, 3).
    """

    def left(shift: float) -> float:
        shifted = [np.interp(time - shift, true_time, true[:, axis]) for axis in range(true.shape[1])]
        return float(np.sum((seen - np.column_stack(shifted)) ** 2))

    costs = [left(shift) for shift in SHIFTS]
    best = int(np.argmin(costs))
    if not 0 < best < len(costs) - 1:
        return SHIFTS[best]
    below, middle, above = costs[best - 1 : best + 2]
    bend = below - 2.0 * middle + above
    return SHIFTS[best] + 0.5 * (below - above) / bend * (SHIFTS[1] - SHIFTS[0])


def row(name: str, flights: Sequence[Samples]) -> Row:
    """Root mean square over all axes, ticks and flights; delays as the mean over flights."""
    return Row(
        name=name,
        position=_rms([each.position for each in flights]),
        velocity=_rms([each.velocity for each in flights]),
        velocity_delay=float(np.mean([each.velocity_delay for each in flights])),
        attitude=_rms([each.attitude for each in flights]),
        rates=_rms([each.rates for each in flights]),
        rates_delay=float(np.mean([each.rates_delay for each in flights])),
    )


def differentiated(bag: Bag, bandwidth: float) -> Motion:
    """What the differentiator would have made of a flight.

    Args:
        bag: of the flight.
        bandwidth: of its velocity filter [rad/s].
    """
    parameters = DifferentiatorParameters(velocity_bandwidth=bandwidth)
    navigator = DifferentiatingNavigator(parameters, RigGeometry())
    layouts = {topic: TOPICS[topic].layout for topic in navigator.inputs}
    heard = [
        (layouts[topic].stamp(data), DATA_TOPICS.index(topic), topic, data)
        for topic in navigator.inputs
        for data in bag.messages[topic]
    ]
    rows, stamps = [], []
    for stamp_ns, _, topic, data in sorted(heard, key=lambda entry: entry[:2]):
        for message in navigator.receive(topic, stamp_ns, layouts[topic].unpack(data)[1]):
            if message.topic == "odometry":
                stamps.append(stamp_ns)
                rows.append(message.values)
    return motion_of(Series(np.array(stamps), np.array(rows), TOPICS["odometry"].layout.fields))


def nees(record: FlightRecord) -> dict[str, Array]:
    """NEES per degree of freedom of a flight, (n,) each: position, velocity, attitude, rates, gyro_bias."""
    begin, end = free_flight(record)
    samples, series = errors(record, record.estimate), record.series["odometry"]
    stamps = np.intersect1d(series.stamps, record.truth.stamps)
    chosen = (stamps * 1e-9 >= begin) & (stamps * 1e-9 < end)
    values = series.values[np.searchsorted(series.stamps, stamps[chosen])]
    pose, twist = values[:, 7:43].reshape(-1, 6, 6), values[:, 49:85].reshape(-1, 6, 6)
    bias, sigma = gyro_bias_errors(record)
    time = record.series["imu_bias"].time
    inside = (time >= begin) & (time < end)
    return {
        "position": _normalised(swap_earth(samples.position), pose[:, :3, :3]),
        "attitude": _normalised(swap_earth(samples.attitude), pose[:, 3:, 3:]),
        "velocity": _normalised(swap_body(samples.velocity), twist[:, :3, :3]),
        "rates": _normalised(swap_body(samples.rates), twist[:, 3:, 3:]),
        "gyro_bias": np.mean((bias[inside] / sigma[inside]) ** 2, axis=1),
    }


def gyro_bias_errors(record: FlightRecord) -> tuple[Array, Array]:
    """Errors of the estimated gyro biases and their own deviations, (n, 3) each, FLU [rad/s]."""
    seen, true = record.series["imu_bias"], record.series["bench_condition"]
    columns = tuple(f"position.gyro_{axis}" for axis in "xyz")
    sigmas = tuple(f"effort.gyro_{axis}" for axis in "xyz")
    rows = min(len(seen.stamps), len(true.stamps))
    error = seen.columns(columns)[:rows] - true.columns(columns)[:rows]
    return error, np.maximum(seen.columns(sigmas)[:rows], 1e-12)


@dataclass(frozen=True)
class ImuOnly:
    """The attitude by the IMU alone in free flight."""

    roll_pitch: float
    """rms of roll and pitch [rad]"""
    yaw_drift: float
    """error of yaw at the end [rad]"""
    yaw_sigma: float
    """its own deviation there [rad]"""


def imu_only(record: FlightRecord) -> ImuOnly:
    """Errors of `imu_attitude` against the truth."""
    begin, end = free_flight(record)
    series, truth = record.series["imu_attitude"], record.truth
    rows = min(len(series.stamps), len(truth.stamps))
    time = series.time[:rows]
    inside = (time >= begin) & (time < end)
    difference = attitude_ned(series.values[:rows, 0:4]) - truth.attitude[:rows]
    difference[:, 0] = [wrap(angle) for angle in difference[:, 0]]
    variance = series.column("orientation_covariance[8]")[:rows]
    return ImuOnly(
        _rms([difference[inside, 1:]]),
        float(difference[inside, 0][-1]),
        math.sqrt(float(variance[inside][-1])),
    )


def _normalised(error: Array, covariance: Array) -> Array:
    solved = np.linalg.solve(covariance, error[:, :, np.newaxis])[:, :, 0]
    return np.asarray(np.sum(error * solved, axis=1) / error.shape[1])


def _rotation_between(seen: Array, true: Array) -> Array:
    """(3,) small rotation about north, east, down that takes the true attitude to the one seen [rad]."""
    psi, theta, phi = true
    d_psi, d_theta, d_phi = wrap(float(seen[0] - psi)), seen[1] - theta, seen[2] - phi
    sin_psi, cos_psi, cos_theta = math.sin(psi), math.cos(psi), math.cos(theta)
    return np.array(
        [
            cos_psi * cos_theta * d_phi - sin_psi * d_theta,
            sin_psi * cos_theta * d_phi + cos_psi * d_theta,
            d_psi - math.sin(theta) * d_phi,
        ]
    )


def _rms(parts: Sequence[Array]) -> float:
    return math.sqrt(float(np.mean(np.concatenate([part.ravel() for part in parts]) ** 2)))
