"""Levenberg-Marquardt on the likelihood: Fisher's information as curvature, damped where it misleads.

D. Marquardt, 1963; steps that overshoot are shortened to the minimum of a parabola.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_identification.criterion import Criterion

Array = NDArray[np.float64]

LONGEST_STEP = 3.0
"""Of an unknown in one step: several times its expected size, or a factor of 20 in a variance."""


@dataclass(frozen=True)
class Step:
    """One accepted step of the search: stage, criterion before it, expected gain."""

    stage: str
    cost: float
    gain: float


def minimise(
    criterion: Criterion,
    vector: Array,
    active: NDArray[np.bool_],
    limits: tuple[int, float],
    stage: str,
    steps: list[Step],
) -> tuple[Array, bool]:
    """The minimum over the active unknowns, as far as it was reached.

    Args:
        criterion: to be minimised.
        vector: start, shape (P,), scaled.
        active: unknowns that may move, shape (P,).
        limits: number of steps, and the expected gain below which the search is at its end.
        stage: name of this part of the search.
        steps: accepted steps are added here.

    Returns:
        the vector reached, and whether it is the minimum.
    """
    iterations, tolerance = limits
    damping, evaluation = 1e-4, criterion.evaluate(vector)
    for _ in range(iterations):
        information = evaluation.information[np.ix_(active, active)]
        gradient = evaluation.gradient[active]
        diagonal = np.maximum(np.diag(information), 1e-9)
        accepted = False
        while damping < 1e8:
            step = -np.linalg.solve(information + np.diag(damping * diagonal), gradient)
            step *= min(1.0, LONGEST_STEP / max(1e-300, float(np.max(np.abs(step)))))
            gain = float(-gradient @ step - 0.5 * step @ information @ step)
            candidate = vector.copy()
            candidate[active] += step
            cost = criterion.cost(candidate)
            if cost <= evaluation.cost:
                candidate = _along(
                    criterion, vector, candidate, (evaluation.cost, cost), float(gradient @ step)
                )
                accepted = True
                break
            if gain < tolerance:
                break
            damping *= 10.0
        if not accepted:
            return vector, gain < 1e2 * tolerance
        steps.append(Step(stage, evaluation.cost, gain))
        vector, damping = candidate, max(damping / 10.0, 1e-10)
        evaluation = criterion.evaluate(vector)
        if gain < tolerance:
            return vector, True
    return vector, False


def _along(
    criterion: Criterion, vector: Array, candidate: Array, costs: tuple[float, float], slope: float
) -> Array:
    """The candidate, or the minimum of a parabola before it if that is better.

    Where the noise is not of the model's kind, Fisher's information is not the curvature and steps overshoot.

    Args:
        criterion: to be minimised.
        vector: where the step began.
        candidate: where it ended.
        costs: at both.
        slope: of the cost along the step, at its beginning.
    """
    curvature = costs[1] - costs[0] - slope
    if curvature <= 0.0 or not 0.05 < (share := -0.5 * slope / curvature) < 0.8:
        return candidate
    shorter: Array = vector + share * (candidate - vector)
    return shorter if criterion.cost(shorter) < costs[1] else candidate
