"""The three generalised plants against the source's closed-loop matrices, and optima known by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from heli_control.certified import synthesise
from heli_control.generalized_plant import GeneralizedPlant, closed_response
from heli_control.mixed_sensitivity import gs_t, gs_t_two_degree, s_ks_t
from heli_control.realisation import Realisation, diagonal, first_order, gain, realisation, response

OMEGA = np.array([0.03, 0.4, 2.0, 11.0, 90.0])


def random_system(rng: np.random.Generator, n: int, inputs: int, outputs: int) -> Realisation:
    return realisation(
        rng.normal(size=(n, n)) - 2.0 * np.eye(n),
        rng.normal(size=(n, inputs)),
        rng.normal(size=(outputs, n)),
        0.3 * rng.normal(size=(outputs, inputs)),
    )


def lags(rng: np.random.Generator, count: int) -> Realisation:
    return diagonal(*(first_order(*rng.uniform(0.2, 2.0, 3)) for _ in range(count)))


def loops(g: Any, k: Any) -> tuple[Any, Any, Any, Any]:
    """S_e, T_e, S_u, T_u of u = K e."""
    s_e = np.linalg.inv(np.eye(g.shape[1]) + g @ k)
    s_u = np.linalg.inv(np.eye(g.shape[2]) + k @ g)
    return s_e, g @ k @ s_e, s_u, k @ g @ s_u


@pytest.fixture
def case() -> dict[str, Realisation]:
    rng = np.random.default_rng(5)
    sizes = {"w_u": 2, "w_v": 2, "w_y": 3, "w_d": 3, "w_e": 3, "w_f": 2, "w_r": 2}
    systems = {name: lags(rng, size) for name, size in sizes.items()}
    return systems | {
        "plant": random_system(rng, 4, 2, 3),
        "controller": random_system(rng, 3, 3, 2),
        "feedforward": random_system(rng, 2, 2, 2),
    }


def responses(case: dict[str, Realisation]) -> dict[str, Any]:
    return {name: response(system, OMEGA) for name, system in case.items()}


def test_s_ks_t_is_eq_3_23(case: dict[str, Realisation]) -> None:
    r = responses(case)
    s_e, t_e, _, _ = loops(r["plant"], r["controller"])
    problem = s_ks_t(case["plant"], case["w_e"], case["w_u"], case["w_y"])
    wanted = np.concatenate((r["w_e"] @ s_e, r["w_u"] @ r["controller"] @ s_e, r["w_y"] @ t_e), axis=1)
    np.testing.assert_allclose(closed_response(problem, case["controller"], OMEGA), wanted, atol=1e-10)


def test_gs_t_is_eq_3_25(case: dict[str, Realisation]) -> None:
    r = responses(case)
    s_e, t_e, s_u, t_u = loops(r["plant"], r["controller"])
    problem = gs_t(case["plant"], case["w_u"], case["w_y"], case["w_v"], case["w_d"])
    above = (-r["w_u"] @ t_u @ r["w_v"], -r["w_u"] @ r["controller"] @ s_e @ r["w_d"])
    below = (r["w_y"] @ r["plant"] @ s_u @ r["w_v"], -r["w_y"] @ t_e @ r["w_d"])
    wanted = np.concatenate([np.concatenate(row, axis=2) for row in (above, below)], axis=1)
    np.testing.assert_allclose(closed_response(problem, case["controller"], OMEGA), wanted, atol=1e-10)


def test_gs_t_with_two_degrees_is_eq_3_26(case: dict[str, Realisation]) -> None:
    r, followed = responses(case), (2, 0)
    chosen = np.eye(3)[list(followed)]
    problem = gs_t_two_degree(
        case["plant"], case["w_u"], case["w_y"], case["w_v"], case["w_d"], case["w_f"], case["w_r"], followed
    )
    forward, back = case["feedforward"], case["controller"]
    both = diagonal(forward, back)
    summed = Realisation(both.A, both.B, np.hstack((forward.C, back.C)), np.hstack((forward.D, back.D)))
    k_r, k_e, g = r["feedforward"], r["controller"], r["plant"]
    s_e, t_e, s_u, t_u = loops(g, k_e)
    to_y = (g @ s_u @ k_r @ r["w_r"], g @ s_u @ r["w_v"], -t_e @ r["w_d"])
    to_u = (s_u @ k_r @ r["w_r"], -t_u @ r["w_v"], -k_e @ s_e @ r["w_d"])
    distance = (r["w_r"] - chosen @ to_y[0], -chosen @ to_y[1], -chosen @ to_y[2])
    rows = (
        [r["w_u"] @ one for one in to_u],
        [r["w_y"] @ one for one in to_y],
        [r["w_f"] @ one for one in distance],
    )
    wanted = np.concatenate([np.concatenate(row, axis=2) for row in rows], axis=1)
    np.testing.assert_allclose(closed_response(problem, summed, OMEGA), wanted, atol=1e-10)


def test_s_ks_t_of_a_gain_by_hand() -> None:
    # minimise (a + b k^2) / (1 + g k)^2 with a = w_e^2, b = w_u^2 + w_y^2 g^2: a b / (b + a g^2)
    g, w_e, w_u, w_y = 2.0, 1.0, 0.5, 0.3
    a, b = w_e**2, w_u**2 + (w_y * g) ** 2
    problem = s_ks_t(gain(g), gain(w_e), gain(w_u), gain(w_y))
    found = synthesise(problem, gamma_margin=1.0001)
    assert found.optimal_gamma == pytest.approx(np.sqrt(a * b / (b + a * g**2)), rel=1e-4)
    assert found.controller.D[0, 0] == pytest.approx(a * g / b, rel=0.05)


def test_gs_t_of_a_gain_by_search() -> None:
    g, w_u, w_y, w_v, w_d = 3.0, 0.7, 1.0, 1.0, 0.2

    def norm(k: float) -> float:
        s = 1.0 / (1.0 + g * k)
        return float(
            np.linalg.norm(
                s * np.array([[-w_u * k * g * w_v, -w_u * k * w_d], [w_y * g * w_v, -w_y * g * k * w_d]]), 2
            )
        )

    best = minimize_scalar(norm, bounds=(0.0, 20.0), method="bounded", options={"xatol": 1e-9})
    found = synthesise(gs_t(gain(g), gain(w_u), gain(w_y), gain(w_v), gain(w_d)))
    assert found.optimal_gamma == pytest.approx(best.fun, rel=1e-4)


def test_integrator_violates_a5_of_s_ks_t_and_not_of_gs_t() -> None:
    plant = realisation([[0.0]], [[1.0]], [[1.0]], [[0.0]])
    one = gain(1.0)
    with pytest.raises(ValueError, match=r"A5 \(B1, C2\)"):
        synthesise(s_ks_t(plant, one, one, one))
    # [1/(s+k)] of u = -k y with all weights one: the optimum is certified whatever it is
    found = synthesise(gs_t(plant, one, one, one, one))
    assert found.certified_norm <= 1.001 * found.gamma


@pytest.mark.parametrize("wrong", ["w_u", "w_y", "w_v", "w_d"])
def test_weight_of_another_size_is_refused(case: dict[str, Realisation], wrong: str) -> None:
    weights = {name: case[name] for name in ("w_u", "w_y", "w_v", "w_d")}
    weights[wrong] = gain(np.eye(5))
    with pytest.raises(ValueError, match=r"W_. of \(5, 5\); allowed"):
        gs_t(case["plant"], **weights)


def test_names_and_sizes(case: dict[str, Realisation]) -> None:
    problem: GeneralizedPlant = gs_t(case["plant"], case["w_u"], case["w_y"], case["w_v"], case["w_d"])
    assert problem.sizes == (5, 2, 5, 3)
    assert problem.controls == ("u_1", "u_2")
