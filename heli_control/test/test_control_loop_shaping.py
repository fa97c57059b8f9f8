"""Loop shaping: textbook example, closed forms, general synthesis as twin, observer, two degrees."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.model_file import ModelFile
from heli_control.certificate import certify
from heli_control.certified import SynthesisRefused
from heli_control.generalized_plant import closed_response
from heli_control.hinf_norm import hinf_norm, natural_frequencies
from heli_control.loop_shaping import (
    central,
    coprime_factors,
    four_blocks,
    loop_shaping,
    observer_form,
)
from heli_control.loop_shaping_two_degree import two_degree_loop_shaping, two_degree_plant
from heli_control.lq_axis import SCALES
from heli_control.realisation import (
    Realisation,
    diagonal,
    first_order,
    realisation,
    response,
    series,
    unnamed,
)
from heli_control.riccati_synthesis import optimal_gamma

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")
# Skogestad and Postlethwaite, example 9.3: 200 / ((10 s + 1)(0.05 s + 1)^2), W_1 = (s + 2) / s
TEXTBOOK = series(
    first_order(0.0, 20.0, 0.1), series(first_order(0.0, 20.0, 20.0), first_order(0.0, 20.0, 20.0))
)
PI = first_order(1.0, 2.0, 0.0)


def horizontal() -> Realisation:
    h = MODEL.horizontal
    u, y = (np.array([SCALES[name] for name in names]) for names in (h.inputs, h.outputs))
    return Realisation(h.A, h.B * u, h.C / y[:, None], h.D)


LOW_PASS = diagonal(first_order(0.0, 20.0, 20.0), first_order(0.0, 20.0, 20.0))


def test_textbook_example() -> None:
    design = loop_shaping(TEXTBOOK, PI)
    assert design.factors.gamma_min == pytest.approx(2.34, abs=0.005)
    assert design.gamma == pytest.approx(1.1 * design.factors.gamma_min)
    assert design.factors.gamma_min < design.certificate.norm <= design.gamma
    assert design.controller.order == 5


@pytest.mark.parametrize("pole", [-2.0, 0.0, 3.0])
def test_first_order_plant_by_hand(pole: float) -> None:
    # 2 p X - X^2 + 1 = 0, Z = X
    x = pole + math.sqrt(pole**2 + 1.0)
    factors = coprime_factors(first_order(0.0, 1.0, -pole))
    assert factors.X[0, 0] * factors.Z[0, 0] == pytest.approx(x * x)
    assert factors.gamma_min == pytest.approx(math.sqrt(1.0 + x * x))


@settings(deadline=None, max_examples=30, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 6), st.booleans())
def test_gamma_min_is_the_optimum_of_the_general_synthesis(seed: int, n: int, proper: bool) -> None:
    r = np.random.default_rng(seed).standard_normal
    factors = coprime_factors(realisation(r((n, n)), r((n, 2)), r((3, n)), proper * r((3, 2))))
    problem = four_blocks(factors.plant)
    assert optimal_gamma(problem) == pytest.approx(factors.gamma_min, rel=1e-4)
    gamma = 1.1 * factors.gamma_min
    certificate = certify(problem, central(factors, gamma), gamma)
    assert certificate.fault == ""
    assert certificate.norm >= factors.gamma_min * (1.0 - 1e-6)


def test_factors_are_normalised_and_make_the_plant() -> None:
    r = np.random.default_rng(4).standard_normal
    plant = realisation(r((4, 4)), r((4, 2)), r((3, 4)), r((3, 2)))
    f = coprime_factors(plant)
    a, b, c, d = f.plant
    root = np.linalg.inv(np.linalg.cholesky(f.R)).astype(float)  # any root of R^-1 will do
    filtered = a + f.H @ c
    assert np.linalg.eigvals(filtered).real.max() < 0.0
    omega = np.array([0.0, 0.3, 2.0, 50.0, np.inf])
    n = response(Realisation(filtered, b + f.H @ d, root @ c, root @ d), omega)
    m = response(Realisation(filtered, f.H, root @ c, root), omega)
    np.testing.assert_allclose(np.linalg.solve(m, n), response(plant, omega), atol=1e-9)
    both = np.concatenate((n, m), axis=2)
    np.testing.assert_allclose(
        both @ both.conj().transpose(0, 2, 1), np.tile(np.eye(3), (5, 1, 1)), atol=1e-9
    )


def test_observer_is_the_central_controller() -> None:
    design = loop_shaping(horizontal(), LOW_PASS)
    assert design.observer is not None
    omega = np.asarray(np.geomspace(1e-2, 1e3, 30), dtype=np.float64)
    np.testing.assert_allclose(
        np.abs(response(design.observer.controller, omega) - response(design.inner, omega)), 0.0, atol=1e-9
    )
    # the observer does not know the feedback: its error decays with A + H C whatever u_s is
    assert np.linalg.eigvals(design.observer.A + design.observer.H @ design.observer.C).real.max() < 0.0
    with pytest.raises(ValueError, match="direct feedthrough"):
        observer_form(coprime_factors(first_order(1.0, 0.0, 1.0)), 2.0)


def test_helicopter_loop_shaping_is_certified() -> None:
    design = loop_shaping(horizontal(), LOW_PASS)
    assert 1.0 < design.factors.gamma_min < 4.0
    assert design.certificate.norm <= design.gamma * 1.001
    assert design.certificate.poles.real.max() < 0.0
    assert design.controller.D.shape == (2, 6)


def test_two_degrees_of_freedom_follow_the_model() -> None:
    select = np.zeros((2, 6))
    select[0, 2] = select[1, 3] = 1.0
    model = diagonal(first_order(0.0, 3.5, 5.0), first_order(0.0, 3.5, 5.0))
    design = two_degree_loop_shaping(horizontal(), model, LOW_PASS, select=select)
    assert design.synthesis.certified_norm <= design.synthesis.gamma * 1.001
    # the loop as it flies: y = G u, u = K (r, y)
    omega = np.array([0.0, 0.1])
    plant, k = response(horizontal(), omega), response(design.controller, omega)
    reply = select @ np.linalg.solve(np.eye(6) - plant @ k[:, :, 2:], plant @ k[:, :, :2])
    np.testing.assert_allclose(reply[0], 0.7 * np.eye(2), atol=1e-8)
    np.testing.assert_allclose(reply[1], 0.7 * np.eye(2), atol=0.1)


def test_two_degree_problem_holds_the_rows_of_eq_3_40() -> None:
    factors, rho = coprime_factors(series(TEXTBOOK, PI)), 2.0
    model = first_order(0.0, 5.0, 5.0)
    problem = two_degree_plant(factors, model, rho, np.eye(1))
    k = Realisation(np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((1, 0)), np.array([[0.3, -0.1]]))
    omega = np.array([0.2, 3.0])
    rows = closed_response(problem, k, omega)
    g, t = response(factors.plant, omega)[:, 0, 0], response(model, omega)[:, 0, 0]
    s = 1.0 / (1.0 + 0.1 * g)
    np.testing.assert_allclose(rows[:, 0, 0], rho * s * 0.3, atol=1e-9)
    np.testing.assert_allclose(rows[:, 1, 0], rho * s * g * 0.3, atol=1e-9)
    np.testing.assert_allclose(rows[:, 2, 0], rho**2 * (s * g * 0.3 - t), atol=1e-9)
    # M^-1 of normalised factors: |M^-1|^2 = 1 + |G|^2
    np.testing.assert_allclose(np.abs(rows[:, 1, 1]), np.abs(s) * np.sqrt(1.0 + np.abs(g) ** 2), atol=1e-9)
    np.testing.assert_allclose(rows[:, 2, 1], rho * rows[:, 1, 1], atol=1e-9)


def test_certificate_is_of_the_loop_that_flies() -> None:
    design = loop_shaping(horizontal(), LOW_PASS)
    plant = horizontal()
    loop = four_blocks(series(plant, LOW_PASS))
    omega = natural_frequencies(plant)[2:]
    levels = np.linalg.svd(closed_response(loop, design.inner, omega), compute_uv=False)[:, 0]
    assert levels.max() <= design.certificate.norm * (1.0 + 1e-6)
    closed = series(plant, design.controller)
    k = Realisation(closed.A + closed.B @ closed.C, closed.B, closed.C, closed.D)
    assert math.isfinite(hinf_norm(k).value)


def test_hidden_modes_and_bad_arguments_are_refused() -> None:
    hidden = diagonal(first_order(0.0, 1.0, 1.0), first_order(0.0, 0.0, -1.0))
    with pytest.raises(SynthesisRefused, match="A1: the shaped plant"):
        loop_shaping(hidden)
    with pytest.raises(ValueError, match=r"factor 1\.0; allowed: above 1"):
        loop_shaping(TEXTBOOK, factor=1.0)
    with pytest.raises(ValueError, match=r"w_1 of \(2, 2\); allowed: \(1, 1\)"):
        loop_shaping(TEXTBOOK, LOW_PASS)
    with pytest.raises(ValueError, match=r"rho 0\.0; allowed: above 0"):
        two_degree_loop_shaping(TEXTBOOK, PI, rho=0.0)
    with pytest.raises(ValueError, match="select"):
        two_degree_loop_shaping(TEXTBOOK, LOW_PASS)


def test_names_reach_the_controller() -> None:
    model = first_order(0.0, 5.0, 5.0)
    synthesis = two_degree_loop_shaping(TEXTBOOK, model, PI).synthesis
    assert synthesis.controller.inputs == ("r_1", "y_1")
    assert unnamed(synthesis.controller).order == 5
