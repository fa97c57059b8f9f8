"""Covariances: robust errors by hand, directions the data cannot tell, tests of residuals."""

import numpy as np
import pytest

from heli_identification.residual_tests import autocorrelation, cross_correlation, residuals_white
from heli_identification.uncertainty import correlations, inverse_information, sandwich, weaknesses


def test_inverse_information_by_hand() -> None:
    assert inverse_information(np.array([[4.0, 0.0], [0.0, 25.0]])).tolist() == [[0.25, 0.0], [0.0, 0.04]]
    blind = inverse_information(np.diag([4.0, 0.0]))
    assert blind[0, 0] == 0.25 and np.isinf(blind[1, 1])
    together = inverse_information(np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 4.0]]))
    assert np.isinf(np.diag(together)).tolist() == [True, True, False] and together[2, 2] == 0.25


def test_sandwich_of_a_mean() -> None:
    """The mean of a moving average of two: variance (1 + 2 * 1/2) times that of white noise."""
    rng = np.random.default_rng(1)
    white = rng.standard_normal(200_001)
    coloured = (white[1:] + white[:-1]) / np.sqrt(2.0)
    scores = coloured[:, None]  # of the mean with unit variance
    covariance = np.array([[1.0 / len(scores)]])
    assert sandwich(covariance, [white[:, None]], 20)[0, 0] == pytest.approx(covariance[0, 0], rel=0.1)
    assert sandwich(covariance, [scores], 20)[0, 0] == pytest.approx(2.0 * covariance[0, 0], rel=0.1)


def test_sandwich_is_the_sum_over_lags() -> None:
    """Bartlett's weights written out."""
    rng = np.random.default_rng(2)
    scores, lag = rng.standard_normal((40, 2)), 5
    middle = scores.T @ scores
    for j in range(1, lag):
        gamma = scores[j:].T @ scores[:-j]
        middle += (1.0 - j / lag) * (gamma + gamma.T)
    assert sandwich(np.eye(2), [scores], lag) == pytest.approx(middle)


def test_weak_directions_are_named_with_the_reason() -> None:
    tied = np.array([[1.0, -0.999, 0.0], [-0.999, 1.0, 0.0], [0.0, 0.0, 1e-4]])
    (weak,) = weaknesses(("M_a", "M_1", "X_u"), tied, np.ones(3))
    assert set(weak.names) == {"M_a", "M_1"} and "act alike" in weak.reason
    assert weak.deviation == pytest.approx(np.sqrt(1.999))
    (alone,) = weaknesses(("M_v", "X_u"), np.diag([4.0, 1e-4]), np.ones(2))
    assert alone.names == ("M_v",) and "hardly moves" in alone.reason
    (blind,) = weaknesses(("k", "X_u"), np.diag([np.inf, 1e-4]), np.ones(2))
    assert blind.names == ("k",) and np.isinf(blind.deviation)


def test_correlations() -> None:
    found = correlations(np.array([[4.0, 1.0], [1.0, 1.0]]))
    assert found == pytest.approx(np.array([[1.0, 0.5], [0.5, 1.0]]))
    assert correlations(np.diag([np.inf, 1.0])).tolist() == np.eye(2).tolist()


def test_white_and_coloured_residuals() -> None:
    rng = np.random.default_rng(3)
    white = rng.standard_normal((4000, 2))
    coloured = white.copy()
    coloured[1:, 1] += 0.15 * coloured[:-1, 1]
    assert residuals_white([white]) and not residuals_white([coloured])
    assert np.max(autocorrelation(white, 100).outside) < 0.12
    assert autocorrelation(coloured).values[1, 1] == pytest.approx(0.15, abs=0.04)


def test_whiteness_is_rarely_denied_to_white_noise() -> None:
    denied = sum(
        not residuals_white([np.random.default_rng(s).standard_normal((500, 3))]) for s in range(300)
    )
    assert denied <= 4  # expected 0.3 at a level of 0.001


def test_cross_correlation_by_hand() -> None:
    rng = np.random.default_rng(4)
    u = rng.standard_normal((5000, 1))
    e = rng.standard_normal((5000, 1))
    e[3:] += 0.5 * u[:-3]
    found = cross_correlation(e, u, 10)
    at = {int(lag): float(value) for lag, value in zip(found.lags, found.values[:, 0, 0], strict=True)}
    assert at[3] == pytest.approx(0.5 / np.sqrt(1.25), abs=0.03)
    assert max(abs(value) for lag, value in at.items() if lag != 3) < 0.06
    assert found.bound[0, 0] == pytest.approx(1.96 / np.sqrt(5000), rel=0.3)
