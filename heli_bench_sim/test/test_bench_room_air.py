"""Air of the room: by hand, scaled with the rotor's flow, and its statistics at any step."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import chi2

from heli_bench_sim.room_air import (
    GUSTY_ROOM,
    ROOM_NORMALS,
    ROOM_STATE_SIZE,
    RoomAirParameters,
    RoomConstants,
    room_advance,
    room_constants,
    room_gust,
)
from heli_common.compiled import compiled

HOVER = 4.222
STRENGTHS = np.array([1.0, 1.0, 0.3, 0.3])
C = room_constants(RoomAirParameters(1.0, 1.5, *STRENGTHS.tolist()), HOVER)
RARE = 1e-5
"""Chance that a right model fails one chi-square test; the seeds are fixed all the same."""
Array = NDArray[np.float64]


@compiled
def stir(state: Array, v_i: float, normals: Array, period: float, c: RoomConstants, out: Array) -> None:
    """Gusts after each step."""
    for step in range(normals.shape[0]):
        room_advance(state, normals[step], period, c)
        room_gust(state, v_i, c, out[step])


def stirred(normals: Array, period: float, v_i: float = HOVER) -> Array:
    out = np.empty((len(normals), 4))
    stir(np.zeros(ROOM_STATE_SIZE), v_i, normals, period, C, out)
    return out


def gust(state: Array, v_i: float, c: RoomConstants = C) -> Array:
    out = np.full(4, np.nan)
    room_gust(state, v_i, c, out)
    return out


def test_by_hand() -> None:
    state = np.array([1.0, -1.0, 2.0, 0.5])
    assert gust(state, HOVER) == pytest.approx([1.0, -1.0, 0.6, 0.15], rel=1e-14)
    assert gust(state, 0.5 * HOVER) == pytest.approx([0.5, -0.5, 0.3, 0.075], rel=1e-14)


def test_step_by_hand() -> None:
    """Half as strong after 1.5 ln 2 s; then three quarters of the variance are new."""
    state, normals = np.array([1.0, 2.0, -4.0, 0.0]), np.zeros(ROOM_NORMALS)
    room_advance(state, normals, 1.5 * math.log(2.0), C)
    assert state == pytest.approx([0.5, 1.0, -2.0, 0.0], rel=1e-14)
    room_advance(state, np.array([0.0, 1.0, 0.0, -2.0]), 1.5 * math.log(2.0), C)
    root = math.sqrt(0.75)
    assert state == pytest.approx([0.25, 0.5 + root, -1.0, -2.0 * root], rel=1e-14)


@settings(deadline=None, max_examples=50)
@given(st.lists(st.floats(-4.0, 4.0), min_size=4, max_size=4), st.floats(0.0, 10.0))
def test_gust_goes_with_the_rotors_flow(state: list[float], v_i: float) -> None:
    array = np.array(state)
    assert gust(array, v_i) == pytest.approx(v_i / HOVER * gust(array, HOVER), rel=1e-12, abs=1e-15)
    assert np.abs(gust(array, -v_i)).tolist() == [0.0] * 4
    assert gust(-array, v_i).tolist() == (-gust(array, v_i)).tolist()


def test_default_room_is_still() -> None:
    still = room_constants(RoomAirParameters(), HOVER)
    assert gust(np.array([1.0, 2.0, 3.0, 4.0]), HOVER, still).tolist() == [0.0] * 4


@pytest.mark.parametrize("inflow", [0.0, -1.0, math.nan, math.inf])
def test_hover_without_inflow_is_refused(inflow: float) -> None:
    with pytest.raises(ValueError, match="must be positive") as caught:
        room_constants(GUSTY_ROOM, inflow)
    assert repr(inflow) in str(caught.value)


def test_answer_to_one_number_is_the_whole_correlation() -> None:
    """Without chance: sum of squares 1 and correlation exp(-t / 1.5 s), at either step."""
    for period in (0.0025, 0.01):
        normals = np.zeros((round(30.0 / period), ROOM_NORMALS))
        normals[0] = 1.0
        answer = stirred(normals, period) / STRENGTHS
        for lag in (0, 1, round(0.75 / period), round(1.5 / period)):
            found = np.sum(answer[: len(answer) - lag] * answer[lag:], axis=0)
            assert found == pytest.approx([math.exp(-lag * period / 1.5)] * 4, abs=1e-12)


@pytest.mark.parametrize("period", [0.0025, 0.01])
def test_strength_and_correlation_time_at_any_step(period: float) -> None:
    """Chi-square on the variance, with N / sum(correlation^2) samples, and on what is new after 1.5 s."""
    steps = round(4000.0 / period)
    normals = np.random.default_rng([5, round(period * 1e4)]).standard_normal((steps, ROOM_NORMALS))
    found = stirred(normals, period)[round(15.0 / period) :] / STRENGTHS
    kept = math.exp(-period / 1.5)
    independent = len(found) * (1.0 - kept**2) / (1.0 + kept**2)
    low, high = chi2.ppf([RARE / 2.0, 1.0 - RARE / 2.0], independent)
    assert high < 1.3 * low  # sharp enough to tell
    squares = independent * np.mean(found**2, axis=0)
    assert ((low < squares) & (squares < high)).all()

    apart = found[:: round(1.5 / period)]
    fresh = (apart[1:] - math.exp(-1.0) * apart[:-1]) / math.sqrt(1.0 - math.exp(-2.0))
    low, high = chi2.ppf([RARE / 2.0, 1.0 - RARE / 2.0], len(fresh))
    squares = np.sum(fresh**2, axis=0)
    assert ((low < squares) & (squares < high)).all()
    along = np.sum(fresh[1:] * fresh[:-1], axis=0) / math.sqrt(len(fresh))
    assert np.abs(along).max() < 5.0  # what is new is white: the gust is Markov
    cross = np.corrcoef(fresh.T)[np.triu_indices(4, 1)]
    assert np.abs(cross).max() < 5.0 / math.sqrt(len(fresh))


def test_a_flight_begins_in_still_air() -> None:
    """Over 500 flights the variance after t is 1 - exp(-2 t / 1.5 s), exactly chi-square."""
    rng = np.random.default_rng(11)
    flights = [stirred(rng.standard_normal((60, ROOM_NORMALS)), 0.01) / STRENGTHS for _ in range(500)]
    for step in (1, 10, 60):
        values = np.array([flight[step - 1] for flight in flights])
        squares = np.sum(values**2) / (1.0 - math.exp(-2.0 * step * 0.01 / 1.5))
        low, high = chi2.ppf([RARE / 2.0, 1.0 - RARE / 2.0], values.size)
        assert low < squares < high


def test_same_numbers_same_air() -> None:
    normals = np.random.default_rng(3).standard_normal((1000, ROOM_NORMALS))
    assert stirred(normals, 0.01).tobytes() == stirred(normals.copy(), 0.01).tobytes()
    other = np.random.default_rng(4).standard_normal((1000, ROOM_NORMALS))
    assert stirred(normals, 0.01).tobytes() != stirred(other, 0.01).tobytes()
