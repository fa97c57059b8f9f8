"""Poles with their scatter: by hand, against differences, against random draws."""

import numpy as np
import pytest
from closed_loop_data import TRUTH

from heli_identification.pole_uncertainty import uncertain_poles
from heli_identification.structures import Parameter, Structure, Term


def oscillator(damping: float, stiffness: float) -> Structure:
    """x'' = -damping x' - stiffness x + u."""
    parameters = (
        Parameter("d", damping, 1.0, "1/s"),
        Parameter("s", stiffness, 1.0, "1/s^2"),
    )
    terms = (
        Term("x", "v", 1.0),
        Term("v", "v", -1.0, (("d", 1),)),
        Term("v", "x", -1.0, (("s", 1),)),
        Term("v", "u", 1.0),
    )
    return Structure("oscillator", ("x", "v"), ("u",), ("x",), parameters, terms, (("d", "s"),))


def test_an_oscillator_by_hand() -> None:
    """-d/2 +- i sqrt(s - d^2/4): real part by d alone; with d zero the imaginary one by s, 1/(2 w)."""
    found = uncertain_poles(oscillator(0.0, 25.0), np.diag([0.04, 1.0]))
    assert found.values == pytest.approx([5j, -5j])
    assert found.covariance[0] == pytest.approx(np.diag([0.01, 0.01]))
    ring = found.ellipse(0) - 5j
    assert np.abs(ring) == pytest.approx(0.1 * np.sqrt(5.991464547), rel=1e-6)


def test_real_poles_scatter_along_a_line() -> None:
    found = uncertain_poles(oscillator(5.0, 4.0), np.diag([0.01, 0.0]))
    assert found.values == pytest.approx([-4.0, -1.0])
    # lambda^2 + d lambda + s = 0:  d lambda / d d = -lambda / (2 lambda + d)
    assert found.covariance[0, 0, 0] == pytest.approx((0.1 * 4.0 / -3.0) ** 2)
    assert not found.covariance[:, 1].any()
    ring = found.ellipse(0)
    assert not ring.imag.any() and np.max(ring.real) + 4.0 == pytest.approx(1.959964 * 0.4 / 3.0, rel=1e-5)


def test_the_helicopter_against_random_draws() -> None:
    rng = np.random.default_rng(1)
    index = TRUTH.index(TRUTH.free_names)
    deviation = 0.01 * np.abs(TRUTH.values[index])
    found = uncertain_poles(TRUTH, np.diag(deviation**2))
    fast = TRUTH.model().poles[0]
    assert found.values[0] == pytest.approx(fast)
    drawn = []
    for _ in range(400):
        moved = TRUTH.values.copy()
        moved[index] += deviation * rng.standard_normal(len(index))
        poles = TRUTH.model(moved).poles
        drawn.append(poles[np.argmin(np.abs(poles - fast))])
    parts = np.array([np.real(drawn), np.imag(drawn)])
    assert np.cov(parts) == pytest.approx(found.covariance[0], rel=0.2, abs=0.002)


def test_a_blind_coefficient_counts_as_known() -> None:
    found = uncertain_poles(oscillator(0.0, 25.0), np.diag([np.inf, 1.0]))
    assert np.all(np.isfinite(found.covariance)) and found.covariance[0, 0, 0] == 0.0
