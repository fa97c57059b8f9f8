"""H-infinity norm of a stable system by the Hamiltonian method (Bruinsma and Steinbuch 1990).

gamma is a singular value of G(jw) exactly where the Hamiltonian

    H(gamma) = [ A + B R^-1 D'C            B R^-1 B'           ]      R = gamma^2 I - D'D
               [ -C'(I + D R^-1 D') C      -(A + B R^-1 D'C)'  ]

has the eigenvalue jw, so between two such frequencies the norm may be higher and nowhere else. Whether a
computed eigenvalue lies on the axis is a question rounding does not answer; therefore the imaginary parts of
all of them and the points between are tried, and gamma is an upper bound when G exceeds it at none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from heli_control.realisation import Array, Complex, Realisation, balanced, response

_ROUNDS = 60
_STABLE = 1e-14
"""A pole is stable when its real part is below -_STABLE times the norm of A: what rounding leaves of it."""


@dataclass(frozen=True)
class HinfNorm:
    """The norm of one system.

    Attributes:
        value: upper bound; infinite for an unstable system.
        lower: largest singular value seen, at `frequency`; `value` is at most (1 + 2 tolerance) times it.
        frequency: where it was seen [rad/s]; may be infinite.
        unstable_pole: the pole furthest to the right of an unstable system, else None.
    """

    value: float
    lower: float
    frequency: float
    unstable_pole: complex | None = None


def hinf_norm(system: Realisation, tolerance: float = 1e-6) -> HinfNorm:
    """Largest singular value on the imaginary axis.

    Args:
        system: continuous, n states.
        tolerance: relative, between 1e-9 and 1e-1.

    Raises:
        ValueError: a tolerance outside.
    """
    if not 1e-9 <= tolerance <= 1e-1:
        raise ValueError(f"tolerance {tolerance}; allowed: 1e-9 .. 1e-1")
    scaled, _ = balanced(system)
    pole = unstable_pole(scaled)
    if pole is not None:
        return HinfNorm(math.inf, math.inf, abs(pole.imag), pole)
    lower, frequency = grid_norm(scaled, natural_frequencies(scaled))
    if lower == 0.0 and not (np.any(scaled.C) and np.any(scaled.B)):
        return HinfNorm(0.0, 0.0, 0.0)
    lower = max(lower, np.finfo(float).tiny ** 0.25)
    for _ in range(_ROUNDS):
        gamma = (1.0 + 2.0 * tolerance) * lower
        level, where = grid_norm(scaled, crossing_candidates(scaled, gamma))
        if level <= gamma:
            return HinfNorm(gamma, max(lower, level), where if level > lower else frequency)
        lower, frequency = level, where
    return HinfNorm(math.inf, lower, frequency)  # never seen: each round climbs to a higher peak


def grid_norm(system: Realisation, omega: Array) -> tuple[float, float]:
    """Largest singular value over the given frequencies: a lower bound of the norm, and where it is.

    Args:
        system: without poles at these frequencies.
        omega: shape (k,) [rad/s], may hold infinity.

    Returns:
        the bound and its frequency [rad/s].
    """
    levels = largest_singular_values(response(system, omega))
    index = int(np.argmax(levels))
    return float(levels[index]), float(omega[index])


def largest_singular_values(stack: Complex) -> Array:
    """Of each matrix of a stack, shape (k, p, m); zero for an empty matrix."""
    if 0 in stack.shape[1:]:
        return np.zeros(len(stack))
    return np.asarray(np.linalg.svd(stack, compute_uv=False)[:, 0], dtype=np.float64)


def natural_frequencies(system: Realisation, per_decade: int = 8) -> Array:
    """Where to look [rad/s]: zero, infinity, the poles, and a grid from below to beyond them."""
    poles = np.linalg.eigvals(system.A)
    size = np.abs(poles)
    size = size[size > 0.0]
    slow, fast = (size.min(), size.max()) if size.size else (1.0, 1.0)
    count = max(2, int(per_decade * (math.log10(fast / slow) + 4.0)))
    grid = np.geomspace(1e-2 * slow, 1e2 * fast, count)
    return np.concatenate(([0.0, math.inf], np.abs(poles.imag), size, np.sort(grid)))


def crossing_candidates(system: Realisation, gamma: float) -> Array:
    """Frequencies at which G may have the singular value gamma, those between, zero and infinity.

    Args:
        system: whose D has a norm below gamma.
        gamma: level.
    """
    a, b, c, d = system
    r = gamma**2 * np.eye(d.shape[1]) - d.T @ d
    weighted = np.linalg.solve(r, np.hstack((b.T, d.T)))
    b_r, d_r = weighted[:, : len(a)], weighted[:, len(a) :]
    shifted = a + b @ d_r @ c
    # C and B balanced against each other: one scalar leaves the eigenvalues where they are
    upper, under = b @ b_r, c.T @ (np.eye(len(d)) + d @ d_r) @ c
    size, other = float(np.abs(upper).max(initial=0.0)), float(np.abs(under).max(initial=0.0))
    share = math.sqrt(other / size) if size > 0.0 and other > 0.0 else 1.0
    hamiltonian = np.block([[shifted, share * upper], [-under / share, -shifted.T]])
    points = np.unique(np.abs(np.linalg.eigvals(hamiltonian).imag))
    between = 0.5 * (points[:-1] + points[1:])
    return np.concatenate(([0.0, math.inf], points, between))


def unstable_pole(system: Realisation) -> complex | None:
    """The pole furthest to the right if it is not in the open left half plane, else None."""
    poles = np.linalg.eigvals(system.A)
    if not poles.size:
        return None
    worst = complex(poles[np.argmax(poles.real)])
    return None if worst.real < -_STABLE * float(np.linalg.norm(system.A, 2)) else worst
