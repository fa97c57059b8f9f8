"""H-infinity loop shaping with two degrees of freedom (source eq. 3.40, Figure 3.23; Limebeer et al. 1993).

Feedback and feed-forward K = [K_r K_y] are made together: the errors are u_s, y and rho (y - rho T_yr r), the
disturbances r and that of the normalised left coprime factors. gamma is iterated and certified. The feedback
is positive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import sqrtm

from heli_control.certified import Synthesis, synthesise
from heli_control.generalized_plant import GeneralizedPlant
from heli_control.loop_shaping import CoprimeFactors, coprime_factors, with_identity
from heli_control.pole_region import NYQUIST
from heli_control.realisation import Array, Realisation, gain, response, series, unnamed


@dataclass(frozen=True, eq=False)
class TwoDegreeLoopShaping:
    """A certified two-degree-of-freedom design.

    Attributes:
        factors: of the shaped plant.
        synthesis: of K = [K_r K_y] on the shaped plant, u_s = K_r r + K_y y.
        prefilter: static gain on r that makes the steady state that of the model, shape (q, q).
        controller: W_1 [K_r prefilter, K_y], u = K (r, y).
    """

    factors: CoprimeFactors
    synthesis: Synthesis
    prefilter: Array
    controller: Realisation


def two_degree_plant(
    factors: CoprimeFactors, model: Realisation, rho: float, select: Array
) -> GeneralizedPlant:
    """From (r, coprime disturbance, u_s) to (u_s, y, rho (select y - rho T_yr r); rho r, y) (eq. 3.40).

    Args:
        factors: of G_s with m inputs and p outputs.
        model: T_yr, stable, q inputs and outputs.
        rho: weight of the model, above zero.
        select: which outputs follow the model, shape (q, p).
    """
    a, b, c, d = factors.plant
    (p, m), q, n, n_r = d.shape, len(select), len(a), model.order
    root = np.real(np.asarray(sqrtm(factors.R)))
    into = -factors.H @ root
    return GeneralizedPlant(
        A=np.block([[a, np.zeros((n, n_r))], [np.zeros((n_r, n)), model.A]]),
        B1=np.block([[np.zeros((n, q)), into], [model.B, np.zeros((n_r, p))]]),
        B2=np.vstack((b, np.zeros((n_r, m)))),
        C1=np.block(
            [[np.zeros((m, n + n_r))], [c, np.zeros((p, n_r))], [rho * select @ c, -(rho**2) * model.C]]
        ),
        C2=np.block([[np.zeros((q, n + n_r))], [c, np.zeros((p, n_r))]]),
        D11=np.block(
            [[np.zeros((m, q + p))], [np.zeros((p, q)), root], [-(rho**2) * model.D, rho * select @ root]]
        ),
        D12=np.vstack((np.eye(m), d, rho * select @ d)),
        D21=np.block([[rho * np.eye(q), np.zeros((q, p))], [np.zeros((p, q)), root]]),
        D22=np.vstack((np.zeros((q, m)), d)),
        measurements=tuple(f"r_{i + 1}" for i in range(q)) + tuple(f"y_{i + 1}" for i in range(p)),
    )  # fmt: skip


def two_degree_loop_shaping(
    plant: Realisation,
    model: Realisation,
    w_1: Realisation | None = None,
    *,
    rho: float = 1.0,
    select: Array | None = None,
    gamma_margin: float = 1.05,
    fastest_pole: float = NYQUIST,
) -> TwoDegreeLoopShaping:
    """Feedback and feed-forward together: the selected outputs follow the model T_yr r.

    Args:
        plant: G, m inputs and p outputs; positive feedback.
        model: T_yr, stable, q inputs and outputs.
        w_1: m inputs and outputs; None is the identity.
        rho: weight of the model against robustness, above zero.
        select: shape (q, p); None takes all outputs.
        gamma_margin, fastest_pole: see `synthesise`.

    Raises:
        SynthesisRefused: hidden modes, or no certified controller.
        ValueError: rho not above zero, or sizes that do not belong together.
    """
    if not 0.0 < rho < math.inf:
        raise ValueError(f"rho {rho}; allowed: above 0")
    before, _ = with_identity(plant, w_1, None)
    factors = coprime_factors(series(plant, before))
    p = len(factors.plant.C)
    chosen = np.eye(p) if select is None else np.atleast_2d(np.asarray(select, dtype=np.float64))
    q = len(chosen)
    if chosen.shape != (q, p) or model.D.shape != (q, q):
        raise ValueError(f"select {chosen.shape} and model {model.D.shape}; allowed: {(q, p)} and {(q, q)}")
    problem = two_degree_plant(factors, model, rho, chosen)
    synthesis = synthesise(problem, gamma_margin=gamma_margin, fastest_pole=fastest_pole)
    inner = unnamed(synthesis.controller)
    # the measurement of the problem is rho r
    scaled = Realisation(inner.A, inner.B @ _scale(rho, q, p), inner.C, inner.D @ _scale(rho, q, p))
    wanted = response(model, np.zeros(1))[0].real
    prefilter = steady_state_prefilter(factors.plant, scaled, wanted, chosen)
    return TwoDegreeLoopShaping(
        factors, synthesis, prefilter, series(before, with_prefilter(scaled, prefilter))
    )


def _scale(rho: float, q: int, p: int) -> Array:
    return np.diag([rho] * q + [1.0] * p)


def with_prefilter(controller: Realisation, prefilter: Array) -> Realisation:
    """u = K (N r, y) from u = K (r, y)."""
    q, whole = len(prefilter), np.eye(controller.D.shape[1])
    whole[:q, :q] = prefilter
    return series(controller, gain(whole))


def steady_state_prefilter(
    plant: Realisation, controller: Realisation, wanted: Array, select: Array
) -> Array:
    """Gain N on r with which the selected outputs come to rest at `wanted` r; identity where none does.

    Args:
        plant: n states, m inputs, p outputs.
        controller: u = K (r, y), q references.
        wanted: shape (q, q).
        select: shape (q, p).

    Returns:
        shape (q, q).
    """
    q, (p, m) = len(select), plant.D.shape
    # all that is at rest: 0 = A x + B u, 0 = A_K x_K + B_K (r, y), with y and u from their output equations
    a = np.block(
        [
            [plant.A, np.zeros((plant.order, controller.order)), plant.B, np.zeros((plant.order, p))],
            [np.zeros((controller.order, plant.order)), controller.A, np.zeros((controller.order, m)),
             controller.B[:, q:]],
            [plant.C, np.zeros((p, controller.order)), plant.D, -np.eye(p)],
            [np.zeros((m, plant.order)), controller.C, -np.eye(m), controller.D[:, q:]],
        ]
    )  # fmt: skip
    drive = np.vstack(
        (np.zeros((plant.order, q)), -controller.B[:, :q], np.zeros((p, q)), -controller.D[:, :q])
    )
    at_rest = select @ np.linalg.solve(a, drive)[-m - p :][m:] if a.size else np.zeros((q, q))
    if np.linalg.cond(at_rest) > 1e8:
        return np.eye(q)
    return np.asarray(np.linalg.solve(at_rest, wanted), dtype=np.float64)
