"""H-infinity norm: by hand, against a dense grid, at sharp resonances, and of unstable systems."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_control.hinf_norm import grid_norm, hinf_norm
from heli_control.pole_region import fastest, without_fast_modes
from heli_control.realisation import (
    Realisation,
    balanced,
    diagonal,
    first_order,
    gain,
    rational,
    realisation,
    response,
    series,
)


def random_stable(rng: np.random.Generator, n: int, m: int, p: int) -> Realisation:
    a = rng.standard_normal((n, n))
    a -= (np.linalg.eigvals(a).real.max() + rng.uniform(0.01, 1.0)) * np.eye(n)
    sizes = ((n, m), (p, n), (p, m))
    return realisation(a, *(rng.standard_normal(size) for size in sizes))


def test_by_hand() -> None:
    lag = hinf_norm(first_order(0.0, 6.0, 2.0))
    assert lag.value == pytest.approx(3.0, rel=3e-6)
    assert lag.frequency == 0.0
    lead = hinf_norm(first_order(3.0, 1.0, 1.0))
    assert lead.value == pytest.approx(3.0, rel=3e-6)
    assert math.isinf(lead.frequency)
    assert hinf_norm(gain([[3.0, 4.0]])).value == pytest.approx(5.0, rel=3e-6)
    assert hinf_norm(gain(np.zeros((2, 2)))).value == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("damping", [0.5, 1e-2, 1e-5])
def test_resonance_has_its_closed_form(damping: float) -> None:
    peak = hinf_norm(rational((0.0, 0.0, 49.0), (1.0, 14.0 * damping, 49.0)))
    assert peak.value == pytest.approx(1.0 / (2.0 * damping * math.sqrt(1.0 - damping**2)), rel=1e-5)
    assert peak.frequency == pytest.approx(7.0 * math.sqrt(1.0 - 2.0 * damping**2), rel=1e-3)


def test_all_pass_is_flat() -> None:
    flat = series(first_order(1.0, -3.0, 3.0), first_order(1.0, -0.01, 0.01))
    assert hinf_norm(flat).value == pytest.approx(1.0, rel=3e-6)


def test_unstable_system_has_no_norm_and_its_pole_is_named() -> None:
    norm = hinf_norm(diagonal(first_order(0.0, 1.0, 2.0), first_order(0.0, 1.0, -3.0)))
    assert math.isinf(norm.value)
    assert norm.unstable_pole == pytest.approx(3.0)
    assert hinf_norm(first_order(0.0, 1.0, 0.0)).unstable_pole == 0.0


@settings(deadline=None, max_examples=40, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 8))
def test_bounds_hold_a_dense_grid_and_ignore_the_units_of_states(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    system = random_stable(rng, n, 2, 3)
    norm = hinf_norm(system)
    dense = grid_norm(system, np.concatenate(([0.0, np.inf], np.geomspace(1e-3, 1e3, 800))))[0]
    assert dense <= norm.value * (1.0 + 1e-9)
    assert norm.value <= norm.lower * (1.0 + 3e-6)
    assert grid_norm(system, np.array([norm.frequency]))[0] == pytest.approx(norm.lower, rel=1e-6)
    t = 10.0 ** rng.uniform(-3.0, 3.0, n)
    other = Realisation(system.A * t / t[:, None], system.B / t[:, None], system.C * t, system.D)
    assert hinf_norm(other).value == pytest.approx(norm.value, rel=1e-5)


def test_joined_systems_have_joined_responses() -> None:
    rng = np.random.default_rng(1)
    one, two = random_stable(rng, 3, 2, 3), random_stable(rng, 2, 3, 1)
    omega = np.array([0.0, 0.3, 7.0, np.inf])
    np.testing.assert_allclose(
        response(series(two, one), omega), response(two, omega) @ response(one, omega), atol=1e-12
    )
    side = response(diagonal(one, two), omega)
    np.testing.assert_allclose(side[:, :3, :2], response(one, omega), atol=1e-12)
    assert not side[:, :3, 2:].any()
    np.testing.assert_allclose(response(balanced(one)[0], omega), response(one, omega), atol=1e-12)
    s = 2.0j
    weight = rational((1.0, 40.0, 400.0), (0.01, 2.0, 100.0))
    by_hand = (s**2 + 40.0 * s + 400.0) / (0.01 * s**2 + 2.0 * s + 100.0)
    assert response(weight, np.array([2.0]))[0, 0, 0] == pytest.approx(by_hand)


def test_fast_modes_come_to_rest() -> None:
    both = series(first_order(0.0, 1000.0, 1000.0), first_order(0.0, 5.0, 1.0))
    slow = without_fast_modes(both, 100.0)
    assert slow.order == 1
    assert fastest(slow) == pytest.approx(1.0)
    omega = np.array([0.0, 1.0])
    np.testing.assert_allclose(response(slow, omega), response(both, omega), atol=6e-3)
    assert response(slow, omega[:1])[0, 0, 0] == pytest.approx(5.0)
    assert without_fast_modes(both, 1e4) is both


def test_bad_arguments_are_refused() -> None:
    with pytest.raises(ValueError, match=r"tolerance 0\.5; allowed"):
        hinf_norm(gain([[1.0]]), 0.5)
    with pytest.raises(ValueError, match=r"limit -1\.0 rad/s; allowed"):
        without_fast_modes(gain([[1.0]]), -1.0)
    with pytest.raises(ValueError, match="B has shape"):
        realisation(np.eye(2), np.ones((3, 1)), np.ones((1, 2)), [[0.0]])
    with pytest.raises(ValueError, match="D holds a number that is not finite"):
        gain([[math.nan]])
    with pytest.raises(ValueError, match=r"begins with 0\.0; allowed"):
        rational((0.0, 0.0, 1.0), (0.0, 1.0, 1.0))
    with pytest.raises(ValueError, match=r"a numerator of order 2 over 1; allowed"):
        rational((1.0, 0.0, 1.0), (1.0, 1.0))
