"""Exact sampling: a first-order lag by hand, derivatives against differences, fine simulation as a twin."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_identification_structures import lag

from heli_identification.helicopter_structures import STRUCTURES
from heli_identification.sampling import Hold, held_inputs, sample
from heli_identification.structures import Structure


def test_first_order_by_hand() -> None:
    tau, gain, period = 0.5, 3.0, 0.1
    found = sample(lag(), np.array([tau, gain]), period)
    kept = math.exp(-period / tau)
    assert found.A[0, 0] == pytest.approx(kept, rel=1e-14)
    assert found.B[0, 0] == pytest.approx(gain * (1.0 - kept), rel=1e-13)
    assert found.N[0, 0] == pytest.approx(tau * (1.0 - kept), rel=1e-13)
    slope = kept * period / tau**2
    assert found.dA[:, 0, 0] == pytest.approx([slope, 0.0], rel=1e-12, abs=1e-15)
    assert found.dB[:, 0, 0] == pytest.approx([-gain * slope, 1.0 - kept], rel=1e-12)
    assert found.dN[0, 0, 0] == pytest.approx(1.0 - kept - tau * slope, rel=1e-12)


def test_linear_input_by_hand() -> None:
    tau, gain, period = 0.5, 3.0, 0.1
    found = sample(lag(), np.array([tau, gain]), period, Hold.LINEAR)
    kept = math.exp(-period / tau)
    # the ramp response of a lag: t - tau (1 - exp(-t / tau))
    slope = gain * (period - tau * (1.0 - kept)) / period
    assert found.B[0] == pytest.approx([gain * (1.0 - kept) - slope, slope], rel=1e-12)


@pytest.mark.parametrize("hold", Hold)
@pytest.mark.parametrize("structure", STRUCTURES.values(), ids=lambda each: each.name)
def test_derivatives_are_those_of_differences(structure: Structure, hold: Hold) -> None:
    values = np.where(structure.values == 0.0, 0.7, structure.values)
    found = sample(structure, values, 0.01, hold)
    for index, value in enumerate(values):
        step = 1e-5 * abs(value)
        ahead, behind = values.copy(), values.copy()
        ahead[index] += step
        behind[index] -= step
        one, two = sample(structure, ahead, 0.01, hold), sample(structure, behind, 0.01, hold)
        for slope, high, low in (
            (found.dA, one.A, two.A),
            (found.dB, one.B, two.B),
            (found.dN, one.N, two.N),
        ):
            difference = (high - low) / (2.0 * step)
            size = max(float(np.max(np.abs(difference))), 1e-9)
            # the difference itself is rounded to about 1e-15 / step
            assert np.max(np.abs(slope[index] - difference)) < 2e-6 * size + 2e-14 / step


@given(seed=st.integers(0, 2**32 - 1), hold=st.sampled_from((Hold.ZERO, Hold.LINEAR)))
@settings(max_examples=20)
def test_two_half_periods_make_one(seed: int, hold: Hold) -> None:
    rng, structure = np.random.default_rng(seed), STRUCTURES["servo_rotor"]
    x, u = rng.standard_normal(8), rng.standard_normal((2, 2))
    if hold is Hold.ZERO:
        u[1] = u[0]
    middle = 0.5 * (u[0] + u[1])
    whole = sample(structure, structure.values, 0.02, hold)
    half = sample(structure, structure.values, 0.01, hold)

    def step(model: object, x: np.ndarray, now: np.ndarray, after: np.ndarray) -> np.ndarray:
        columns = now if hold is Hold.ZERO else np.concatenate((now, after))
        return model.A @ x + model.B @ columns

    twice = step(half, step(half, x, u[0], middle), middle, u[1])
    assert twice == pytest.approx(step(whole, x, u[0], u[1]), rel=1e-9, abs=1e-9)


def test_columns_of_a_linear_input() -> None:
    u = np.array([[1.0], [2.0], [4.0]])
    assert held_inputs(u, Hold.ZERO) is u
    assert held_inputs(u, Hold.LINEAR).tolist() == [[1.0, 2.0], [2.0, 4.0], [4.0, 4.0]]
    assert held_inputs(u, Hold.LATE).tolist() == [[1.0, 1.0], [2.0, 1.0], [4.0, 2.0]]


def test_a_late_input_is_held_on_a_grid_of_half_periods() -> None:
    """The voltage of the drive acts 5 ms after its stamp."""
    structure, period = STRUCTURES["drive"], 0.01
    u = np.random.default_rng(1).standard_normal((6, 1))
    late = sample(structure, structure.values, period, Hold.LATE)
    half = sample(structure, structure.values, 0.5 * period)
    x, fine = np.zeros(2), np.zeros(2)
    for now, before in zip(u[1:], u[:-1], strict=True):
        x = late.A @ x + late.B @ np.concatenate((now, before))
        fine = half.A @ fine + half.B @ before
        fine = half.A @ fine + half.B @ now
        assert x == pytest.approx(fine, rel=1e-12)
    constant = sample(structure, structure.values, period)
    assert pytest.approx(constant.N, rel=1e-12) == late.N and pytest.approx(constant.A, rel=1e-12) == late.A
