"""The assumptions A1 to A5 of H-infinity synthesis (source sec. 3.3.2), each with its distance to violation.

A1  (A, B2) can be stabilised and (C2, A) detected.
A2  D11 is within reach: what of it no controller can change is smaller than gamma.
A3  D12 has full column rank: every control is felt in the errors.
A4  D21 has full row rank: every measurement is disturbed.
A5  [A - jw, B2; C1, D12] has full column rank and [A - jw, B1; C2, D21] full row rank for all w: no invariant
    zeros on the imaginary axis.

The distance is the smallest singular value of the matrix concerned, in the units of the plant: a violation
needs a change of the matrices at least that large.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from heli_control.generalized_plant import GeneralizedPlant, with_balanced_states
from heli_control.realisation import Array

_RANK = 1e-10
"""A singular value is zero when it is below this share of the largest one."""


@dataclass(frozen=True)
class Assumption:
    """One assumption on one plant.

    Attributes:
        name: A1 to A5 with the part, e.g. `A5 (B1, C2)`.
        holds: whether it is met.
        distance: smallest singular value; for A2 gamma minus what cannot be changed.
        frequency: where it is smallest [rad/s]; nan where frequency plays no part.
        text: what is wrong or how far it is, in one line.
    """

    name: str
    holds: bool
    distance: float
    frequency: float
    text: str


def check_assumptions(plant: GeneralizedPlant, gamma: float = math.inf) -> tuple[Assumption, ...]:
    """All assumptions on a plant.

    Args:
        plant: any.
        gamma: level wanted, for A2.

    Returns:
        A1 for control and measurement, A2, A3, A4, A5 for both.
    """
    floor = feedthrough_floor(plant)
    return (
        _modes("A1 (A, B2)", "stabilisable", plant.A, plant.B2),
        _modes("A1 (C2, A)", "detectable", plant.A.T, plant.C2.T),
        Assumption("A2 (D11)", floor < gamma, gamma - floor, math.nan, f"no gamma below {floor:.6g}"),
        _rank("A3 (D12)", "column", plant.D12),
        _rank("A4 (D21)", "row", plant.D21.T),
        _zeros("A5 (B2, C1)", "column", plant.A, plant.B2, plant.C1, plant.D12),
        _zeros("A5 (B1, C2)", "row", plant.A.T, plant.C2.T, plant.B1.T, plant.D21.T),
    )


def violations(plant: GeneralizedPlant, gamma: float = math.inf) -> tuple[Assumption, ...]:
    """The assumptions that do not hold, judged with balanced states."""
    return tuple(one for one in check_assumptions(with_balanced_states(plant), gamma) if not one.holds)


def feedthrough_floor(plant: GeneralizedPlant) -> float:
    """Largest singular value of the part of D11 that D12 D_K D21 cannot change: gamma is above it (A2)."""
    beside = _left_kernel(plant.D12)
    across = _left_kernel(plant.D21.T)
    parts = (beside @ plant.D11, plant.D11 @ across.T)
    return max((float(np.linalg.norm(part, 2)) for part in parts if part.size), default=0.0)


def _modes(name: str, word: str, a: Array, b: Array) -> Assumption:
    """Rank of [A - lambda, B] at each mode that does not decay."""
    size = max(np.linalg.norm(a, 2), np.linalg.norm(b, 2)) if len(a) else 1.0
    distance, worst = math.inf, complex(math.nan, math.nan)
    for mode in np.linalg.eigvals(a):
        if mode.real < -_RANK * size:
            continue
        pencil = np.hstack((a - mode * np.eye(len(a)), b))
        smallest = float(np.linalg.svd(pencil, compute_uv=False)[-1])
        if smallest < distance:
            distance, worst = smallest, complex(mode)
    holds = bool(distance > _RANK * size)
    where = f"nearest at the mode {worst:.6g}" if distance < math.inf else "all modes decay"
    return Assumption(name, holds, distance, abs(worst.imag), f"{'' if holds else 'not '}{word}: {where}")


def _rank(name: str, word: str, tall: Array) -> Assumption:
    """Full column rank of a matrix."""
    rows, columns = tall.shape
    values = np.linalg.svd(tall, compute_uv=False)
    distance = float(values[-1]) if rows >= columns else 0.0
    holds = rows >= columns and distance > _RANK * max(float(values[0]), np.finfo(float).tiny)
    text = f"{'full' if holds else 'not of full'} {word} rank: smallest singular value {distance:.3g}"
    return Assumption(name, holds, distance, math.nan, text)


def _zeros(name: str, word: str, a: Array, b: Array, c: Array, d: Array) -> Assumption:
    """Column rank of [A - jw, B; C, D] for all w."""
    n = len(a)
    if not n or d.shape[0] < d.shape[1]:
        distance = math.inf if d.shape[0] >= d.shape[1] else 0.0
        return Assumption(name, distance > 0.0, distance, math.nan, f"{word} rank by sizes alone")
    static = np.block([[a, b], [c, d]]).astype(np.complex128)
    diagonal = np.arange(n)

    def smallest(omega: Array) -> Array:
        stack = np.repeat(static[None], omega.size, axis=0)
        stack[:, diagonal, diagonal] -= 1j * omega[:, None]
        return np.asarray(np.linalg.svd(stack, compute_uv=False)[:, -1], dtype=np.float64)

    omega = _suspects(a, b, c, d)
    levels = smallest(omega)
    best = int(np.argmin(levels))
    distance, frequency = float(levels[best]), float(omega[best])
    low, high = omega[max(best - 1, 0)], omega[min(best + 1, omega.size - 1)]
    if high > low:
        finer = minimize_scalar(
            lambda w: float(smallest(np.array([w]))[0]), bounds=(low, high), method="bounded"
        )
        if finer.fun < distance:
            distance, frequency = float(finer.fun), float(finer.x)
    # A full rank of D comes first: without it the rank is lost at infinity, which is A3 or A4
    holds = distance > _RANK * float(np.linalg.norm(static, 2))
    text = f"{'full' if holds else 'not of full'} {word} rank: {distance:.3g} at {frequency:.6g} rad/s"
    return Assumption(name, holds, distance, frequency, text)


def _suspects(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Frequencies near which the rank may be lost, ascending.

    A zero on the axis is an eigenvalue there of the Hamiltonian of the LQ problem with the errors C x + D u.
    """
    poles = np.linalg.eigvals(a)
    found = [np.abs(poles), np.abs(poles.imag)]
    if np.linalg.matrix_rank(d) == d.shape[1]:
        inverse = np.linalg.pinv(d)
        shifted = a - b @ inverse @ c
        beside = c - d @ (inverse @ c)
        hamiltonian = np.block([[shifted, -b @ inverse @ inverse.T @ b.T], [-c.T @ beside, -shifted.T]])
        found.append(np.abs(np.linalg.eigvals(hamiltonian).imag))
    size = float(np.abs(poles).max(initial=1e-3))
    found.append(np.geomspace(1e-4 * size, 1e2 * size, 60))
    return np.asarray(np.unique(np.concatenate(([0.0], *found))), dtype=np.float64)


def _left_kernel(matrix: Array) -> Array:
    """Rows that span what is orthogonal to the columns."""
    u, s, _ = np.linalg.svd(matrix)
    rank = int(np.sum(s > _RANK * max(float(s[0]) if s.size else 0.0, np.finfo(float).tiny)))
    return np.asarray(u[:, rank:].T, dtype=np.float64)
