"""Figures of a flight beside the deviation from its reference: commands, wind, estimation, sampling.

SI with the unit in the key, ready for JSON; what was not recorded is an empty list.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heli_common.topics import SERVO_CHANNELS, TOPICS
from heli_flight.estimation_error import estimation_errors
from heli_flight.flight_hash import TopicCount
from heli_flight.flight_record import Array, FlightRecord, Stamps

SERVO_LIMITS = tuple(
    (math.radians(low), math.radians(high))
    for low, high in ((-10.0, 10.0), (-10.0, 10.0), (-4.0, 16.0), (-5.0, 25.0))
)
"""Travel of B_1s, A_1s, theta_0, theta_t [rad] (spec 2.5).

The two cyclic angles share their range: less of it is left at hover."""

VOLTAGE_LIMITS = (0.0, 10.0)
"""Of the motor's control voltage [V]."""

NEAR_LIMIT = 0.02
"""Share of a travel next to its ends that counts as being at the limit."""


def controlled(record: FlightRecord, stamps: Stamps) -> NDArray[np.bool_]:
    """Which stamps lie in a stage in which the controllers steer, shape (n,)."""
    inside = np.zeros(len(stamps), dtype=np.bool_)
    for stage in record.stages:
        if stage.state.controlled:
            inside |= (stamps >= stage.start_ns) & (stamps < stage.end_ns)
    return inside


def command_metrics(record: FlightRecord) -> list[dict[str, Any]]:
    """Range, spread, rate and time at the limits of every command while the controllers steer."""
    stamps, angles = record.servo_command
    volts = record.motor_voltage
    found = [
        _command(record, name, "rad", stamps, angles[:, column], SERVO_LIMITS[column])
        for column, name in enumerate(SERVO_CHANNELS)
    ]
    found.append(_command(record, "motor", "V", volts[0], volts[1], VOLTAGE_LIMITS))
    return [one for one in found if one]


def _command(
    record: FlightRecord, name: str, unit: str, stamps: Stamps, values: Array, limits: tuple[float, float]
) -> dict[str, Any]:
    chosen = controlled(record, stamps)
    stamps, values = stamps[chosen], values[chosen]
    if len(values) < 2:
        return {}
    margin = NEAR_LIMIT * (limits[1] - limits[0])
    rates = np.diff(values) / (np.diff(stamps) * 1e-9)
    return {
        "channel": name,
        f"lower_limit_{unit}": limits[0],
        f"lowest_{unit}": float(np.min(values)),
        f"mean_{unit}": float(np.mean(values)),
        f"highest_{unit}": float(np.max(values)),
        f"upper_limit_{unit}": limits[1],
        f"sigma_{unit}": float(np.std(values)),
        f"rms_rate_{unit}_s": float(np.sqrt(np.mean(rates**2))),
        "at_limit_percent": 100.0
        * float(np.mean((values <= limits[0] + margin) | (values >= limits[1] - margin))),
    }


def wind_metrics(record: FlightRecord) -> list[dict[str, Any]]:
    """Mean, spread and extremes of the air's velocity while the controllers steer; north, east, up."""
    series = record.series["wind"]
    chosen = controlled(record, series.stamps)
    if not chosen.any():
        return []
    found = []
    for name, field in (("north", "vector.y"), ("east", "vector.x"), ("up", "vector.z")):
        values = series.column(field)[chosen]
        found.append(
            {
                "axis": name,
                "mean_m_s": float(np.mean(values)),
                "sigma_m_s": float(np.std(values)),
                "lowest_m_s": float(np.min(values)),
                "highest_m_s": float(np.max(values)),
            }
        )
    return found


def estimation_metrics(record: FlightRecord) -> list[dict[str, Any]]:
    """Error of every estimated quantity while the controllers steer, beside what the navigation claims."""
    found = []
    for error in estimation_errors(record):
        chosen = controlled(record, error.stamps)
        if not chosen.any():
            continue
        values, sigma = error.values[chosen], error.sigma[chosen]
        found.append(
            {
                "quantity": error.name,
                f"rms_{error.unit}": float(np.sqrt(np.mean(values**2))),
                f"mean_{error.unit}": float(np.mean(values)),
                f"max_{error.unit}": float(np.max(np.abs(values))),
                f"claimed_sigma_{error.unit}": float(np.sqrt(np.mean(sigma**2))),
                "inside_two_sigma_percent": 100.0 * float(np.mean(np.abs(values) <= 2.0 * sigma)),
            }
        )
    return found


def sampling_metrics(record: FlightRecord, counts: Sequence[TopicCount]) -> list[dict[str, Any]]:
    """Rate, losses and longest pause of every topic, in the order of the counts.

    Args:
        record: of the flight.
        counts: of its bag.
    """
    found = []
    for count in counts:
        stamps = np.unique(np.asarray(record.bag.stamps[count.topic], dtype=np.int64))
        pauses = np.diff(stamps)
        regular = count.expected is not None
        found.append(
            {
                "topic": count.topic,
                "type": count.ros_type,
                "messages": count.messages,
                "expected": count.expected,
                "lost": count.lost,
                "gaps": count.gaps,
                "first_gap_s": None if count.first_gap_ns is None else count.first_gap_ns * 1e-9,
                "nominal_rate_hz": 1e9 / TOPICS[count.topic].period_ns if regular else None,
                "rate_hz": 1e9 * len(pauses) / float(pauses.sum()) if len(pauses) else None,
                "longest_pause_s": float(pauses.max()) * 1e-9 if len(pauses) else None,
            }
        )
    return found
