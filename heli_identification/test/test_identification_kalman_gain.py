"""Steady-state gain: the scalar Riccati equation by hand, derivatives against differences."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_identification.kalman_gain import gain_derivatives, kalman_gain


def test_random_walk_by_hand() -> None:
    # x+ = x + w, y = x + v, both of variance 1: P = (1 + sqrt 5) / 2, the golden ratio
    one = np.eye(1)
    gain = kalman_gain(one, one, one, one)
    golden = (1.0 + math.sqrt(5.0)) / 2.0
    assert gain.P[0, 0] == pytest.approx(golden, rel=1e-12)
    assert gain.S[0, 0] == pytest.approx(golden + 1.0, rel=1e-12)
    assert gain.K[0, 0] == pytest.approx(golden / (golden + 1.0), rel=1e-12)


def test_derivative_by_hand() -> None:
    # the same with process noise q: P^2 = q (P + 1), so dP/dq = (P + 1) / (2 P - q)
    one = np.eye(1)
    gain = kalman_gain(one, one, one, one)
    _, ds = gain_derivatives(one, one, gain, np.zeros((1, 1, 1)), np.ones((1, 1, 1)), np.zeros((1, 1, 1)))
    p = gain.P[0, 0]
    assert ds[0, 0, 0] == pytest.approx((p + 1.0) / (2.0 * p - 1.0), rel=1e-10)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_derivatives_are_those_of_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, c = 0.6 * rng.standard_normal((4, 4)), np.eye(2, 4)
    a *= 0.95 / max(0.95, float(np.max(np.abs(np.linalg.eigvals(a)))))
    q, r = np.diag(rng.uniform(0.1, 1.0, 4)), np.diag(rng.uniform(0.1, 1.0, 2))
    da, dq = rng.standard_normal((1, 4, 4)), np.diag(rng.standard_normal(4))[None]
    dr = np.diag(rng.standard_normal(2))[None]
    dk, ds = gain_derivatives(a, c, kalman_gain(a, c, q, r), da, dq, dr)
    step = 1e-6
    ahead = kalman_gain(a + step * da[0], c, q + step * dq[0], r + step * dr[0])
    behind = kalman_gain(a - step * da[0], c, q - step * dq[0], r - step * dr[0])
    assert dk[0] == pytest.approx((ahead.K - behind.K) / (2.0 * step), rel=1e-4, abs=1e-5)
    assert ds[0] == pytest.approx((ahead.S - behind.S) / (2.0 * step), rel=1e-4, abs=1e-5)


def test_without_a_solution() -> None:
    # an unstable state nothing measures
    with pytest.raises(ValueError, match="no steady-state Kalman gain"):
        kalman_gain(np.diag([2.0, 0.5]), np.array([[0.0, 1.0]]), np.eye(2), np.eye(1))
