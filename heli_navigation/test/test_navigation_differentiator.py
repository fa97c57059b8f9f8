from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from heli_navigation.differentiator import DAMPING, Differentiator, LowPass

PERIOD = 0.0025


def test_first_sample_starts_without_a_jump() -> None:
    differentiator = Differentiator(40.0, PERIOD)
    assert differentiator.step(0.7) == 0.0
    assert differentiator.step(0.7) == 0.0


def test_constant_velocity_is_reproduced_exactly() -> None:
    differentiator = Differentiator(40.0, PERIOD)
    for k in range(800):
        rate = differentiator.step(1.0 + 0.3 * k * PERIOD)
    assert rate == pytest.approx(0.3, abs=1e-12)


def test_constant_acceleration_lags_by_the_stated_delay() -> None:
    differentiator = Differentiator(40.0, PERIOD)
    assert differentiator.delay == pytest.approx(2.0 * math.sqrt(0.5) / 40.0)
    for k in range(1200):
        time = k * PERIOD
        rate = differentiator.step(0.5 * 2.0 * time * time)
    assert 2.0 * time - rate == pytest.approx(2.0 * differentiator.delay, rel=1e-6)


@settings(deadline=None, max_examples=15)
@given(st.floats(5.0, 200.0), st.lists(st.floats(-1.0, 1.0), min_size=8, max_size=8))
def test_closed_solution_agrees_with_numerical_integration(bandwidth: float, samples: list[float]) -> None:
    differentiator = Differentiator(bandwidth, PERIOD)
    closed = [differentiator.step(sample) for sample in samples]
    times = np.arange(len(samples)) * PERIOD

    def derivative(time: float, y: np.ndarray) -> list[float]:
        x = np.interp(time, times, samples)
        return [y[1], bandwidth**2 * (x - y[0]) - 2.0 * DAMPING * bandwidth * y[1]]

    state = [samples[0], 0.0]
    numeric = [0.0]
    for start, end in pairwise(times):
        state = solve_ivp(derivative, (start, end), state, rtol=1e-10, atol=1e-10).y[:, -1]
        numeric.append(state[1])
    np.testing.assert_allclose(closed, numeric, atol=1e-6 * bandwidth)


def test_stated_deviation_bounds_a_slowly_crossed_quantisation() -> None:
    step, bandwidth = 1e-3, 40.0
    worst = 0.0
    for speed in step * bandwidth / (8.0 * DAMPING) * np.array([0.25, 0.5, 1.0, 2.0, 4.0]):
        differentiator = Differentiator(bandwidth, PERIOD)
        errors = [differentiator.step(step * round(speed * k * PERIOD / step)) - speed for k in range(20_000)]
        worst = max(worst, float(np.std(errors[2000:])))
    stated = step * differentiator.quantisation_gain
    assert 0.9 * stated < worst <= stated


def test_resume_keeps_the_rate_and_ignores_the_jump() -> None:
    differentiator = Differentiator(40.0, PERIOD)
    for k in range(400):
        differentiator.step(0.2 * k * PERIOD)
    before = differentiator.rate
    differentiator.resume(5.0)
    assert differentiator.rate == before
    assert differentiator.step(5.0 + 0.2 * PERIOD) == pytest.approx(0.2, abs=1e-6)


def test_reset_forgets_and_resume_starts() -> None:
    differentiator = Differentiator(40.0, PERIOD)
    differentiator.step(0.0)
    differentiator.step(1.0)
    differentiator.reset()
    assert differentiator.rate == 0.0
    differentiator.resume(3.0)
    assert differentiator.step(3.0) == 0.0


def test_low_pass_hand_case_and_delay() -> None:
    low_pass = LowPass(math.log(2.0) / 0.01, 0.01)  # keeps half
    assert [low_pass.step(x) for x in (4.0, 8.0, 8.0)] == pytest.approx([4.0, 6.0, 7.0])
    ramp = LowPass(100.0, 0.01)
    for k in range(200):
        value = ramp.step(3.0 * k * 0.01)
    assert 3.0 * 1.99 - value == pytest.approx(3.0 * ramp.delay)


@pytest.mark.parametrize("filter_class", [Differentiator, LowPass])
@pytest.mark.parametrize(("bandwidth", "period"), [(0.0, 0.01), (40.0, 0.0), (-1.0, 0.01), (math.nan, 0.01)])
def test_bandwidth_and_period_must_be_positive(filter_class: type, bandwidth: float, period: float) -> None:
    with pytest.raises(ValueError, match="must be positive"):
        filter_class(bandwidth, period)
