"""Discretisation: by hand, exact frequency warping, which method is nearer, and the phase that is lost."""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_control.discretisation import (
    discrete,
    discrete_anti_windup,
    discretised,
    phase_losses,
    response_error,
    sampled_response,
)
from heli_control.realisation import diagonal, first_order, gain, named, realisation, response
from heli_control.state_space import zero_order_hold

T = 0.01


def test_integrator_by_hand() -> None:
    integrator = first_order(0.0, 1.0, 0.0)
    omega = np.array([3.0])
    z = cmath.exp(3.0j * T)
    tustin = sampled_response(discrete(integrator, "tustin"), omega)[0, 0, 0]
    assert tustin == pytest.approx(T / 2 * (z + 1) / (z - 1), rel=1e-12)
    hold = sampled_response(discrete(integrator, "hold"), omega)[0, 0, 0]
    assert hold == pytest.approx(T / (z - 1), rel=1e-12)


@settings(deadline=None, max_examples=30, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_tustin_is_the_continuous_response_at_the_bent_frequency(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    system = realisation(
        10.0 * rng.standard_normal((n, n)), *(rng.standard_normal(size) for size in ((n, 2), (3, n), (3, 2)))
    )
    omega = np.array([0.3, 5.0, 25.0, 100.0])
    bent = 2.0 / T * np.tan(0.5 * omega * T)
    np.testing.assert_allclose(
        sampled_response(discrete(system, "tustin"), omega), response(system, bent), rtol=1e-7, atol=1e-9
    )


def test_hold_equivalent_is_the_exact_one() -> None:
    system = realisation([[0.0, 1.0], [-9.0, -1.0]], [[0.0], [2.0]], [[1.0, 0.0]], [[0.0]])
    sampled = discrete(system, "hold")
    a, b = zero_order_hold(system.A, system.B, T)
    np.testing.assert_allclose(sampled.A, a, atol=1e-14)
    np.testing.assert_allclose(sampled.B, b, atol=1e-14)


def test_tustin_is_nearer_to_a_controller_and_both_errors_are_those_of_the_formulas() -> None:
    lag = first_order(0.0, 8.0, 8.0)
    made = discretised(named(diagonal(lag, lag), ("a", "b"), ("c", "d"), "k"))
    assert made.method == "tustin"
    assert made.system.inputs == ("a", "b")
    assert made.system.outputs == ("c", "d")
    # half a period of the hold at 25 rad/s: 0.125 rad; the bent axis: (wT)^2 / 12 of |jw / (jw + 8)|
    assert made.errors["hold"] == pytest.approx(0.125, rel=0.05)
    assert made.errors["tustin"] == pytest.approx(0.25**2 / 12.0 * 25.0 / math.hypot(25.0, 8.0), rel=0.05)
    sampled = discrete(lag, "tustin")
    assert response_error(lag, sampled) == pytest.approx(made.errors["tustin"], rel=1e-9)


def test_hold_is_taken_where_tustin_does_not_exist() -> None:
    made = discretised(named(first_order(0.0, 1.0, -200.0), ("a",), ("b",), "k"))
    assert made.method == "hold"
    assert math.isinf(made.errors["tustin"])


def test_a_gain_stays_a_gain() -> None:
    made = discretised(named(gain([[2.0, 3.0]]), ("a", "b"), ("c",), "k"))
    assert made.system.states == ()
    np.testing.assert_array_equal(made.system.D, [[2.0, 3.0]])
    assert max(made.errors.values()) == 0.0


@pytest.mark.parametrize("method", ["tustin", "hold"])
def test_anti_windup_holds_a_limited_controller_where_the_continuous_one_stays(method: str) -> None:
    # an integrator with gain 2 asks for more than its limit of 1; E leads it back: x' = 2 in + 5 (1 - x)
    system = realisation([[0.0]], [[2.0]], [[1.0]], [[0.0]])
    sampled, e = discrete(system, method), discrete_anti_windup(system.A, np.array([[5.0]]), method)
    assert e[0, 0] == pytest.approx(5.0 * T)
    x = 0.0
    for _ in range(2000):
        asked = sampled.C[0, 0] * x + sampled.D[0, 0]
        x = sampled.A[0, 0] * x + sampled.B[0, 0] + e[0, 0] * (min(asked, 1.0) - asked)
    assert asked == pytest.approx(1.0 + 2.0 / 5.0, rel=1e-9)
    nothing = discrete_anti_windup(np.zeros((0, 0)), np.zeros((0, 2)), method)
    assert nothing.shape == (0, 2)


def test_phase_lost() -> None:
    rows = phase_losses(10.0)
    assert rows["sample"] == pytest.approx(math.degrees(0.05))
    assert rows["latency"] == pytest.approx(math.degrees(0.05))
    assert rows["frame"] == pytest.approx(math.degrees(0.05))
    assert rows["servo"] == pytest.approx(math.degrees(10.0 * 2.0 * 0.7 / (50.0 * math.pi)), rel=0.01)
    assert rows["all"] == pytest.approx(sum(value for name, value in rows.items() if name != "all"))
    # the mean of a hold is its phase exactly: (1 - e^-jwT) / jwT
    held = (1.0 - cmath.exp(-10.0j * 0.02)) / (10.0j * 0.02)
    assert rows["sample"] + rows["frame"] == pytest.approx(-math.degrees(cmath.phase(held)))


def test_bad_arguments_are_refused() -> None:
    lag = first_order(0.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="method 'euler'; allowed: tustin, hold"):
        discrete(lag, "euler")
    with pytest.raises(ValueError, match=r"period 0\.0 s; allowed"):
        discrete(lag, "hold", 0.0)
    with pytest.raises(ValueError, match=r"a pole at 2/T = 200 rad/s"):
        discrete(first_order(0.0, 1.0, -200.0), "tustin")
