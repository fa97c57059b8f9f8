from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.linear_model import StateSpace
from heli_common.rotations import Euler
from heli_common.vehicle_state import VehicleState
from heli_control.controller_file import ControllerAxis, ControllerFile, load_controller
from heli_control.flight_law import FlightLaw, settling_maps

LQ = load_controller("lq")
POINT = LQ.operating_point
TRIM = np.array([POINT.B_1s, POINT.A_1s, POINT.theta_0, POINT.theta_t])
ZERO = (0.0, 0.0, 0.0)
HOVER = VehicleState(ZERO, Euler(0.0, POINT.theta, POINT.phi), ZERO, ZERO)
SINKING = HOVER._replace(velocity=(0.0, 0.0, 0.1))


def axis(
    a: list[list[float]],
    b: list[list[float]],
    c: list[list[float]],
    d: list[list[float]],
    e: list[list[float]],
) -> ControllerAxis:
    """Of w and r to collective and tail."""
    states = tuple(f"x_{index}" for index in range(len(a)))
    system = StateSpace(
        states, ("w", "r"), ("theta_0", "theta_t"), np.array(a), np.array(b), np.array(c), np.array(d)
    )
    return ControllerAxis(system, np.array(e))


INTEGRAL = axis(
    [[1.0, 0.0], [0.0, 1.0]], [[0.01, 0.0], [0.0, 0.02]], [[1.0, 0.0], [0.0, 1.0]],
    [[0.5, 0.0], [0.0, 0.3]], [[0.1, 0.0], [0.0, 0.2]],
)  # fmt: skip


def with_vertical(vertical: ControllerAxis) -> ControllerFile:
    return replace(LQ, vertical=vertical)


def test_an_integral_goes_on_by_what_was_applied() -> None:
    law = FlightLaw(with_vertical(INTEGRAL))
    asked = law.step(SINKING, ZERO, 0.0)
    assert asked[2] == pytest.approx(POINT.theta_0 + 0.05)
    applied = [*asked[:2], POINT.theta_0 + 0.02, asked[3]]
    law.follow(applied)
    # 0.01 * 0.1 of the integral, and 0.1 of the 0.03 that were cut off
    assert law.step(SINKING, ZERO, 0.0)[2] == pytest.approx(POINT.theta_0 + 0.05 + 0.001 - 0.003)


def test_an_integral_does_not_run_away_at_a_limit() -> None:
    law, deaf = FlightLaw(with_vertical(INTEGRAL)), FlightLaw(with_vertical(INTEGRAL))
    for _ in range(1000):
        asked = law.step(SINKING, ZERO, 0.0)
        law.follow([*asked[:2], POINT.theta_0 + 0.02, asked[3]])
        deaf.step(SINKING, ZERO, 0.0)
    # at rest E (applied - asked) = -0.01 w: the integral asks for 0.01 more than is applied
    assert asked[2] == pytest.approx(POINT.theta_0 + 0.02 + 0.01)
    assert deaf.step(SINKING, ZERO, 0.0)[2] == pytest.approx(POINT.theta_0 + 1.05)


def test_an_integral_is_settled_on_the_command() -> None:
    law = FlightLaw(with_vertical(INTEGRAL))
    wanted = [*TRIM[:2], POINT.theta_0 + 0.07, POINT.theta_t - 0.04]
    law.settle(SINKING, ZERO, 0.0, wanted)
    assert law.step(SINKING, ZERO, 0.0)[2:] == pytest.approx(wanted[2:], abs=1e-15)
    # then only the integral moves on
    assert law.step(SINKING, ZERO, 0.0)[2] == pytest.approx(wanted[2] + 0.001)


def test_two_lags_in_one_output_are_settled_nearest_to_rest() -> None:
    # x_0+ = 0.5 x_0, x_1+ = 0.9 x_1, both add up to the collective: minimise 0.25 x_0^2 + 0.01 x_1^2 with
    # x_0 + x_1 = 0.26, so x_0 = 0.01 and x_1 = 0.25
    lags = axis([[0.5, 0.0], [0.0, 0.9]], [[0.0, 0.0]] * 2, [[1.0, 1.0], [0.0, 0.0]], [[0.0, 0.0]] * 2,
                [[0.0, 0.0]] * 2)  # fmt: skip
    law = FlightLaw(with_vertical(lags))
    law.settle(HOVER, ZERO, 0.0, [*TRIM[:2], POINT.theta_0 + 0.26, POINT.theta_t])
    asked = [law.step(HOVER, ZERO, 0.0)[2] - POINT.theta_0 for _ in range(2)]
    assert asked == pytest.approx([0.26, 0.5 * 0.01 + 0.9 * 0.25], abs=1e-14)


def test_lq_is_settled_on_a_command_that_it_would_not_give() -> None:
    law = FlightLaw(LQ)
    law.settle(SINKING, ZERO, 0.0, TRIM)
    assert law.step(SINKING, ZERO, 0.0) == pytest.approx(TRIM, abs=1e-14)


def test_a_gain_cannot_be_settled() -> None:
    gain = ControllerAxis(
        StateSpace((), ("w",), ("theta_0", "theta_t"), np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((2, 0)),
                   np.array([[0.5], [0.0]])),
        np.zeros((0, 2)),
    )  # fmt: skip
    law = FlightLaw(with_vertical(gain))
    law.settle(SINKING, ZERO, 0.0, TRIM)
    assert law.step(SINKING, ZERO, 0.0)[2] == pytest.approx(POINT.theta_0 + 0.05)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_settling_is_the_least_squares_solution(seed: int, n: int) -> None:
    """Twin: the constrained problem as one with a very heavy weight on the output."""
    rng = np.random.default_rng(seed)
    a = rng.standard_normal((n, n))
    a *= rng.uniform(0.2, 1.0) / np.abs(np.linalg.eigvals(a)).max()
    b, c, d = rng.standard_normal((n, 2)), rng.standard_normal((2, n)), rng.standard_normal((2, 2))
    law = axis(a.tolist(), b.tolist(), c.tolist(), d.tolist(), np.zeros((n, 2)).tolist())
    by_output, by_input = settling_maps(law)
    command, inputs = rng.standard_normal(2), rng.standard_normal(2)
    x = by_output @ (command - d @ inputs) + by_input @ inputs
    if n >= 2:
        np.testing.assert_allclose(c @ x + d @ inputs, command, atol=1e-8 * (1.0 + np.abs(x).max()))
    drift = a - np.eye(n)
    size = np.linalg.norm(drift @ x + b @ inputs)
    _, _, right = np.linalg.svd(c)
    for direction in right[2:]:  # what the output does not see
        for step in (1e-4, -1e-4):
            assert np.linalg.norm(drift @ (x + step * direction) + b @ inputs) >= size - 1e-10
