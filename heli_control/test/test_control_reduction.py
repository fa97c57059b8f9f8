"""Reduction: by hand, the bound as a property, both ways of cutting, lasting modes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_control.realisation import (
    Realisation,
    diagonal,
    first_order,
    gain,
    realisation,
    response,
    series,
)
from heli_control.reduction import balancing, parts, reduced, reduced_within


def random_system(rng: np.random.Generator, n: int, lasting: int) -> Realisation:
    a = rng.standard_normal((n, n))
    a -= (np.linalg.eigvals(a).real.max() + rng.uniform(0.05, 1.0)) * np.eye(n)
    whole = np.zeros((n + lasting, n + lasting))
    whole[:n, :n] = a
    whole[n:, n:] = np.diag(rng.choice([0.0, 0.5, 2.0], lasting))
    whole[:n, n:] = rng.standard_normal((n, lasting))
    size = n + lasting
    turn = np.linalg.qr(rng.standard_normal((size, size)))[0]
    return realisation(
        turn @ whole @ turn.T, *(rng.standard_normal(shape) for shape in ((size, 2), (3, size), (3, 2)))
    )


def test_hankel_singular_values_by_hand() -> None:
    # k/(s + a) has k/(2a); two lags apart keep theirs
    two = diagonal(first_order(0.0, 6.0, 1.0), first_order(0.0, 1.0, 5.0))
    np.testing.assert_allclose(balancing(two).hankel, [3.0, 0.1], rtol=1e-12)
    cut = reduced(two, 1)
    assert cut.bound == pytest.approx(0.2)
    assert cut.error == pytest.approx(0.2, rel=1e-5)  # a first-order lag of gain 1/5 is what is missing
    assert cut.norm == pytest.approx(6.0, rel=1e-5)
    assert cut.system.A[0, 0] == pytest.approx(-1.0)


@settings(deadline=None, max_examples=60, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 8), st.integers(0, 2), st.booleans())
def test_measured_error_is_within_the_bound(seed: int, n: int, lasting: int, at_rest: bool) -> None:
    rng = np.random.default_rng(seed)
    system = random_system(rng, n, lasting)
    for order in range(lasting, n + lasting + 1):
        cut = reduced(system, order, at_rest=at_rest)
        assert cut.kept == lasting
        assert cut.system.order <= order
        assert cut.error <= cut.bound * (1.0 + 1e-5) + 1e-8 * cut.norm
        # the difference of the whole responses is what was measured, lasting modes or not
        omega = np.geomspace(0.01, 100.0, 40)
        apart = response(system, omega) - response(cut.system, omega)
        size = 1.0 + np.abs(response(system, omega)).max()
        assert np.linalg.svd(apart, compute_uv=False).max() <= cut.error * (1.0 + 1e-5) + 1e-7 * size


def test_lowest_order_within_a_tolerance() -> None:
    system = random_system(np.random.default_rng(4), 8, 1)
    cut = reduced_within(system, 0.05)
    assert cut.bound <= 0.05 * cut.norm
    assert 1 < cut.system.order < 9
    assert reduced(system, cut.system.order - 1).bound > 0.05 * cut.norm
    assert reduced_within(system, 1e-12).system.order == 9


def test_what_is_kept_at_rest_and_at_infinity() -> None:
    system = random_system(np.random.default_rng(5), 6, 0)
    zero, infinity = np.array([0.0]), np.array([np.inf])
    np.testing.assert_allclose(
        response(reduced(system, 3, at_rest=True).system, zero), response(system, zero), atol=1e-9
    )
    np.testing.assert_allclose(
        response(reduced(system, 3).system, infinity), response(system, infinity), atol=1e-9
    )


def test_states_that_nobody_sees_go_without_cost() -> None:
    hidden = series(first_order(0.0, 2.0, 1.0), first_order(1.0, 3.0, 3.0))  # the first is the gain 1
    cut = reduced_within(hidden, 1e-6)
    assert cut.system.order == 1
    assert cut.error < 1e-6


def test_integrators_are_kept_and_gains_need_no_states() -> None:
    both = series(first_order(0.0, 1.0, 0.0), first_order(0.0, 4.0, 4.0))
    decaying, lasting = parts(both)
    assert (decaying.order, lasting.order) == (1, 1)
    cut = reduced(both, 1)
    assert cut.system.order == 1
    assert cut.system.A[0, 0] == pytest.approx(0.0, abs=1e-12)
    assert reduced_within(gain([[1.0]]), 0.1).system.order == 0
    only = reduced_within(first_order(0.0, 1.0, 0.0), 0.1)
    assert (only.system.order, only.kept, only.error) == (1, 1, 0.0)


def test_bad_arguments_are_refused() -> None:
    integrator = first_order(0.0, 1.0, 0.0)
    with pytest.raises(ValueError, match="order 0; allowed: at least the 1 modes"):
        reduced(integrator, 0)
    with pytest.raises(ValueError, match=r"tolerance 0\.0; allowed"):
        reduced_within(integrator, 0.0)
