"""Validation: fit by hand, frequency responses with bands, spectra, the bound before flying."""

import math

import numpy as np
import pytest
from closed_loop_data import TRUTH, binary, flown, servo_rotor_twin
from test_identification_structures import lag

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_identification.cramer_rao import bound, predicted_errors
from heli_identification.linear_twin import Disturbance, Twin, lq_feedback
from heli_identification.prediction_error import prediction_error
from heli_identification.records import Record
from heli_identification.sampling import Hold
from heli_identification.validation import fit, response, simulate


def open_loop(noise: float, process: float = 0.0) -> Twin:
    """The lag of tau 0.5 s and gain 3 without feedback."""
    none = StateSpace(
        (), ("x",), ("u",), np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.zeros((1, 1))
    )
    return Twin(lag(), none, Disturbance(np.array([process]), np.array([noise])), 0.1)


def test_fit_by_hand() -> None:
    """Half of the output's deviation in error is a fit of 50 %."""
    rng = np.random.default_rng(1)
    twin = open_loop(0.0)
    record = twin.fly(rng.standard_normal((200, 1)), rng)
    exact = fit(lag(), [record], segment=10.0)
    assert exact.percent == pytest.approx([100.0]) and exact.segments.shape == (2, 1)
    spoilt = fit(lag().with_values({"g": 1.5}), [record], segment=10.0, offsets=False)
    state = simulate(lag(), record.piece(0, 100), Hold.ZERO, offsets=False)
    assert state == pytest.approx(record.y[:100], abs=1e-9)
    # half the gain explains half of the motion, and the fitted start a little more
    assert 45.0 < spoilt.percent[0] < 60.0
    with pytest.raises(InputError, match=r"20.0 s of validation data.*at least 30 s"):
        fit(lag(), [record], segment=30.0)


def test_offset_is_no_error_of_the_dynamics() -> None:
    rng = np.random.default_rng(2)
    record = open_loop(0.0).fly(rng.standard_normal((100, 1)), rng)
    moved = Record("moved", 0.1, ("u",), ("x",), record.u + 0.5, record.y)
    assert fit(lag(), [moved]).percent[0] == pytest.approx(100.0)
    assert fit(lag(), [moved], offsets=False).percent[0] < 90.0


def test_model_of_an_estimate_fits_other_data() -> None:
    found = prediction_error(TRUTH.with_values({"M_1": 120.0, "L_p": -25.0}), [flown(1, 20.0)])
    percent = fit(found.structure, [flown(2, 20.0)]).percent
    truth = fit(TRUTH, [flown(2, 20.0)]).percent
    assert np.all(percent > truth - 3.0) and percent[4] > 85.0 and percent[5] > 85.0


def test_response_by_hand() -> None:
    """3 / (1 + j 0.5 omega); its variance from that of tau and g."""
    covariance = np.diag([0.01, 0.04])  # of tau and g
    omega = np.array([0.5, 2.0, 20.0])
    found = response(lag(), covariance, omega)
    denominator = 1.0 + 0.5j * omega
    assert found.values[:, 0, 0] == pytest.approx(3.0 / denominator)
    slopes = -3.0j * omega / denominator**2, 1.0 / denominator
    variance = 0.01 * np.abs(slopes[0]) ** 2 + 0.04 * np.abs(slopes[1]) ** 2
    assert found.deviation[:, 0, 0] == pytest.approx(np.sqrt(variance))


def test_response_band_holds_the_truth() -> None:
    """Over 8 seeds the normalised squared errors at three frequencies stay within chi-square's reach."""
    omega, squares = np.array([0.5, 2.0, 8.0]), []
    exact = response(lag(), np.zeros((2, 2)), omega).values
    for seed in range(8):
        rng = np.random.default_rng(seed)
        record = open_loop(0.3, 0.1).fly(rng.standard_normal((400, 1)), rng)
        found = prediction_error(lag(), [record])
        band = response(found.structure, found.covariance, omega)
        squares.append(np.abs(band.values - exact) ** 2 / band.deviation**2)
    assert 0.2 < float(np.mean(squares)) < 2.5  # expected 1


def test_bound_by_hand() -> None:
    """y = g z + e with everything else known: sigma / |z|, as in every textbook; other unknowns only add."""
    twin = open_loop(0.1)
    structure = lag().with_free(["g"])
    twin = Twin(structure, twin.feedback, twin.disturbance, 0.1)
    rng = np.random.default_rng(5)
    record = twin.fly(rng.standard_normal((2000, 1)), rng)
    clean = open_loop(0.0).fly(record.u, rng).y[:, 0] / 3.0
    least = 0.1 / math.sqrt(clean @ clean)
    found = math.sqrt(bound(twin, [record])[0, 0])
    assert least < found < 1.1 * least


def test_prediction_before_flying() -> None:
    twin = servo_rotor_twin()
    short = predicted_errors(twin, binary(np.random.default_rng(1), 1500), np.random.default_rng(2))
    long = predicted_errors(twin, binary(np.random.default_rng(1), 6000), np.random.default_rng(2))
    assert np.median(long.errors / short.errors) == pytest.approx(0.5, rel=0.15)
    seconds = long.seconds_for(0.1)
    place = long.names.index("M_v")
    assert seconds[place] == pytest.approx(60.0 * (long.errors[place] / (0.1 * 0.19)) ** 2)
    found = prediction_error(TRUTH, [flown(9, 15.0)])
    assert np.median(found.errors / short.errors) == pytest.approx(1.0, abs=0.15)


def test_a_feedback_that_does_not_hold_the_plant() -> None:
    twin = servo_rotor_twin()
    reversed_gain = StateSpace(
        (),
        twin.feedback.inputs,
        twin.feedback.outputs,
        twin.feedback.A,
        twin.feedback.B,
        twin.feedback.C,
        -3.0 * twin.feedback.D,
    )
    wild = Twin(TRUTH, reversed_gain, twin.disturbance, 0.01)
    with pytest.raises(InputError, match="does not hold the model"):
        wild.fly(np.zeros((6000, 2)), np.random.default_rng(1))
    assert lq_feedback(TRUTH, 0.01).D.shape == (2, 6)
