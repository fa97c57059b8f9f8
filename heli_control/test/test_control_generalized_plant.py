"""Generalised plant: assumptions named when violated, scalings that keep the loop, closed loop two ways."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from heli_common.linear_model import StateSpace
from heli_control.assumptions import check_assumptions, feedthrough_floor, violations
from heli_control.generalized_plant import (
    GeneralizedPlant,
    closed_response,
    from_whole,
    lower_lft,
    normalised,
    partitioned,
    with_balanced_states,
)
from heli_control.realisation import Realisation, gain, response


def made(*matrices: Any) -> GeneralizedPlant:
    """From lists of rows, in the order A, B1, B2, C1, C2, D11, D12, D21, D22."""
    rows: list[Any] = [np.array(matrix) for matrix in matrices]
    return GeneralizedPlant(*rows)


def changed(plant: GeneralizedPlant, **parts: Any) -> GeneralizedPlant:
    return replace(plant, **parts)


def random_plant(seed: int, n: int = 4) -> GeneralizedPlant:
    r = np.random.default_rng(seed).standard_normal
    return GeneralizedPlant(
        r((n, n)), r((n, 3)), r((n, 2)), r((3, n)), r((2, n)), r((3, 3)), r((3, 2)), r((2, 3)), r((2, 2))
    )


def random_controller(seed: int) -> Realisation:
    r = np.random.default_rng(seed).standard_normal
    return Realisation(r((3, 3)), r((3, 2)), r((2, 3)), 0.3 * r((2, 2)))


def tracking(pole: float) -> GeneralizedPlant:
    """S/KS on 1/(s - pole): w the reference, z = (y, 0.5 u)."""
    return made(
        [[pole]], [[0.0]], [[1.0]], [[1.0], [0.0]], [[1.0]],
        [[1.0], [0.0]], [[0.0], [0.5]], [[1.0]], [[0.0]],
    )  # fmt: skip


def names(plant: GeneralizedPlant) -> list[str]:
    return [one.name for one in violations(plant)]


def test_each_assumption_is_named() -> None:
    plant = tracking(-1.0)
    assert names(plant) == []
    assert names(changed(plant, A=[[1.0]], B2=[[0.0]])) == ["A1 (A, B2)"]
    assert names(changed(plant, A=[[1.0]], C2=[[0.0]])) == ["A1 (C2, A)"]
    assert "A3 (D12)" in names(changed(plant, D12=[[0.0], [0.0]]))
    assert "A4 (D21)" in names(changed(plant, D21=[[0.0]], B1=[[1.0]]))
    # S is 1 at high frequencies whatever the controller
    assert [one.name for one in violations(plant, 0.99)] == ["A2 (D11)"]
    assert violations(plant, 1.01) == ()


def test_an_integrator_violates_a5_and_a_slow_pole_nearly() -> None:
    # D21 w hides the plant's pole from w: [A - jw, 0; C2, 1] loses rank at w = 0
    assert names(tracking(0.0)) == ["A5 (B1, C2)"]
    near = {one.name: one for one in check_assumptions(tracking(-0.01))}["A5 (B1, C2)"]
    assert near.holds
    # smallest singular value of [-0.01, 0; 1, 1]: product 0.01, sum of squares 2.0001
    smallest = math.sqrt(0.5 * (2.0001 - math.sqrt(2.0001**2 - 4.0 * 1e-4)))
    assert near.distance == pytest.approx(smallest, rel=1e-6)
    assert near.frequency == pytest.approx(0.0, abs=1e-9)


def test_zero_on_the_axis_away_from_all_poles_is_found() -> None:
    # P12 = (s^2 + 9) / ((s + 1)(s + 2)): zeros at +-3j
    a, b = [[-3.0, -2.0], [1.0, 0.0]], [[1.0], [0.0]]
    plant = made(a, b, b, [[-3.0, 7.0]], [[0.0, 1.0]], [[0.0]], [[1.0]], [[1.0]], [[0.0]])
    broken = violations(plant)
    assert [one.name for one in broken] == ["A5 (B2, C1)"]
    assert broken[0].frequency == pytest.approx(3.0, rel=1e-6)


def test_floor_of_gamma_is_what_no_static_controller_changes() -> None:
    plant = random_plant(3)
    assert plant.D12.shape == (3, 2)
    floor = feedthrough_floor(plant)
    rng = np.random.default_rng(0)
    for _ in range(200):
        k = rng.standard_normal((2, 2)) * 10.0 ** rng.uniform(-2.0, 1.0)
        assert np.linalg.norm(plant.D11 + plant.D12 @ k @ plant.D21, 2) >= floor * (1.0 - 1e-12)
    single = changed(plant, D11=np.zeros((3, 3)))
    assert feedthrough_floor(single) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_closed_loop_is_the_same_by_states_and_by_responses(seed: int) -> None:
    plant, controller = random_plant(seed), random_controller(seed + 50)
    omega = np.array([0.0, 0.1, 1.0, 30.0, np.inf])
    joined = response(lower_lft(plant, controller), omega)
    np.testing.assert_allclose(joined, closed_response(plant, controller, omega), rtol=1e-8, atol=1e-8)
    turned = closed_response(with_balanced_states(plant), controller, omega)
    np.testing.assert_allclose(joined, turned, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_normalised_plant_gives_the_same_singular_values(seed: int) -> None:
    plant, inner = random_plant(seed), random_controller(seed + 90)
    scaled = normalised(plant)
    np.testing.assert_allclose(scaled.plant.D12, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], atol=1e-12)
    np.testing.assert_allclose(plant.D12 @ scaled.control, np.linalg.svd(plant.D12)[0][:, :2], atol=1e-12)
    omega = np.array([0.0, 0.5, 5.0, np.inf])
    one = np.linalg.svd(closed_response(scaled.plant, inner, omega), compute_uv=False)
    two = np.linalg.svd(closed_response(plant, scaled.controller(inner), omega), compute_uv=False)
    np.testing.assert_allclose(one, two, rtol=1e-8, atol=1e-8)


def test_partition_by_name_and_bad_shapes() -> None:
    r = np.random.default_rng(0).standard_normal
    system = StateSpace(("x",), ("u", "w"), ("y", "z"), r((1, 1)), r((1, 2)), r((2, 1)), r((2, 2)))
    plant = partitioned(system, ("u",), ("y",))
    assert (plant.controls, plant.measurements, plant.sizes) == (("u",), ("y",), (1, 1, 1, 1))
    assert plant.D12[0, 0] == system.D[1, 0]
    assert plant.B1[0, 0] == system.B[0, 1]
    again = from_whole(plant.whole, ("u",), ("y",))
    np.testing.assert_array_equal(again.D21, plant.D21)
    with pytest.raises(ValueError, match="input 'v' is none of"):
        partitioned(system, ("v",), ("y",))
    with pytest.raises(ValueError, match=r"B2 has shape \(1, 2\); allowed: \(1, 1\)"):
        changed(plant, B2=np.ones((1, 2)))
    with pytest.raises(ValueError, match="2 controls; allowed: 1"):
        changed(plant, controls=("a", "b"))
    with pytest.raises(ValueError, match="C1 holds a number that is not finite"):
        changed(plant, C1=[[math.inf]])
    with pytest.raises(ValueError, match="not well posed"):
        lower_lft(
            changed(plant, D22=[[1.0]]),
            gain(1.0),
        )
    with pytest.raises(ValueError, match="D12 of shape"):
        normalised(changed(plant, D12=[[0.0]]))
