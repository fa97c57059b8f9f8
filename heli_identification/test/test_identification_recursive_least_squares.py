"""Recursive least squares: by hand, against the batch solution, and whether its errors are honest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_identification.recursive_least_squares import RecursiveLeastSquares


def run(regressors: np.ndarray, measured: np.ndarray, forgetting: float) -> RecursiveLeastSquares:
    fit = RecursiveLeastSquares(regressors.shape[1], forgetting)
    for regressor, value in zip(regressors, measured, strict=True):
        fit.step(regressor, float(value))
    return fit


def test_a_mean_by_hand() -> None:
    """Regressor 1: estimate 2, residuals -1, 0, 1, so s^2 = 2 / 2 and the mean's variance is 1 / 3."""
    fit = run(np.ones((3, 1)), np.array([1.0, 2.0, 3.0]), 1.0)
    assert fit.estimate == pytest.approx([2.0])
    assert fit.variance == pytest.approx(1.0)
    assert fit.standard_error == pytest.approx([3.0**-0.5])


def test_a_forgetting_mean_by_hand() -> None:
    """Weights 1/4, 1/2, 1: mean (1/4 + 4 * 1/2 + 7 * 1) / (7/4), and the variance the weighted one."""
    fit = run(np.ones((3, 1)), np.array([1.0, 4.0, 7.0]), 0.5)
    mean = (0.25 + 2.0 + 7.0) / 1.75
    residual = 0.25 * (1 - mean) ** 2 + 0.5 * (4 - mean) ** 2 + (7 - mean) ** 2
    squared = (0.0625 + 0.25 + 1.0) / 1.75
    assert fit.estimate == pytest.approx([mean])
    assert fit.variance == pytest.approx(residual / (1.75 - squared))
    assert fit.standard_error == pytest.approx([(fit.variance * squared / 1.75) ** 0.5])


def test_the_prediction_error_is_that_before_the_sample() -> None:
    fit = RecursiveLeastSquares(1)
    assert fit.step(np.array([1.0]), 5.0) == 5.0
    assert fit.step(np.array([1.0]), 5.0) == pytest.approx(0.0, abs=1e-6)


@settings(max_examples=30, deadline=None)
@given(
    count=st.integers(1, 5),
    samples=st.integers(20, 80),
    forgetting=st.floats(0.9, 1.0),
    seed=st.integers(0, 999),
)
def test_twin_of_the_weighted_batch_solution(count: int, samples: int, forgetting: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    regressors = rng.standard_normal((samples, count))
    measured = regressors @ rng.standard_normal(count) + 0.3 * rng.standard_normal(samples)
    fit = run(regressors, measured, forgetting)
    weights = forgetting ** np.arange(samples)[::-1]
    root = np.sqrt(weights)
    batch, *_ = np.linalg.lstsq(root[:, None] * regressors, root * measured, rcond=None)
    residual = measured - regressors @ batch
    # the hat matrix of weighted least squares gives the expectation of the weighted residuals
    inverse = np.linalg.inv(regressors.T @ (weights[:, None] * regressors))
    hat = regressors @ inverse @ (regressors.T * weights)
    left = np.trace((np.eye(samples) - hat).T @ np.diag(weights) @ (np.eye(samples) - hat))
    variance = residual @ (weights * residual) / left
    gain = inverse @ (regressors.T * weights)
    assert np.allclose(fit.estimate, batch, atol=1e-5)
    assert np.isclose(fit.variance, variance, rtol=1e-4)
    assert np.allclose(fit.covariance, variance * gain @ gain.T, rtol=1e-4, atol=1e-9)


def test_claimed_errors_are_the_spread_over_many_runs() -> None:
    """With forgetting, 400 runs of the same regressors: spread and mean claimed error agree."""
    rng = np.random.default_rng(5)
    regressors = np.column_stack([rng.standard_normal(150), np.ones(150)])
    runs = [
        run(regressors, regressors @ [2.0, -1.0] + 0.5 * rng.standard_normal(150), 0.97) for _ in range(400)
    ]
    spread = np.std([fit.estimate for fit in runs], axis=0)
    claimed = np.sqrt(np.mean([fit.standard_error**2 for fit in runs], axis=0))
    assert np.allclose(claimed / spread, 1.0, atol=0.12)
    inside = [np.abs(fit.estimate - [2.0, -1.0]) < 1.96 * fit.standard_error for fit in runs]
    assert 0.92 < np.mean(inside) < 0.97


def test_nothing_is_claimed_before_there_is_more_than_parameters() -> None:
    fit = RecursiveLeastSquares(2)
    assert np.all(np.isinf(fit.standard_error))
    fit.step(np.array([1.0, 0.0]), 1.0)
    fit.step(np.array([0.0, 1.0]), 1.0)
    assert np.all(np.isinf(fit.standard_error))
    fit.step(np.array([1.0, 1.0]), 2.5)
    assert np.all(np.isfinite(fit.standard_error))


@pytest.mark.parametrize("forgetting", [0.0, 1.01, -0.5])
def test_a_forgetting_factor_out_of_range_is_refused(forgetting: float) -> None:
    with pytest.raises(ValueError, match="forgetting factor"):
        RecursiveLeastSquares(2, forgetting)
