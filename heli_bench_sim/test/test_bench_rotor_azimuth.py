"""Azimuth of the rotor: turning by hand, wrapping, many steps against the closed formula."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_bench_sim.rotor_azimuth import turned

TURN = 2.0 * math.pi
AZIMUTH = st.floats(0.0, TURN, exclude_max=True)
SPEED = st.floats(-500.0, 500.0)


def apart(one: float, other: float) -> float:
    """Distance of two azimuths the short way round."""
    return abs(math.remainder(one - other, TURN))


def test_by_hand() -> None:
    assert turned(1.0, 100.0, 200.0, 0.01) == pytest.approx(2.5, rel=1e-15)
    assert turned(6.0, 100.0, 100.0, 0.01) == pytest.approx(7.0 - TURN, rel=1e-14)
    assert turned(1.0, -200.0, -200.0, 0.01) == pytest.approx(TURN - 1.0, rel=1e-15)
    assert turned(1.25, 0.0, 0.0, 0.01) == 1.25


@pytest.mark.parametrize("speed", [-1e-300, -1e-18, -1e-16, 0.0, 1e-16])
def test_never_a_whole_turn(speed: float) -> None:
    assert 0.0 <= turned(0.0, speed, speed, 1.0) < TURN


@settings(deadline=None, max_examples=200)
@given(AZIMUTH, SPEED, SPEED, st.floats(0.0, 1.0))
def test_within_a_turn_there_and_back(azimuth: float, before: float, after: float, period: float) -> None:
    there = turned(azimuth, before, after, period)
    back = turned(there, -after, -before, period)
    assert 0.0 <= there < TURN
    assert 0.0 <= back < TURN
    assert apart(back, azimuth) < 1e-12


def test_run_up_in_steps_is_the_closed_formula() -> None:
    """Constant acceleration: half of it times the square of time."""
    azimuth, period, acceleration = 0.0, 0.0025, 40.0
    for step in range(1, 1601):
        azimuth = turned(azimuth, acceleration * (step - 1) * period, acceleration * step * period, period)
        closed = 0.5 * acceleration * (step * period) ** 2
        assert apart(azimuth, closed) < 1e-11
    assert closed > 50.0 * TURN
