"""Scaling, singular values, modes and zeros on models whose answers are known."""

import dataclasses

import numpy as np
import pytest

from heli_bench_sim.linear_analysis import (
    condition_numbers,
    frequency_response,
    modes,
    scaled,
    singular_values,
    transmission_zeros,
)
from heli_bench_sim.linearize import horizontal
from heli_bench_sim.parameters import constants, thesis
from heli_bench_sim.reference_results import SCALES
from heli_bench_sim.trim import trim
from heli_common.linear_model import StateSpace

FREQUENCIES = np.logspace(-2.0, 2.0, 41, dtype=np.float64)


def companion(zero: float, *, outputs: int = 1) -> StateSpace:
    """(s - zero) / ((s + 1) (s + 3)), and the same scaled in further outputs."""
    gains = np.arange(1.0, outputs + 1.0)[:, None]
    return StateSpace(
        ("a", "b"),
        ("f",),
        tuple(f"y{index}" for index in range(outputs)),
        np.array([[0.0, 1.0], [-3.0, -4.0]]),
        np.array([[0.0], [1.0]]),
        gains * np.array([[-zero, 1.0]]),
        np.zeros((outputs, 1)),
    )


def test_frequency_response_of_a_known_system() -> None:
    model = companion(-2.0, outputs=2)
    s = 1j * FREQUENCIES
    exact = (s + 2.0) / ((s + 1.0) * (s + 3.0))
    response = frequency_response(model, FREQUENCIES)
    assert response[:, 0, 0] == pytest.approx(exact)
    assert response[:, 1, 0] == pytest.approx(2.0 * exact)
    values = singular_values(model, FREQUENCIES)
    assert values[:, 0] == pytest.approx(np.sqrt(5.0) * np.abs(exact))
    assert condition_numbers(values) == pytest.approx(1.0)


def test_singular_values_of_a_diagonal_plant() -> None:
    model = StateSpace(
        ("a", "b"), ("f", "g"), ("a", "b"), -np.diag([1.0, 2.0]), np.eye(2), np.eye(2), np.zeros((2, 2))
    )
    values = singular_values(model, FREQUENCIES)
    assert values[:, 0] == pytest.approx(1.0 / np.hypot(1.0, FREQUENCIES))
    assert values[:, 1] == pytest.approx(1.0 / np.hypot(2.0, FREQUENCIES))


def test_scaling_changes_neither_poles_nor_the_physics() -> None:
    parameters = thesis()
    plain = horizontal(parameters, trim(parameters))
    small = scaled(plain, SCALES)
    assert small.poles == pytest.approx(plain.poles)
    out = np.array([SCALES[name] for name in plain.outputs])
    into = np.array([SCALES[name] for name in plain.inputs])
    assert frequency_response(small, FREQUENCIES) * out[:, None] / into == pytest.approx(
        frequency_response(plain, FREQUENCIES)
    )


@pytest.mark.parametrize("scales", [{"a": 1.0, "b": 1.0}, {"a": 1.0, "b": 0.0, "f": 1.0, "y0": 1.0}])
def test_a_missing_or_vanishing_scale_is_refused(scales: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"scale of '(f|b)' is"):
        scaled(companion(1.0), scales)


def test_modes() -> None:
    parameters = thesis()
    model = scaled(horizontal(parameters, trim(parameters)), SCALES)
    found = modes(model)
    assert np.sort_complex([mode.pole for mode in found]) == pytest.approx(np.sort_complex(model.poles))
    assert [abs(mode.pole) for mode in found] == sorted((abs(mode.pole) for mode in found), reverse=True)
    for mode in found:
        assert model.A @ mode.shape == pytest.approx(mode.pole * mode.shape, abs=1e-10)
        assert np.linalg.norm(mode.shape) == pytest.approx(1.0)
        assert mode.shape[np.abs(mode.shape).argmax()].real == pytest.approx(np.abs(mode.shape).max())
    named = [model.states[np.abs(mode.shape).argmax()] for mode in found[:4:2]]
    assert named == ["p", "q"]  # source sec. 2.4.2: the fastest pair is roll, the next one pitch
    for mode in found[4:]:
        assert {model.states[i] for i in np.argsort(np.abs(mode.shape))[-2:]} == {"u", "v"}


def test_participation_does_not_depend_on_units() -> None:
    parameters = thesis()
    plain = horizontal(parameters, trim(parameters))
    for one, other in zip(modes(plain), modes(scaled(plain, SCALES)), strict=True):
        assert one.participation == pytest.approx(other.participation)


@pytest.mark.parametrize("outputs", [1, 3])
@pytest.mark.parametrize("zero", [-2.0, 0.5])
def test_a_known_zero(zero: float, outputs: int) -> None:
    assert transmission_zeros(companion(zero, outputs=outputs)) == pytest.approx(np.array([zero]))


def test_an_output_more_takes_a_zero_away() -> None:
    seen = dataclasses.replace(companion(-2.0, outputs=2), C=np.array([[2.0, 1.0], [1.0, 0.0]]))
    assert transmission_zeros(seen).size == 0


def test_zeros_of_the_helicopter_are_where_bar_and_plate_cancel() -> None:
    parameters = thesis()
    rate = constants(parameters).bar_rate * parameters.rotor_speed
    zero = -rate * (1.0 + parameters.plate_to_bar * parameters.bar_to_blade / parameters.plate_to_blade)
    found = transmission_zeros(scaled(horizontal(parameters, trim(parameters)), SCALES))
    assert found == pytest.approx(np.array([zero, zero]), rel=1e-6)


def test_more_inputs_than_outputs_are_refused() -> None:
    model = companion(1.0)
    wide = StateSpace(model.states, ("f", "g"), ("y",), model.A, np.eye(2), model.C, np.zeros((1, 2)))
    with pytest.raises(ValueError, match="1 outputs are fewer than 2 inputs"):
        transmission_zeros(wide)
