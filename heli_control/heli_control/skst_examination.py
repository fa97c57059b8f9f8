"""Why the source drops S/KS/T, on any plant: assumption A5 and the poles of the plant that it cancels (3.4).

In S/KS/T nothing disturbs the input of the plant (B1 of the plant is zero), so [A - jw, B1; C2, D21] loses
rank wherever jw is a pole of the plant: a plant that integrates violates A5, a slow one is near to it. For
the same reason it costs nothing to cancel a slow pole: no error shows it. GS/T disturbs the input of the
plant and has neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from heli_control.assumptions import Assumption, check_assumptions
from heli_control.flight_plants import FlightPlant
from heli_control.generalized_plant import GeneralizedPlant, with_balanced_states
from heli_control.mixed_sensitivity import gs_t, s_ks_t
from heli_control.realisation import Array, Realisation, diagonal, gain
from heli_control.schemes import AxisWeights
from heli_control.system_properties import Cancellation, cancellations
from heli_control.uncertainty import closed_operators

INTEGRALS = {"u": "x", "v": "y", "w": "z", "r": "psi"}
"""What the integral of an output is."""

SLOW = 1.0
"""Poles of the plant below this are looked at [rad/s]."""

_APPENDED_WEIGHT, _APPENDED_NOISE = 0.1, 0.001


@dataclass(frozen=True)
class RankCase:
    """Assumption A5 of one scheme on one plant.

    Attributes:
        scheme: `S/KS/T` or `GS/T`.
        appended: integrals that the plant has as further outputs.
        control: A5 of (B2, C1). disturbance: A5 of (B1, C2).
    """

    scheme: str
    appended: tuple[str, ...]
    control: Assumption
    disturbance: Assumption


@dataclass(frozen=True)
class SlowPole:
    """A slow pole of the plant under one controller.

    Attributes:
        cancellation: the nearest zero of the controller, and how far the mode is hidden in K G.
        closed: the nearest pole of the closed loop [rad/s].
    """

    cancellation: Cancellation
    closed: complex

    @property
    def moved(self) -> float:
        """How far feedback moves the pole [rad/s]; 0 leaves it where it was."""
        return abs(self.closed - self.cancellation.pole)


def with_integrals(plant: Realisation, rows: Sequence[int]) -> Realisation:
    """The plant with the integrals of some of its outputs as further outputs and states.

    Args:
        plant: n states, p outputs.
        rows: indices of q outputs.

    Returns:
        n + q states, p + q outputs.
    """
    a, b, c, d = plant
    q = len(rows)
    picked, rest = np.eye(len(c))[list(rows)], np.zeros((len(a), q))
    return Realisation(
        np.block([[a, rest], [picked @ c, np.zeros((q, q))]]),
        np.vstack((b, picked @ d)),
        np.block([[c, np.zeros((len(c), q))], [np.zeros((q, len(a))), np.eye(q)]]),
        np.vstack((d, np.zeros((q, d.shape[1])))),
    )


def rank_cases(
    plant: FlightPlant, s_ks_t_weights: AxisWeights, gs_t_weights: AxisWeights
) -> tuple[RankCase, ...]:
    """A5 of both schemes: on the plant, with psi or position appended one after another.

    Appended outputs are weighted as the angles are, constant; scaled as the rates they are integrals of.

    Args:
        plant: of one axis.
        s_ks_t_weights, gs_t_weights: of the kinds `skst` and `gst`.
    """
    names = plant.si.outputs
    # psi before z: the source names the heading first
    order = sorted((name for name in names if name in INTEGRALS), key=lambda name: (name != "r", name))
    chosen: list[tuple[str, ...]] = [(), *(tuple(order[: count + 1]) for count in range(len(order)))]
    if set(order) == {"u", "v"}:
        chosen = [(), tuple(order)]
    cases = []
    for appended in chosen:
        whole = with_integrals(plant.scaled, [names.index(name) for name in appended])
        for scheme, problem in (
            ("S/KS/T", _s_ks_t(whole, s_ks_t_weights, len(appended))),
            ("GS/T", _gs_t(whole, gs_t_weights, len(appended))),
        ):
            checked = {one.name: one for one in check_assumptions(with_balanced_states(problem))}
            called = tuple(INTEGRALS[name] for name in appended)
            cases.append(RankCase(scheme, called, checked["A5 (B2, C1)"], checked["A5 (B1, C2)"]))
    return tuple(cases)


def slow_poles(
    plant: Realisation, controller: Realisation, slower_than: float = SLOW
) -> tuple[SlowPole, ...]:
    """The slow poles of a plant, what the controller cancels of them and what feedback leaves of them.

    Args:
        plant: G, scaled.
        controller: u = K y, scaled, the minus sign of the feedback included.
        slower_than: [rad/s].

    Raises:
        ValueError, SynthesisRefused: see `uncertainty.closed_operators`.
    """
    closed = np.linalg.eigvals(closed_operators(plant, controller)["S_u"].A)
    return tuple(
        SlowPole(one, complex(closed[np.argmin(np.abs(closed - one.pole))]))
        for one in cancellations(controller, plant, slower_than)
    )


def _s_ks_t(plant: Realisation, weights: AxisWeights, appended: int) -> GeneralizedPlant:
    more = _constant(_APPENDED_WEIGHT, appended)
    return s_ks_t(
        plant,
        diagonal(weights.stacked("W_e"), more),
        weights.stacked("W_u"),
        diagonal(weights.stacked("W_y"), more),
    )


def _gs_t(plant: Realisation, weights: AxisWeights, appended: int) -> GeneralizedPlant:
    return gs_t(
        plant,
        weights.stacked("W_u"),
        diagonal(weights.stacked("W_y"), _constant(_APPENDED_WEIGHT, appended)),
        weights.stacked("W_v"),
        diagonal(weights.stacked("W_d"), _constant(_APPENDED_NOISE, appended)),
    )


def _constant(value: float, size: int) -> Realisation:
    matrix: Array = value * np.eye(size)
    if size:
        return gain(matrix)
    nothing = np.zeros((0, 0))
    return Realisation(nothing, nothing, nothing, nothing)
