"""What the navigation estimates less what is true, with the deviation it claims, quantity by quantity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heli_flight.flight_record import Array, FlightRecord, Stamps

_POSE, _TWIST = 7, 49
"""Where the two covariance matrices (6 by 6) begin in an odometry message."""

_ROTATION = {"psi": 5, "theta": 3, "phi": 4}
"""Rows of the pose's covariance: rotations about up, east and north, which near level and north are these."""


@dataclass(frozen=True, eq=False)
class EstimationError:
    """One quantity over time.

    Attributes:
        name: `x` to `z` (north, east, down), `theta`, `phi`, `psi`, `u` to `w`, `p` to `r`.
        unit: `m`, `rad`, `m_s`, `rad_s`.
        stamps: [ns], shape (n,).
        values: estimated less true, shape (n,).
        sigma: standard deviation by the message's covariance, shape (n,).
    """

    name: str
    unit: str
    stamps: Stamps
    values: Array
    sigma: Array


def estimation_errors(record: FlightRecord) -> list[EstimationError]:
    """Errors where both truth and an absolute estimate are known; empty if they never are.

    Args:
        record: of the flight.
    """
    truth, estimate = record.truth, record.estimate
    stamps, here, there = np.intersect1d(truth.stamps, estimate.stamps, return_indices=True)
    known = estimate.known[there]
    stamps, here, there = stamps[known], here[known], there[known]
    if not len(stamps):
        return []
    wire = record.series["odometry"].values[there]

    def sigma(start: int, row: int) -> Array:
        return np.asarray(np.sqrt(np.maximum(wire[:, start + 7 * row], 0.0)), dtype=np.float64)

    found = []
    for name, column, row in (("x", 0, 1), ("y", 1, 0), ("z", 2, 2)):
        error = estimate.position[there, column] - truth.position[here, column]
        found.append(EstimationError(name, "m", stamps, error, sigma(_POSE, row)))
    for name, column in (("theta", 1), ("phi", 2), ("psi", 0)):
        apart = estimate.attitude[there, column] - truth.attitude[here, column]
        error = (apart + np.pi) % (2.0 * np.pi) - np.pi
        found.append(EstimationError(name, "rad", stamps, error, sigma(_POSE, _ROTATION[name])))
    for column, name in enumerate("uvw"):
        error = estimate.velocity[there, column] - truth.velocity[here, column]
        found.append(EstimationError(name, "m_s", stamps, error, sigma(_TWIST, column)))
    for column, name in enumerate("pqr"):
        error = estimate.rates[there, column] - truth.rates[here, column]
        found.append(EstimationError(name, "rad_s", stamps, error, sigma(_TWIST, 3 + column)))
    return found
