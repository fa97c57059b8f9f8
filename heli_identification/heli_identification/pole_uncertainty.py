"""Poles of an identified model with the scatter that its coefficients' covariance gives them."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig
from scipy.stats import chi2

from heli_identification.structures import Structure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class UncertainPoles:
    """Poles to first order about the estimate.

    Attributes:
        values: shape (n,).
        covariance: of real and imaginary part [1/s^2], shape (n, 2, 2).
    """

    values: ComplexArray
    covariance: Array

    def ellipse(self, index: int, level: float = 0.95, points: int = 73) -> ComplexArray:
        """Closed curve that holds a pole with a probability, shape (points,); a line for a real pole.

        Args:
            index: of the pole.
            level: probability, 0 .. 1.
            points: of the curve.
        """
        variances, axes = np.linalg.eigh(self.covariance[index])
        # a real pole scatters along one line only
        freedom = 1 if self.values[index].imag == 0.0 else 2
        radius = np.sqrt(chi2.ppf(level, freedom) * np.maximum(variances, 0.0))
        angle = np.linspace(0.0, 2.0 * pi, points)
        curve = axes @ (radius[:, None] * np.array([np.cos(angle), np.sin(angle)]))
        found: ComplexArray = self.values[index] + curve[0] + 1j * curve[1]
        return found


def uncertain_poles(structure: Structure, covariance: Array) -> UncertainPoles:
    """Poles and their scatter:  d lambda = w' dA v / (w' v)  with right and left eigenvectors v, w.

    Poles that nearly coincide scatter more than this first order says.

    Args:
        structure: with values; its free parameters are those of the covariance.
        covariance: shape (r, r); parameters of infinite variance count as known.
    """
    free = structure.index(structure.free_names)
    a, _ = structure.matrices(structure.values)
    slopes = structure.derivatives(structure.values)[0][free]
    values, left, right = eig(a, left=True, right=True)
    order = np.lexsort((-values.imag, np.round(-np.abs(values), 9)))
    values, left, right = values[order], left[:, order], right[:, order]
    overlap = np.einsum("in,in->n", left.conj(), right)
    moved = np.einsum("in,rij,jn->rn", left.conj(), slopes, right) / overlap
    parts = np.stack((moved.real, moved.imag), axis=1)
    usable = np.where(np.isfinite(covariance), covariance, 0.0)
    scatter = np.einsum("rin,rs,sjn->nij", parts, usable, parts)
    real = values.imag == 0.0
    scatter[real, 1, :] = scatter[real, :, 1] = 0.0
    return UncertainPoles(values, scatter)
