"""Six incremental encoders: three arms, then yaw, pitch and roll of the gimbal (spec 2.2).

They count from power-up, wherever the rig then rests. Each has one index pulse at a known angle; once that
has passed, the count is absolute.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_common.rig_geometry import ENCODER_NAMES, RADIAN_PER_COUNT

Array = NDArray[np.float64]

ENCODERS = len(ENCODER_NAMES)

INDEX_OFFSET = math.radians(5.0)
"""Index pulse from the rest position: arms upwards, gimbal axes in the positive sense (D)."""


@dataclass(frozen=True, eq=False)
class EncoderReading:
    """One sample of all six encoders, in the order of `ENCODER_NAMES`."""

    counts: NDArray[np.int64]
    """(6,) counts, since power-up or, once indexed, absolute"""
    indexed: NDArray[np.bool_]
    """(6,) whether the index pulse has been crossed"""

    @property
    def angle(self) -> Array:
        """(6,) angles [rad]."""
        return self.counts.astype(np.float64) * RADIAN_PER_COUNT


def whole_counts(angles: Array) -> NDArray[np.int64]:
    """Nearest line of the disc for each angle [rad], halves upwards.

    Args:
        angles: (n,) shaft angles [rad].
    """
    return np.floor(angles / RADIAN_PER_COUNT + 0.5).astype(np.int64)


class Encoders:
    """The counters; `sample` must be called at every sensor sample so that no index pulse is missed."""

    def __init__(self, angles: Array, rest_angles: Array) -> None:
        """Power up.

        Args:
            angles: (6,) true angles now [rad].
            rest_angles: (6,) angles of the rig at rest [rad], from which the index pulses are laid out.
        """
        self._power_up = whole_counts(_six(angles))
        self._lines = self._power_up.copy()
        self._index = whole_counts(_six(rest_angles) + INDEX_OFFSET)
        self._indexed = np.zeros(ENCODERS, dtype=np.bool_)

    def sample(self, angles: Array) -> None:
        """Follow the shafts to their new angles (6,) [rad]; crossing an index pulse either way counts.

        Args:
            angles: (6,) true angles now [rad].
        """
        lines = whole_counts(_six(angles))
        self._indexed |= (self._lines >= self._index) != (lines >= self._index)
        self._lines = lines

    @property
    def reading(self) -> EncoderReading:
        """The counts of the latest sample."""
        counts = np.where(self._indexed, self._lines, self._lines - self._power_up)
        return EncoderReading(counts, self._indexed.copy())


def _six(angles: Array) -> Array:
    array = np.asarray(angles, dtype=np.float64)
    if array.shape != (ENCODERS,) or not np.isfinite(array).all():
        raise ValueError(f"{angles!r} is not {ENCODERS} finite angles")
    return array
