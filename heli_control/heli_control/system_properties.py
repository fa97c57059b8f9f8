"""Controllability, observability, transmission zeros and what a controller cancels of a plant (spec 3.6).

A mode lambda is out of reach when [lambda I - A, B] loses rank (Popov, Belevitch, Hautus); the smallest
singular value says how near that is. It depends on the units of the states: scale them first. A transmission
zero is where the system matrix [A - z I, B; C, D] loses rank. A controller cancels a pole of the plant when
the pole is a zero of the controller in the direction in which the plant shows it; then the mode is hidden in
K G and stays in the closed loop as it was.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heli_control.realisation import Complex, Realisation, balanced, series

_RANK = 1e-10
"""Singular values below this share of the norm of the system matrix count as zero."""


@dataclass(frozen=True)
class Mode:
    """One pole and how well it is reached and seen.

    Attributes:
        pole: [rad/s].
        controllability: smallest singular value of [pole I - A, B].
        observability: of [pole I - A; C].
    """

    pole: complex
    controllability: float
    observability: float


@dataclass(frozen=True)
class Cancellation:
    """A pole of one system beside the nearest zero of the other.

    Attributes:
        pole: [rad/s].
        zero: the nearest [rad/s]; nan if there is none.
        distance: between both [rad/s]; infinite if there is no zero.
        hidden: how near the mode is to being lost in the series of both: the smaller Hautus distance in K G
            over that in the system alone; 0 is cancelled, 1 is untouched.
    """

    pole: complex
    zero: complex
    distance: float
    hidden: float

    @property
    def relative(self) -> float:
        """Distance over the size of the pole; a pole at zero counts as 1 rad/s."""
        return self.distance / (abs(self.pole) or 1.0)


def modes(system: Realisation) -> list[Mode]:
    """Hautus distances at every pole, slowest first."""
    return [
        Mode(complex(pole), _reach(system, pole), _sight(system, pole))
        for pole in _sorted(np.linalg.eigvals(system.A))
    ]


def is_controllable(system: Realisation, tolerance: float = 1e-9) -> bool:
    """Whether every mode is reached, relative to the norm of A and B."""
    size = float(np.linalg.norm(np.hstack((system.A, system.B)))) if system.order else 1.0
    return all(mode.controllability > tolerance * size for mode in modes(system))


def is_observable(system: Realisation, tolerance: float = 1e-9) -> bool:
    """Whether every mode is seen, relative to the norm of A and C."""
    size = float(np.linalg.norm(np.vstack((system.A, system.C)))) if system.order else 1.0
    return all(mode.observability > tolerance * size for mode in modes(system))


def transmission_zeros(system: Realisation) -> Complex:
    """Finite transmission zeros of any system, square or not, slowest first [rad/s].

    States and signals that only make infinite zeros are taken out step by step until D is square and regular
    (Emami-Naeini and Van Dooren 1982). Modes not reached or not seen count as zeros.

    Args:
        system: continuous or sampled; its states may be in any units.
    """
    scaled, _ = balanced(system)
    size = max(float(np.linalg.norm(np.block([[scaled.A, scaled.B], [scaled.C, scaled.D]]))), 1e-300)
    short = _without_infinite_zeros(scaled, _RANK * size)
    turned = Realisation(short.A.T, short.C.T, short.B.T, short.D.T)
    a, b, c, d = _without_infinite_zeros(turned, _RANK * size)
    if not len(a):
        return np.zeros(0, dtype=np.complex128)
    finite = a - b @ np.linalg.solve(d, c) if d.size else a
    return _sorted(np.linalg.eigvals(finite))


def cancellations(controller: Realisation, plant: Realisation, slower_than: float) -> list[Cancellation]:
    """Poles of the plant beside the controller's zeros, slowest first.

    Args:
        controller: K.
        plant: G; K G must exist.
        slower_than: only poles of a smaller absolute value [rad/s].
    """
    zeros = transmission_zeros(controller)
    joined = series(controller, plant)
    found = []
    for pole in _sorted(np.linalg.eigvals(plant.A)):
        if abs(pole) >= slower_than:
            continue
        zero = complex(zeros[np.argmin(np.abs(zeros - pole))]) if zeros.size else complex(np.nan, np.nan)
        distance = abs(zero - pole) if zeros.size else float("inf")
        alone = _sight(plant, pole)
        hidden = _sight(joined, pole) / alone if alone > 0.0 else 0.0
        found.append(Cancellation(complex(pole), zero, float(distance), hidden))
    return found


def _reach(system: Realisation, pole: complex) -> float:
    pencil = np.hstack((pole * np.eye(system.order) - system.A, system.B))
    return float(np.linalg.svd(pencil, compute_uv=False)[-1])


def _sight(system: Realisation, pole: complex) -> float:
    return _reach(Realisation(system.A.T, system.C.T, system.B.T, system.D.T), pole)


def _without_infinite_zeros(system: Realisation, tolerance: float) -> Realisation:
    """The system with the same finite zeros whose D has full row rank."""
    a, b, c, d = system
    while True:
        left, sizes, _ = np.linalg.svd(d, full_matrices=True)
        rank = int(np.count_nonzero(sizes > tolerance))
        c, d = left.T @ c, (left.T @ d)[:rank]
        above, below = c[:rank], c[rank:]
        # x = V [z; e] with below x = S e: outputs without feedthrough that are to stay zero keep e at zero
        _, sizes, rows = np.linalg.svd(below, full_matrices=True)
        held = int(np.count_nonzero(sizes > tolerance))
        if held == 0:
            return Realisation(a, b, above, d)
        turn = np.vstack((rows[held:], rows[:held]))
        a, b, above = turn @ a @ turn.T, turn @ b, above @ turn.T
        free = len(a) - held
        c, d = np.vstack((above[:, :free], a[free:, :free])), np.vstack((d, b[free:]))
        a, b = a[:free, :free], b[:free]


def _sorted(values: NDArray[Any]) -> Complex:
    made = np.asarray(values, dtype=np.complex128)
    return np.asarray(made[np.lexsort((made.imag, np.round(np.abs(made), 9)))], dtype=np.complex128)
