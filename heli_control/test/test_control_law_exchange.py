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
from heli_control.flight_law import FlightLaw
from heli_control.law_exchange import LawExchange

LQ = load_controller("lq")
POINT = LQ.operating_point
ZERO = (0.0, 0.0, 0.0)
HOVER = VehicleState(ZERO, Euler(0.0, POINT.theta, POINT.phi), ZERO, ZERO)
INPUTS = {"horizontal": ("theta", "phi", "u", "v", "u_ref"), "vertical": ("w", "r", "r_ref")}
OUTPUTS = {"horizontal": ("B_1s", "A_1s"), "vertical": ("theta_0", "theta_t")}
STEP = 0.02


def free(command: list[float]) -> list[float]:
    return list(command)


def constant(collective: float) -> FlightLaw:
    """Asks for the trim and so much collective, whatever happens."""
    return FlightLaw(replace(LQ, operating_point=replace(POINT, theta_0=collective)))


def random_controller(rng: np.random.Generator) -> ControllerFile:
    """Stable, with another operating point."""

    def axis(name: str) -> ControllerAxis:
        n, m = int(rng.integers(2, 9)), len(INPUTS[name])
        a = rng.standard_normal((n, n))
        a *= rng.uniform(0.3, 0.99) / np.abs(np.linalg.eigvals(a)).max()
        b, c, d = (0.3 * rng.standard_normal(shape) for shape in ((n, m), (2, n), (2, m)))
        states = tuple(f"x_{index}" for index in range(n))
        system = StateSpace(states, INPUTS[name], OUTPUTS[name], a, b, c, d)
        return ControllerAxis(system, np.zeros((n, 2)))

    theta_0 = POINT.theta_0 + 0.01 * rng.standard_normal()
    point = replace(POINT, theta_0=float(theta_0))
    return replace(LQ, operating_point=point, horizontal=axis("horizontal"), vertical=axis("vertical"))


def test_two_laws_at_rest_exchange_linearly() -> None:
    # LQ feeds its own past commands back, which are not those it asks for: take them away
    def still(collective: float) -> FlightLaw:
        def gain(axis: ControllerAxis) -> ControllerAxis:
            m = len(axis.system.inputs)
            empty = (np.zeros((0, 0)), np.zeros((0, m)), np.zeros((2, 0)), np.zeros((2, m)))
            return ControllerAxis(
                StateSpace((), axis.system.inputs, axis.system.outputs, *empty), np.zeros((0, 2))
            )

        point = replace(POINT, theta_0=collective)
        return FlightLaw(
            replace(LQ, operating_point=point, horizontal=gain(LQ.horizontal), vertical=gain(LQ.vertical))
        )

    laws = LawExchange(still(0.1), 0.25, free)
    assert laws.step(HOVER, ZERO, 0.0)[2] == pytest.approx(0.1)
    laws.replace(still(0.2))
    flown = []
    for _ in range(6):
        flown.append(laws.step(HOVER, ZERO, 0.0))
        laws.follow(flown[-1])
    assert [command[2] for command in flown] == pytest.approx([0.125, 0.15, 0.175, 0.2, 0.2, 0.2])
    # a third one half way: what was flown until then, 0.15, fades
    laws.replace(still(0.1))
    for _ in range(2):
        laws.follow(laws.step(HOVER, ZERO, 0.0))
    laws.replace(still(0.35))
    flown = []
    for _ in range(5):
        flown.append(laws.step(HOVER, ZERO, 0.0))
        laws.follow(flown[-1])
    assert [command[2] for command in flown] == pytest.approx([0.2, 0.25, 0.3, 0.35, 0.35])


def test_the_last_of_two_that_come_in_one_sample_flies() -> None:
    laws = LawExchange(constant(0.16), STEP, free)
    laws.step(HOVER, ZERO, 0.0)
    laws.replace(constant(0.17))
    laws.replace(constant(0.165))
    for _ in range(120):
        laws.follow(laws.step(HOVER, ZERO, 0.0))
    assert laws.law.trim[2] == 0.165
    assert laws.step(HOVER, ZERO, 0.0)[2] == pytest.approx(0.165, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_no_command_jumps_when_another_controller_comes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = random_controller(rng), random_controller(rng)
    state = HOVER._replace(
        attitude=Euler(0.0, *(0.05 * rng.standard_normal(2))),
        velocity=tuple(0.1 * rng.standard_normal(3)),
        rates=tuple(0.1 * rng.standard_normal(3)),
    )
    velocity, yaw_rate = tuple(0.1 * rng.standard_normal(3)), 0.1
    alone, laws = FlightLaw(first), LawExchange(FlightLaw(first), STEP, free)
    for _ in range(5):
        assert laws.step(state, velocity, yaw_rate) == alone.step(state, velocity, yaw_rate)
    laws.replace(FlightLaw(second))
    before = alone.step(state, velocity, yaw_rate)
    np.testing.assert_allclose(laws.step(state, velocity, yaw_rate), before, atol=1e-9)
    twin = FlightLaw(second)
    twin.settle(state, velocity, yaw_rate, before)
    twin.step(state, velocity, yaw_rate)
    for _ in range(60):
        flown, wanted = laws.step(state, velocity, yaw_rate), twin.step(state, velocity, yaw_rate)
        laws.follow(flown)
    np.testing.assert_allclose(flown, wanted, rtol=1e-9)
