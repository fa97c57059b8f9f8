"""Controllability, observability, zeros, cancellations: by hand, against the library, as properties."""

from pathlib import Path

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from heli_common.model_file import ModelFile
from heli_control.realisation import Realisation, diagonal, first_order, gain, realisation, series, unnamed
from heli_control.system_properties import (
    cancellations,
    is_controllable,
    is_observable,
    modes,
    transmission_zeros,
)

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")


def apart(one: np.ndarray, two: np.ndarray) -> float:
    """Largest distance of two sets of numbers, paired as well as possible."""
    assert len(one) == len(two)
    distance = np.abs(np.asarray(one)[:, None] - np.asarray(two)[None, :])
    rows, columns = linear_sum_assignment(distance)
    return float(distance[rows, columns].max(initial=0.0))


def random_system(rng: np.random.Generator, n: int, m: int, p: int, direct: bool) -> Realisation:
    d = rng.standard_normal((p, m)) if direct else np.zeros((p, m))
    return realisation(*(rng.standard_normal(size) for size in ((n, n), (n, m), (p, n))), d)


def test_hidden_modes_by_hand() -> None:
    system = realisation(np.diag([-1.0, -2.0]), [[1.0], [0.0]], [[1.0, 3.0]], [[0.0]])
    slow, fast = modes(system)
    assert slow.pole == -1.0
    assert fast.controllability == pytest.approx(0.0, abs=1e-12)
    assert fast.observability == pytest.approx(
        np.linalg.svd([[-1.0, 0.0], [0.0, 0.0], [1.0, 3.0]], compute_uv=False)[-1]
    )
    assert slow.controllability > 0.1
    assert not is_controllable(system)
    assert is_observable(system)


def test_the_distance_is_that_of_the_nearest_system_without_the_mode() -> None:
    rng = np.random.default_rng(1)
    system = random_system(rng, 4, 2, 2, False)
    mode = modes(system)[0]
    pencil = np.hstack((mode.pole * np.eye(4) - system.A, system.B))
    left, sizes, right = np.linalg.svd(pencil)
    change = sizes[-1] * np.outer(left[:, -1], right[3])
    assert np.linalg.norm(change, 2) == pytest.approx(mode.controllability)
    assert np.linalg.matrix_rank(pencil - change, tol=1e-9) == 3


def test_zeros_by_hand() -> None:
    np.testing.assert_allclose(transmission_zeros(first_order(2.0, 6.0, 1.0)), [-3.0], atol=1e-12)
    assert transmission_zeros(first_order(0.0, 6.0, 1.0)).size == 0
    assert transmission_zeros(gain([[1.0]])).size == 0
    # two lags seen by two outputs have none; by one output, 1/(s+1) + 1/(s+2), one in the middle
    two = diagonal(first_order(0.0, 1.0, 1.0), first_order(0.0, 1.0, 2.0))
    assert transmission_zeros(two).size == 0
    parallel = Realisation(two.A, two.B @ np.ones((2, 1)), np.ones((1, 2)) @ two.C, np.zeros((1, 1)))
    np.testing.assert_allclose(transmission_zeros(parallel), [-1.5], atol=1e-12)


@settings(deadline=None, max_examples=60, derandomize=True)
@given(st.integers(0, 10**6), st.integers(3, 7), st.integers(1, 3), st.integers(1, 3), st.booleans())
def test_zeros_are_those_of_the_library(seed: int, n: int, m: int, p: int, direct: bool) -> None:
    # the library's routine fails for fewer states than signals
    system = random_system(np.random.default_rng(seed), n, m, p, direct)
    library = control.zeros(control.ss(*system))
    zeros = transmission_zeros(system)
    size = 1.0 + np.abs(library).max(initial=0.0)
    assert apart(zeros, library) < 1e-6 * size


@settings(deadline=None, max_examples=30, derandomize=True)
@given(st.integers(0, 10**6), st.integers(2, 6), st.integers(1, 3))
def test_zeros_of_a_tall_system_come_back_when_put_there(seed: int, n: int, p: int) -> None:
    # every output through one filter with a zero: the zero is common to all of them
    rng = np.random.default_rng(seed)
    zero = rng.uniform(-3.0, 3.0)
    system = series(random_system(rng, n, 1, p + 1, True), first_order(1.0, -zero, 5.0))
    assert np.abs(transmission_zeros(system) - zero).min() < 1e-6 * (1.0 + abs(zero))


def test_helicopter_is_controllable_and_its_zeros_are_the_librarys() -> None:
    for block in (MODEL.horizontal, MODEL.vertical):
        system = unnamed(block)
        assert is_controllable(system)
        assert is_observable(system)
        library = control.zeros(control.ss(*system))
        assert apart(transmission_zeros(system), library) < 1e-6 * (1.0 + np.abs(library).max(initial=0.0))


def test_a_controller_that_inverts_cancels_and_one_that_does_not_is_told_apart() -> None:
    plant = series(first_order(0.0, 1.0, 0.2), first_order(0.0, 10.0, 10.0))
    inverting = series(first_order(1.0, 0.2, 0.0), first_order(0.0, 30.0, 30.0))
    (one,) = cancellations(inverting, plant, slower_than=1.0)
    assert one.pole == pytest.approx(-0.2)
    assert one.zero == pytest.approx(-0.2)
    assert one.relative < 1e-9
    assert one.hidden < 1e-9
    other = series(first_order(1.0, 2.0, 0.0), first_order(0.0, 30.0, 30.0))
    (one,) = cancellations(other, plant, slower_than=1.0)
    assert one.distance == pytest.approx(1.8)
    assert one.hidden > 0.5
    (one,) = cancellations(gain([[2.0]]), plant, slower_than=1.0)
    assert one.distance == float("inf")
    assert one.hidden > 0.5


def test_a_zero_in_another_direction_does_not_cancel() -> None:
    plant = diagonal(first_order(0.0, 1.0, 0.2), first_order(0.0, 1.0, 5.0))
    elsewhere = diagonal(gain([[1.0]]), first_order(1.0, 0.2, 1.0))
    slow = cancellations(elsewhere, plant, slower_than=1.0)[0]
    assert slow.distance < 1e-9
    assert slow.hidden > 0.5
    there = diagonal(first_order(1.0, 0.2, 1.0), gain([[1.0]]))
    assert cancellations(there, plant, slower_than=1.0)[0].hidden < 1e-9
