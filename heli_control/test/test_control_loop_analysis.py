from __future__ import annotations

import math

import numpy as np
import pytest

from heli_common.linear_model import StateSpace
from heli_control.loop_analysis import crossovers, frequency_response, sensitivity_peaks

OMEGA = np.geomspace(1e-3, 1e3, 4000)


def siso(a: float, b: float) -> StateSpace:
    one = np.ones((1, 1))
    return StateSpace(("x",), ("u",), ("y",), a * one, b * one, one, 0.0 * one)


def test_integrator_crosses_at_its_gain_and_has_no_peak() -> None:
    response = frequency_response(siso(0.0, 5.0), OMEGA)
    np.testing.assert_allclose(response[:, 0, 0], 5.0 / (1j * OMEGA))
    assert crossovers(response[:, 0, 0], OMEGA) == pytest.approx([5.0], rel=1e-4)
    assert sensitivity_peaks(response) == pytest.approx((0.0, 0.0), abs=1e-3)


def test_sampled_integrator_on_the_unit_circle() -> None:
    omega = np.array([0.5, 7.0])
    response = frequency_response(siso(1.0, 0.1), omega, 0.1)[:, 0, 0]
    np.testing.assert_allclose(response, 0.1 / (np.exp(0.1j * omega) - 1.0))


def test_peak_of_a_second_order_loop() -> None:
    # L = 1 / (s (s + 2 zeta)) closes to T = 1 / (s^2 + 2 zeta s + 1) with peak 1 / (2 zeta sqrt(1 - zeta^2))
    zeta = 0.2
    loop = (1.0 / (1j * OMEGA * (1j * OMEGA + 2.0 * zeta)))[:, None, None]
    expected = 20.0 * math.log10(1.0 / (2.0 * zeta * math.sqrt(1.0 - zeta**2)))
    assert sensitivity_peaks(loop)[1] == pytest.approx(expected, abs=1e-3)


def test_band_pass_crosses_twice_and_a_small_gain_never() -> None:
    band_pass = 10.0 * 1j * OMEGA / ((1j * OMEGA) ** 2 + 11.0 * 1j * OMEGA + 10.0)
    assert crossovers(2.0 * band_pass, OMEGA) == pytest.approx([0.58, 17.2], rel=0.01)
    assert crossovers(0.5 * band_pass, OMEGA) == []
