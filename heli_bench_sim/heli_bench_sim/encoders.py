"""Six incremental encoders: three arms, then yaw, pitch and roll of the gimbal (spec 2.2).

They count from power-up, wherever the rig then rests. Each has one index pulse at a known angle; once that
has passed, the count is absolute.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_common.rig_geometry import ENCODER_NAMES, RADIAN_PER_COUNT

Array = NDArray[np.float64]
Counters = NDArray[np.int64]

ENCODERS = len(ENCODER_NAMES)

INDEX_OFFSET = math.radians(5.0)
"""Index pulse from the rest position: arms upwards, gimbal axes in the positive sense (D)."""


class Counter(IntEnum):
    """Rows of what the six counters remember."""

    line = 0
    """line of the disc at the latest sample"""
    power_up = 1
    """line at power-up, where the count began"""
    index = 2
    """line of the index pulse"""
    indexed = 3
    """1 once that has been crossed"""


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


def whole_counts(angles: Array) -> Counters:
    """Nearest line of the disc for each angle [rad], halves upwards.

    Args:
        angles: (n,) shaft angles [rad].
    """
    return np.floor(angles / RADIAN_PER_COUNT + 0.5).astype(np.int64)


def power_up(angles: Array, rest_angles: Array) -> Counters:
    """(4, 6) counters in the rows of `Counter` that have just been switched on.

    Args:
        angles: (6,) true angles now [rad].
        rest_angles: (6,) angles of the rig at rest [rad], from which the index pulses are laid out.

    Raises:
        ValueError: not six finite angles.
    """
    lines, index = whole_counts(_six(angles)), whole_counts(_six(rest_angles) + INDEX_OFFSET)
    return np.array([lines, lines, index, np.zeros_like(lines)])


@compiled
def follow(angles: Array, counters: Counters) -> None:
    """Follow the shafts to their new angles; crossing an index pulse either way counts.

    To be called at every sensor sample, so that no index pulse is missed.

    Args:
        angles: (6,) true angles now [rad], finite.
        counters: (4, 6) in the rows of `Counter`, overwritten.
    """
    for encoder in range(ENCODERS):
        line = math.floor(angles[encoder] / RADIAN_PER_COUNT + 0.5)
        index = counters[Counter.index, encoder]
        if (counters[Counter.line, encoder] >= index) != (line >= index):
            counters[Counter.indexed, encoder] = 1
        counters[Counter.line, encoder] = line


@compiled
def count(encoder: int, counters: Counters) -> int:
    """What one encoder says: absolute once indexed, else since power-up.

    Args:
        encoder: which, in the order of `ENCODER_NAMES`.
        counters: (4, 6) in the rows of `Counter`.
    """
    line = counters[Counter.line, encoder]
    return int(line if counters[Counter.indexed, encoder] else line - counters[Counter.power_up, encoder])


def _six(angles: Array) -> Array:
    array = np.asarray(angles, dtype=np.float64)
    if array.shape != (ENCODERS,) or not np.isfinite(array).all():
        raise ValueError(f"{angles!r} is not {ENCODERS} finite angles")
    return array
