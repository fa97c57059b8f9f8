"""Spectral estimates: a lag, feedback that biases, two inputs that feedback couples."""

import numpy as np
import pytest
from closed_loop_data import PERIOD, TRUTH, flown
from test_identification_structures import lag

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_identification.linear_twin import Disturbance, Twin
from heli_identification.records import Record
from heli_identification.sampling import sample
from heli_identification.spectra import spectrum


def one_loop(gain: float, process: float, noise: float) -> Twin:
    """The lag of tau 0.5 s and gain 3 in a loop."""
    none = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0))
    feedback = StateSpace((), ("x",), ("u",), *none, np.array([[gain]]))
    return Twin(lag(), feedback, Disturbance(np.array([process]), np.array([noise])), 0.1)


def test_spectrum_of_a_lag() -> None:
    rng = np.random.default_rng(3)
    record = one_loop(0.0, 0.0, 0.05).fly(np.repeat(rng.choice([-1.0, 1.0], (3000, 1)), 2, axis=0), rng)
    found = spectrum(record, length=20.0)
    place = int(np.searchsorted(found.frequencies, 2.0))
    held = 3.0 / (1.0 + 0.5j * found.frequencies[place])
    assert abs(found.values[place, 0, 0]) == pytest.approx(abs(held), rel=0.1)
    assert found.coherence[place, 0] > 0.95 and found.external
    with pytest.raises(InputError, match="at least 60 s"):
        spectrum(record.piece(0, 500), length=20.0)


def test_feedback_does_not_bias_the_spectrum_from_the_external_signal() -> None:
    """In a loop dominated by noise, S_yu / S_uu sees the inverse of the feedback; S_yr / S_ur the plant."""
    rng = np.random.default_rng(4)
    record = one_loop(-0.5, 0.5, 0.0).fly(0.3 * rng.standard_normal((40_000, 1)), rng)
    low = slice(0, 4)
    right = spectrum(record, length=10.0)
    wrong = spectrum(Record("x", 0.1, ("u",), ("x",), record.u, record.y), length=10.0)
    exact = 3.0 / (1.0 + 0.5j * right.frequencies[low])
    assert np.all(np.abs(right.values[low, 0, 0] - exact) < 3.0 * right.deviation[low, 0, 0])
    assert np.all(np.abs(wrong.values[low, 0, 0] - exact) > 10.0 * wrong.deviation[low, 0, 0])
    assert right.external and not wrong.external


def test_inputs_that_feedback_couples_are_told_apart() -> None:
    """The helicopter's weak path A_1s to q: one input at a time would see the strong one through the loop."""
    found = spectrum(flown(1, 120.0))
    model = sample(TRUTH, TRUTH.values, PERIOD)
    q, band = TRUTH.outputs.index("q"), (found.frequencies > 3.0) & (found.frequencies < 12.0)
    place = TRUTH.states.index("q")
    exact = np.array(
        [
            np.linalg.solve(np.exp(1j * w * PERIOD) * np.eye(8) - model.A, model.B)[place]
            for w in found.frequencies[band]
        ]
    )
    error = np.abs(found.values[band, q] - exact) / found.deviation[band, q]
    assert np.sqrt(np.mean(error**2)) == pytest.approx(1.0, abs=0.4)
    assert np.median(found.deviation[band, q, 1] / np.abs(exact[:, 1])) < 0.3
