"""Robustness tests: by hand, against responses, the coprime norm, and perturbations of the size tolerated."""

import math

import numpy as np
import pytest

from heli_control.loop_shaping import loop_shaping
from heli_control.realisation import Realisation, first_order, gain, realisation, response
from heli_control.uncertainty import (
    COPRIME,
    FEEDBACK,
    OPERATORS,
    closed_operators,
    robustness_tests,
    singular_values,
)

OMEGA = np.geomspace(1e-2, 1e2, 60)


def plant_of(seed: int) -> Realisation:
    rng = np.random.default_rng(seed)
    return realisation(*(rng.standard_normal(size) for size in ((4, 4), (4, 2), (3, 4), (3, 2))))


def test_integrator_with_a_gain_by_hand() -> None:
    # G = 1/s, K = -2: S = s/(s + 2), T = 2/(s + 2), S G = 1/(s + 2), K S = -2 s/(s + 2)
    tests = {test.operator: test for test in robustness_tests(first_order(0.0, 1.0, 0.0), gain([[-2.0]]))}
    assert tuple(tests) == tuple(OPERATORS)
    expected = {"K S_e": 2.0, "S_e G": 0.5, "T_e": 1.0, "T_u": 1.0, "S_e": 1.0, "S_u": 1.0}
    for name, value in expected.items():
        assert tests[name].norm == pytest.approx(value, rel=1e-5)
        assert tests[name].tolerated == pytest.approx(1.0 / value, rel=1e-5)
    assert tests["S_e G"].frequency == 0.0
    assert math.isinf(tests["K S_e"].frequency)
    # M^-1 = (s + 1)/s: [K; I] S M^-1 = [-2; 1] (s + 1)/(s + 2), largest at infinity
    assert tests[COPRIME].norm == pytest.approx(math.sqrt(5.0), rel=1e-5)
    assert tests["S_u"].perturbation == "divisive at the input"


def test_operators_are_what_their_names_say() -> None:
    plant = plant_of(1)
    controller = loop_shaping(plant).controller
    g, k = response(plant, OMEGA), response(controller, OMEGA)
    s_e, s_u = np.linalg.inv(np.eye(3) - g @ k), np.linalg.inv(np.eye(2) - k @ g)
    made = {name: response(system, OMEGA) for name, system in closed_operators(plant, controller).items()}
    expected = {
        "K S_e": k @ s_e, FEEDBACK: s_e @ g, "S_e": s_e, "S_u": s_u, "T_e": s_e @ g @ k, "T_u": k @ g @ s_u,
    }  # fmt: skip
    for name, value in expected.items():
        np.testing.assert_allclose(made[name], value, rtol=1e-7, atol=1e-9)


def test_coprime_norm_is_that_of_the_design() -> None:
    plant = plant_of(2)
    design = loop_shaping(plant)
    test = robustness_tests(plant, design.controller)[-1]
    assert test.norm == pytest.approx(design.certificate.norm, rel=1e-4)
    assert design.factors.gamma_min < test.norm <= design.gamma


def test_a_perturbation_just_larger_destabilises_and_a_smaller_one_does_not() -> None:
    plant = plant_of(3)
    controller = loop_shaping(plant).controller
    test = next(one for one in robustness_tests(plant, controller) if one.operator == "T_u")
    operator = closed_operators(plant, controller)["T_u"]
    value = response(operator, np.array([test.frequency]))[0]
    left, sizes, right = np.linalg.svd(value)
    # the worst Delta at this frequency makes I - Delta T_u singular exactly at the size tolerated
    worst = np.outer(right[0].conj(), left[:, 0].conj()) / sizes[0]
    assert np.linalg.norm(worst, 2) == pytest.approx(test.tolerated, rel=1e-4)
    assert np.linalg.svd(np.eye(2) - worst @ value, compute_uv=False)[-1] < 1e-9
    assert np.linalg.svd(np.eye(2) - 0.5 * worst @ value, compute_uv=False)[-1] > 0.1


def test_an_unstable_loop_tolerates_nothing() -> None:
    tests = robustness_tests(first_order(0.0, 1.0, -1.0), gain([[-0.5]]))
    assert all(math.isinf(test.norm) and test.tolerated == 0.0 for test in tests)


def test_curves() -> None:
    curves = singular_values(plant_of(4), OMEGA)
    assert curves.shape == (60, 2)
    assert (curves[:, 0] >= curves[:, 1]).all()
