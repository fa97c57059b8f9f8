"""Recursive least squares with exponential forgetting, and what its estimate is worth (source 2.5).

    y_i = phi_i' theta + e_i,   theta minimises sum of lambda^(n-i) e_i^2

With white errors of variance s^2 the covariance of the estimate is s^2 P S P, where P inverts the weighted
information, sum of lambda^(n-i) phi phi', and S is the same sum with the weights squared; s^2 comes from the
weighted residuals, whose expectation is s^2 (sum of lambda^(n-i) - trace(P S)). Nothing is approximated,
whatever the number of samples, but the start: P is large there, not infinite.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIFFUSE = 1e8
"""Start of P: nothing is known [square of the unit of theta over that of y]."""


class RecursiveLeastSquares:
    """One linear regression, sample by sample.

    Args:
        count: of parameters, n.
        forgetting: lambda, weight of a sample relative to the one after it, above 0, at most 1.

    Attributes:
        estimate: (n,) parameters.

    Raises:
        ValueError: the forgetting factor is out of range.
    """

    def __init__(self, count: int, forgetting: float = 1.0) -> None:
        if not 0.0 < forgetting <= 1.0:
            raise ValueError(f"forgetting factor {forgetting!r} (allowed: above 0, at most 1)")
        self.estimate: Array = np.zeros(count)
        self._forgetting = forgetting
        self._inverse = DIFFUSE * np.eye(count)
        self._squared = np.zeros((count, count))
        self._weight = 0.0
        self._residual = 0.0

    def step(self, regressor: Array, measured: float) -> float:
        """Take a sample in.

        Args:
            regressor: (n,) phi.
            measured: y.

        Returns:
            The prediction error before the sample was used.
        """
        spread = self._inverse @ regressor / self._forgetting
        growth = 1.0 + float(regressor @ spread)
        error = measured - float(regressor @ self.estimate)
        self.estimate = self.estimate + spread * (error / growth)
        inverse = self._inverse / self._forgetting - np.outer(spread, spread) / growth
        self._inverse = 0.5 * (inverse + inverse.T)
        self._squared = self._forgetting**2 * self._squared + np.outer(regressor, regressor)
        self._weight = self._forgetting * self._weight + 1.0
        self._residual = self._forgetting * self._residual + error**2 / growth
        return error

    @property
    def variance(self) -> float:
        """Variance s^2 of the errors; infinite while there are no more samples than parameters."""
        left = self._weight - float(np.trace(self._inverse @ self._squared))
        return self._residual / left if left > 1e-3 else np.inf

    @property
    def covariance(self) -> Array:
        """(n, n) covariance of the estimate for white errors; infinite where nothing is known yet."""
        if not np.isfinite(self.variance):
            return np.full_like(self._inverse, np.inf)
        return np.asarray(self.variance * self._inverse @ self._squared @ self._inverse)

    @property
    def standard_error(self) -> Array:
        """(n,) square roots of the covariance's diagonal."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))
