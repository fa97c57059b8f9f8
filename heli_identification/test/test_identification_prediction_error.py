"""Prediction error method: first order by hand, exact data, honest errors over seeds, refusals."""

import numpy as np
import pytest
from closed_loop_data import PERIOD, TRUTH, flown, perturbed, true_values
from scipy.stats import chi2
from test_identification_structures import lag

from heli_common.errors import InputError
from heli_identification.parametrisation import Noise
from heli_identification.prediction_error import Search, prediction_error
from heli_identification.records import Record


def lag_record(rng: np.random.Generator, noise: float, count: int = 400) -> Record:
    """Output error data of tau 0.5 s, gain 3, sampled every 0.1 s from rest."""
    u = rng.standard_normal((count, 1))
    x, kept = np.zeros((count, 1)), np.exp(-0.2)
    for step in range(count - 1):
        x[step + 1] = kept * x[step] + 3.0 * (1.0 - kept) * u[step]
    return Record("lag", 0.1, ("u",), ("x",), u, x + noise * rng.standard_normal((count, 1)))


def test_first_order_without_noise_is_exact() -> None:
    record = lag_record(np.random.default_rng(1), 1e-9)
    found = prediction_error(
        lag().with_values({"tau": 0.8, "g": 2.0}), [record], noise=Noise.OUTPUT_ERROR, offsets=False
    )
    assert found.converged
    assert found.values == pytest.approx([0.5, 3.0], rel=1e-7)


def test_gain_alone_has_the_error_of_a_regression() -> None:
    # with tau and the start known, y = g z + e: the standard error is sigma / |z|
    rng = np.random.default_rng(2)
    record = lag_record(rng, 0.1, 2000)
    structure = lag().with_free(["g"])
    found = prediction_error(structure, [record], noise=Noise.OUTPUT_ERROR, offsets=False)
    z, kept = np.zeros(2000), np.exp(-0.2)
    for step in range(1999):
        z[step + 1] = kept * z[step] + (1.0 - kept) * record.u[step, 0]
    # the fitted initial state takes one direction away, kept^k
    start = kept ** np.arange(2000)
    z = z - start * (start @ z) / (start @ start)
    y = record.y[:, 0] - start * (start @ record.y[:, 0]) / (start @ start)
    gain = float(z @ y / (z @ z))
    sigma = float(np.sqrt(np.mean((y - gain * z) ** 2)))
    assert found.values[0] == pytest.approx(gain, rel=1e-6)
    assert np.sqrt(found.fisher[0, 0]) == pytest.approx(sigma / np.sqrt(z @ z), rel=1e-4)


def test_servo_rotor_with_little_noise_is_close() -> None:
    found = prediction_error(perturbed(TRUTH, 1, 0.1), [flown(1, 10.0, noise=0.02)])
    assert found.converged
    # what is left is noise: a hundredth of each coefficient's expected size
    assert np.all(np.abs(found.values - true_values(found.names)) < 0.02 * TRUTH.scales[: len(found.values)])


@pytest.fixture(scope="module")
def estimates() -> list[np.ndarray]:
    """Errors by their claimed standard errors, and normalised squares, of eight closed-loop flights."""
    rows = []
    for seed in range(8):
        found = prediction_error(perturbed(TRUTH, seed), [flown(100 + seed, 20.0)])
        assert found.converged and found.white
        error = found.values - true_values(found.names)
        square = float(error @ np.linalg.solve(found.covariance, error))
        rows.append(np.append(error / found.errors, square))
    return rows


def test_errors_are_those_claimed(estimates: list[np.ndarray]) -> None:
    """The normalised squares of 8 flights with 18 coefficients are chi-square of 144: both tails count."""
    total, freedom = sum(row[-1] for row in estimates), 8 * 18
    assert chi2.ppf(0.001, freedom) < total < chi2.ppf(0.999, freedom)
    inside = np.mean(np.abs(np.array([row[:-1] for row in estimates])) < 1.96)
    assert 0.88 < inside < 0.99


def test_feedback_noise_biases_output_error() -> None:
    """What the noise model is for: K = 0 on data with gusts is off by many of its own standard errors."""
    found = prediction_error(TRUTH, [flown(3, 20.0)], noise=Noise.OUTPUT_ERROR)
    worst = np.max(np.abs(found.values - true_values(found.names)) / np.sqrt(np.diag(found.fisher)))
    assert worst > 8.0 and not found.white


def test_free_gain_agrees_with_the_kalman_gain() -> None:
    record = flown(4, 15.0)
    one = prediction_error(TRUTH, [record], noise=Noise.KALMAN)
    two = prediction_error(TRUTH, [record], noise=Noise.FREE_GAIN)
    assert np.max(np.abs(one.values - two.values) / one.errors) < 2.0
    assert two.K.shape == (8, 6) and len(two.noise_names) == 48


def test_stepwise_and_at_once_meet() -> None:
    record = flown(5, 10.0)
    one = prediction_error(perturbed(TRUTH, 5), [record])
    two = prediction_error(perturbed(TRUTH, 5), [record], search=Search(stepwise=False))
    assert one.values == pytest.approx(two.values, rel=1e-2, abs=1e-2)
    assert one.steps[0].stage.startswith("M_q") and two.steps[0].stage == "all"


def test_two_pieces_know_more_than_one() -> None:
    record = flown(6, 20.0)
    one = prediction_error(TRUTH, [record.piece(0, 1000)])
    two = prediction_error(TRUTH, [record.piece(0, 1000), record.piece(1000, 2000)])
    assert np.all(two.errors < one.errors)
    assert len(two.starts) == len(two.residuals) == 2


def test_what_an_input_at_rest_leaves_open_is_named() -> None:
    record = flown(7, 10.0)
    quiet = Record("quiet", PERIOD, record.inputs, record.outputs, record.u * [1.0, 0.0], record.y, record.r)
    found = prediction_error(TRUTH, [quiet], search=Search(stepwise=False, iterations=2))
    named = {name for weak in found.weak for name in weak.names}
    assert {"M_2", "L_2"} <= named


def test_refusals() -> None:
    record = flown(1, 1.0)
    with pytest.raises(InputError, match="no data"):
        prediction_error(TRUTH, [])
    with pytest.raises(InputError, match="nothing is free"):
        prediction_error(TRUTH.with_free([]), [record])
    with pytest.raises(InputError, match=r"signals B_1s, A_1s.*allowed: u"):
        prediction_error(lag(), [record])
    wild = TRUTH.with_values({"M_q": 400.0})
    with pytest.raises(InputError, match="unstable at the start values"):
        prediction_error(wild, [flown(1, 3.0)], noise=Noise.OUTPUT_ERROR)
