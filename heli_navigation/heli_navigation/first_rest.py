"""Before the encoders are absolute: the gyros' means while no count changes are their biases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ENOUGH = 0.5
"""Shortest time at rest whose mean is believed [s]."""

CAUTION = 4.0
"""Factor on the variance of the mean: a hand may already have been at work within the cells."""


class FirstRest:
    """Means of the gyros whenever no encoder has changed its count for a while.

    Args:
        period: of the samples [s].
        still_time: for which no count may have changed [s].
    """

    def __init__(self, period: float, still_time: float) -> None:
        self._period, self._still_time = period, still_time
        self._angles: tuple[float, ...] = ()
        self._unchanged = 0.0
        self._sum = np.zeros(3)
        self._samples = 0

    @property
    def time(self) -> float:
        """For which the gyros have been averaged [s]."""
        return self._samples * self._period

    def add(self, angles: Sequence[float], gyro: Sequence[float]) -> None:
        """One more sample.

        Args:
            angles: of the six encoders, absolute or not [rad].
            gyro: (3,) body rates, FRD [rad/s].
        """
        now = tuple(angles)
        self._unchanged = self._unchanged + self._period if now == self._angles else 0.0
        self._angles = now
        if self._unchanged >= self._still_time:
            self._sum += gyro
            self._samples += 1

    def bias(self, density: float, prior: float) -> tuple[Array, float]:
        """(3,) biases [rad/s] and the variance of each [rad^2/s^2].

        Args:
            density: square of the gyros' noise density [rad^2/s].
            prior: variance of a bias about which nothing is known [rad^2/s^2].
        """
        if self.time < ENOUGH:
            return np.zeros(3), prior
        return self._sum / self._samples, CAUTION * density / self.time
