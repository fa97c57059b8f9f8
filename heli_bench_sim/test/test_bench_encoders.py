"""Encoders: counts from power-up, index pulses, absolute counts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from heli_bench_sim.encoders import (
    INDEX_OFFSET,
    Counter,
    EncoderReading,
    count,
    follow,
    power_up,
    whole_counts,
)

Array = NDArray[np.float64]
REST = np.radians([29.016, 29.016, 29.016, 0.0, 0.0, 0.0])
COUNT = 2.0 * math.pi / 2000.0
SIX = st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6)


class Encoders:
    """Six encoders that are switched on at some angles and then turned."""

    def __init__(self, angles: Array, rest: Array) -> None:
        self.counters = power_up(angles, rest)

    def sample(self, angles: Array) -> None:
        follow(angles, self.counters)

    @property
    def reading(self) -> EncoderReading:
        counts = np.array([count(encoder, self.counters) for encoder in range(6)])
        return EncoderReading(counts, self.counters[Counter.indexed] != 0)


def test_counts_by_hand() -> None:
    """0.18 deg per count, to the nearest."""
    assert whole_counts(np.radians([0.0, 0.09, 0.0899, -0.0899, 0.36, -0.36])).tolist() == [0, 1, 0, 0, 2, -2]


def test_power_up_reads_zero_and_is_not_indexed() -> None:
    encoders = Encoders(REST, REST)
    assert encoders.reading.counts.tolist() == [0] * 6
    assert not encoders.reading.indexed.any()


def test_relative_before_the_index_absolute_after() -> None:
    encoders = Encoders(REST, REST)
    encoders.sample(REST + math.radians(3.6))
    assert encoders.reading.counts.tolist() == [20, 20, 20, 20, 20, 20]
    moved = REST.copy()
    moved[0] += math.radians(7.2)
    encoders.sample(moved)
    assert encoders.reading.indexed.tolist() == [True] + [False] * 5
    assert encoders.reading.counts[0] == round(math.degrees(moved[0]) / 0.18)
    encoders.sample(REST)
    assert encoders.reading.indexed[0]
    assert encoders.reading.angle[0] == pytest.approx(REST[0], abs=0.5 * COUNT)


def test_index_is_crossed_from_either_side_and_only_by_crossing() -> None:
    above = REST + INDEX_OFFSET + math.radians(1.0)
    encoders = Encoders(above, REST)
    encoders.sample(above + 1.0)
    assert not encoders.reading.indexed.any()
    encoders.sample(REST)
    assert encoders.reading.indexed.all()


@settings(deadline=None, max_examples=50)
@given(
    st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6), st.lists(st.floats(-3, 3), min_size=6, max_size=6)
)
def test_reading_is_within_half_a_count_once_indexed_and_one_before(
    start: list[float], end: list[float]
) -> None:
    first, last = np.array(start), np.array(end)
    encoders = Encoders(first, first)
    encoders.sample(last)
    reading = encoders.reading
    truth = np.where(reading.indexed, last, last - first)
    assert (np.abs(reading.angle - truth) <= np.where(reading.indexed, 0.5, 1.0) * COUNT + 1e-12).all()


def test_angles_that_are_no_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="nan"):
        power_up(np.array([math.nan] * 6), REST)
    with pytest.raises(ValueError, match="6 finite"):
        power_up(REST, np.zeros(5))


@settings(deadline=None, max_examples=50)
@given(SIX)
def test_compiled_counts_are_whole_counts(angles: list[float]) -> None:
    turned = np.array(angles)
    encoders = Encoders(REST, REST)
    encoders.sample(turned)
    assert (encoders.counters[Counter.line] == whole_counts(turned)).all()
