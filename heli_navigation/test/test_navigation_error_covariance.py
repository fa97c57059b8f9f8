"""Covariance: against dense matrices, against differences of the dead reckoning, against chance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from heli_navigation.error_covariance import (
    column_of_error,
    column_of_place,
    grow,
    hold,
    keep_above,
    renew,
    shrink,
    widen,
)
from heli_navigation.filter_memory import SIZE, Estimate, Work
from heli_navigation.strapdown import reckon

PERIOD = 2.5e-3
NOISE = (2e-5, 3e-6, 1e-7, 4e-8)
V, E, G, F = (
    int(part) for part in (Estimate.velocity, Estimate.angle, Estimate.gyro_bias, Estimate.force_bias)
)
PLACED = [*range(V), *range(E, G)]


def some_covariance(seed: int, size: float = 1.0) -> np.ndarray:
    root = np.random.default_rng(seed).normal(0.0, size, (SIZE, SIZE))
    full = root @ root.T
    return np.ascontiguousarray(0.5 * (full + full.T)).ravel()


def some_motion(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """An estimate and the work of one sample of dead reckoning from it."""
    generator = np.random.default_rng(seed)
    estimate, work = generator.normal(0.0, 0.2, SIZE), np.zeros(Work.end)
    work[Work.rate : Work.push] = generator.normal(0.0, 1.0, 3)
    work[Work.push : Work.column] = (0.5, -0.3, -9.5)
    return estimate, work


def reckoned(estimate: np.ndarray, gyro: np.ndarray, force: np.ndarray) -> np.ndarray:
    after, work = estimate.copy(), np.zeros(Work.end)
    work[Work.rate : Work.push] = gyro - estimate[G:F]
    work[Work.push : Work.column] = force - estimate[F:]
    reckon(after, PERIOD, 9.81, work)
    return after


def transition(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """F by differences of the dead reckoning, the work that goes with it, and Q."""
    estimate, work = some_motion(seed)
    gyro = work[Work.rate : Work.push] + estimate[G:F]
    force = work[Work.push : Work.column] + estimate[F:]
    step, matrix = 1e-6, np.zeros((SIZE, SIZE))
    for column in range(SIZE):
        shift = step * np.eye(SIZE)[column]
        up, down = reckoned(estimate + shift, gyro, force), reckoned(estimate - shift, gyro, force)
        matrix[:, column] = (up - down) / (2.0 * step)
    reckon(estimate.copy(), PERIOD, 9.81, work)
    rates = work[Work.rates : Work.bend].reshape(3, 3)
    noise = np.zeros((SIZE, SIZE))
    noise[V:E, V:E], noise[E:G, E:G] = NOISE[0] * np.eye(3), NOISE[1] * rates @ rates.T
    noise[G:F, G:F], noise[F:, F:] = NOISE[2] * np.eye(3), NOISE[3] * np.eye(3)
    return matrix, work, noise


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000))
def test_growth_is_that_of_the_dead_reckonings_own_errors(seed: int) -> None:
    matrix, work, noise = transition(seed)
    covariance = some_covariance(seed + 1)
    expected = matrix @ covariance.reshape(SIZE, SIZE) @ matrix.T + noise
    grow(covariance, work, PERIOD, 1.0, *NOISE)
    got = covariance.reshape(SIZE, SIZE)
    # F is of first order in the period: what differs is period^2 times accelerations and rates
    scale = np.sqrt(np.outer(expected.diagonal(), expected.diagonal()))
    assert np.abs(got - expected).max() < 3e-3 * scale.max()
    assert np.array_equal(got, got.T)


def test_growth_against_the_matrix_product() -> None:
    _, work, noise = transition(3)
    body, rates, bent, leant = (
        work[first : first + 9].reshape(3, 3) for first in (Work.body, Work.rates, Work.bend, Work.lean)
    )
    matrix = np.eye(SIZE)
    matrix[:V, V:E] = PERIOD * np.eye(3)
    matrix[V:E, E:G], matrix[V:E, F:] = PERIOD * leant, -PERIOD * body
    matrix[E:G, E:G] += PERIOD * bent
    matrix[E:G, G:F] = -PERIOD * rates
    covariance = some_covariance(4)
    expected = matrix @ covariance.reshape(SIZE, SIZE) @ matrix.T + noise
    grow(covariance, work, PERIOD, 1.0, *NOISE)
    assert covariance.reshape(SIZE, SIZE) == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_without_accelerometers_their_bias_does_not_matter() -> None:
    _, work, _ = transition(5)
    covariance = np.zeros(SIZE * SIZE)
    widen(covariance, F, 1.0)
    grow(covariance, work, PERIOD, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert covariance.reshape(SIZE, SIZE)[V:E, V:E] == pytest.approx(np.zeros((3, 3)))


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.floats(1e-6, 10.0), st.floats(-1.0, 1.0))
def test_shrinking_is_the_textbooks_update(seed: int, noise: float, innovation: float) -> None:
    covariance, work = some_covariance(seed), np.zeros(Work.end)
    before = covariance.reshape(SIZE, SIZE).copy()
    h = np.zeros(SIZE)
    h[[0, 1, 2, 6, 7, 8]] = np.random.default_rng(seed).normal(0.0, 1.0, 6)
    variance = column_of_place(covariance, *h[:3], *h[6:9], work)
    assert variance == pytest.approx(h @ before @ h)
    shrink(covariance, innovation, variance + noise, work)
    gain = before @ h / (h @ before @ h + noise)
    assert covariance.reshape(SIZE, SIZE) == pytest.approx(before - np.outer(gain, h @ before), abs=1e-9)
    assert work[Work.correction : Work.slope] == pytest.approx(gain * innovation, abs=1e-9)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.floats(1e-3, 10.0))
def test_holding_is_schmidts_update(seed: int, noise: float) -> None:
    covariance, work = some_covariance(seed), np.zeros(Work.end)
    before = covariance.reshape(SIZE, SIZE).copy()
    variance = column_of_error(covariance, E + 1, work)
    hold(covariance, 0.7, variance + noise, work)
    h = np.eye(SIZE)[E + 1]
    gain = np.zeros(SIZE)
    gain[PLACED] = (before @ h)[PLACED] / (variance + noise)
    rest = np.eye(SIZE) - np.outer(gain, h)
    joseph = rest @ before @ rest.T + noise * np.outer(gain, gain)
    assert covariance.reshape(SIZE, SIZE) == pytest.approx(joseph, abs=1e-8)
    assert work[Work.correction : Work.slope] == pytest.approx(0.7 * gain)


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10_000), st.lists(st.integers(0, 3), min_size=20, max_size=60))
def test_it_stays_symmetric_and_positive_definite(seed: int, acts: list[int]) -> None:
    generator = np.random.default_rng(seed)
    covariance = some_covariance(seed, 1e-2)
    _, work = some_motion(seed)
    reckon(np.zeros(SIZE), PERIOD, 9.81, work)
    for act in acts:
        if act == 0:
            grow(covariance, work, PERIOD, 1.0, *NOISE)
        else:
            if act == 1:
                variance = column_of_error(covariance, E + int(generator.integers(3)), work)
            else:
                variance = column_of_place(covariance, *generator.normal(0.0, 1.0, 6), work)
            (hold if act == 3 else shrink)(covariance, 0.0, variance + 1e-9, work)
        full = covariance.reshape(SIZE, SIZE)
        assert np.array_equal(full, full.T)
        deviations = np.sqrt(full.diagonal())
        assert np.linalg.eigvalsh(full / np.outer(deviations, deviations))[0] > 0.0


def test_widening_renewing_and_keeping() -> None:
    covariance = some_covariance(7)
    before = covariance.reshape(SIZE, SIZE).copy()
    widen(covariance, V, 2.0)
    change = covariance.reshape(SIZE, SIZE) - before
    assert change.sum() == pytest.approx(6.0)
    assert change[V, V] == pytest.approx(2.0)
    renew(covariance, G, 5.0)
    full = covariance.reshape(SIZE, SIZE)
    assert np.array_equal(full[G:F, G:F], 5.0 * np.eye(3))
    assert not full[G:F, :G].any()
    assert not full[:G, G:F].any()
    keep_above(covariance, G, 4.0)
    assert full[G, G] == 5.0
    keep_above(covariance, G, 6.0)
    assert full[G, G] == 6.0


def test_errors_of_a_linear_system_are_as_large_as_it_says() -> None:
    # errors drawn from the very model: their normalised square is chi-square distributed
    runs, steps, generator = 60, 40, np.random.default_rng(11)
    _, work, noise = transition(2)
    body, rates, bent, leant = (
        work[first : first + 9].reshape(3, 3) for first in (Work.body, Work.rates, Work.bend, Work.lean)
    )
    matrix = np.eye(SIZE)
    matrix[:V, V:E] = PERIOD * np.eye(3)
    matrix[V:E, E:G], matrix[V:E, F:], matrix[E:G, G:F] = PERIOD * leant, -PERIOD * body, -PERIOD * rates
    matrix[E:G, E:G] += PERIOD * bent
    first = 1e-2 * some_covariance(12)
    root, shaking = np.linalg.cholesky(first.reshape(SIZE, SIZE)), np.sqrt(np.array(NOISE))
    slopes, blur = generator.normal(0.0, 1.0, (steps, 6)), 1e-2
    total = 0.0
    for _ in range(runs):
        covariance, error = first.copy(), root @ generator.normal(size=SIZE)
        for step in range(steps):
            shaken = np.zeros(SIZE)
            shaken[V:E] = shaking[0] * generator.normal(size=3)
            shaken[E:G] = shaking[1] * rates @ generator.normal(size=3)
            shaken[G:F], shaken[F:] = (shaking[k] * generator.normal(size=3) for k in (2, 3))
            error = matrix @ error + shaken
            grow(covariance, work, PERIOD, 1.0, *NOISE)
            variance = column_of_place(covariance, *slopes[step], work)
            measured = slopes[step] @ error[PLACED] + blur * generator.normal()
            work[Work.correction : Work.slope] = 0.0
            shrink(covariance, measured, variance + blur**2, work)
            error = error - work[Work.correction : Work.slope]
        total += error @ np.linalg.solve(covariance.reshape(SIZE, SIZE), error)
    assert noise.any()
    low, high = chi2.ppf((0.001, 0.999), SIZE * runs)
    assert low < total < high
