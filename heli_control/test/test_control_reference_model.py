"""The expected response: by hand, against the differential equation, at rest where it should be."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from heli_common.timing import CONTROL_PERIOD
from heli_control.reference_model import ReferenceModel


def test_step_by_hand() -> None:
    model = ReferenceModel(2.0)
    for _ in range(50):
        model.step(1.0)
    # 1 - (1 + omega t) e^(-omega t) at omega t = 1
    assert model.value == pytest.approx(1.0 - 2.0 / math.e, rel=1e-12)
    assert model.rate == pytest.approx(2.0 / math.e, rel=1e-12)


@settings(deadline=None, max_examples=30)
@given(st.floats(0.2, 20.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_it_solves_its_equation(frequency: float, value: float, rate: float, reference: float) -> None:
    model = ReferenceModel(frequency)
    model.value, model.rate = value, rate

    def equation(_t: float, state: np.ndarray) -> list[float]:
        return [state[1], frequency**2 * (reference - state[0]) - 2.0 * frequency * state[1]]

    solved = solve_ivp(equation, (0.0, 5 * CONTROL_PERIOD), [value, rate], rtol=1e-11, atol=1e-12)
    for _ in range(5):
        model.step(reference)
    np.testing.assert_allclose([model.value, model.rate], solved.y[:, -1], atol=1e-9)


def test_a_ramp_is_followed_with_its_rate() -> None:
    model = ReferenceModel(3.0)
    for tick in range(1_000):
        model.step(0.2 * tick * CONTROL_PERIOD)
    assert model.rate == pytest.approx(0.2, rel=0.02)  # the reference is held for 10 ms


def test_at_rest_it_stays() -> None:
    model = ReferenceModel(3.0)
    model.reset(0.7)
    model.step(0.7)
    assert (model.value, model.rate) == (pytest.approx(0.7, abs=1e-15), pytest.approx(0.0, abs=1e-15))
