"""What counts say: lines passed, cells, by hand and against chance."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_navigation.encoder_cells import beyond_cell, cell_innovation_variance, line_of, passed
from heli_navigation.filter_parameters import FilterParameters, filter_constants

C = filter_constants(FilterParameters(), RigGeometry())
COUNT = RADIAN_PER_COUNT


def test_by_hand() -> None:
    assert line_of(7.0 * COUNT, C) == 7.0
    assert line_of(-3.0 * COUNT, C) == -3.0
    # slowly over the line between 4 and 5
    angle, variance = passed(5.0, 4.0, 0.0, C)
    assert angle == pytest.approx(4.5 * COUNT)
    assert variance == pytest.approx((0.01 * COUNT) ** 2)
    # the same line backwards, a tenth of a count a sample
    rate = -0.1 * COUNT / C.period
    angle, variance = passed(4.0, 5.0, rate, C)
    assert angle == pytest.approx(4.45 * COUNT)
    assert variance == pytest.approx((0.1 * COUNT) ** 2 / 12.0 + C.line_variance)
    # a rate that goes the other way says only that the line was just passed
    assert passed(5.0, 4.0, rate, C)[0] == pytest.approx(4.5 * COUNT)
    # faster than a count a sample: somewhere in the new cell
    angle, variance = passed(9.0, 4.0, 5.0 * COUNT / C.period, C)
    assert angle == pytest.approx(9.0 * COUNT)
    assert variance == pytest.approx(C.cell_variance + C.line_variance)


@settings(deadline=None, max_examples=50)
@given(st.floats(-400.0, 400.0))
def test_an_angle_is_within_its_own_cell(counts: float) -> None:
    angle = counts * COUNT
    assert beyond_cell(angle, line_of(angle, C), C) == pytest.approx(0.0, abs=1e-12)


def test_beyond_a_cell() -> None:
    assert beyond_cell(5.7 * COUNT, 5.0, C) == pytest.approx(0.2 * COUNT)
    assert beyond_cell(4.2 * COUNT, 5.0, C) == pytest.approx(-0.3 * COUNT)
    assert beyond_cell(5.4 * COUNT, 5.0, C) == 0.0


@settings(deadline=None, max_examples=50)
@given(st.floats(1.001, 1e6))
def test_a_cell_leaves_what_a_cell_tells(times: float) -> None:
    variance = times * C.cell_variance
    left = variance - variance**2 / cell_innovation_variance(variance, C)
    assert left == pytest.approx(C.cell_variance, rel=1e-6)


@pytest.mark.parametrize("speed", [0.03, 0.3, 0.9])
def test_lines_passed_at_random_instants(speed: float) -> None:
    # an angle of constant rate, `speed` counts a sample, with any phase
    generator = np.random.default_rng(5)
    rate = speed * COUNT / C.period
    errors = []
    for start in generator.uniform(0.0, 1.0, 40):
        angles = (start + speed * np.arange(1, 120)) * COUNT
        lines = np.floor(angles / COUNT + 0.5)
        for k in np.flatnonzero(np.diff(lines)):
            measured, variance = passed(lines[k + 1], lines[k], rate, C)
            errors.append((measured - angles[k + 1]) / math.sqrt(variance - C.line_variance))
    count = len(errors)
    assert count > 100
    assert np.mean(errors) == pytest.approx(0.0, abs=4.0 / math.sqrt(count))
    # a uniform distribution has kurtosis 1.8, so the mean square has the variance 0.8 / count
    assert np.mean(np.square(errors)) == pytest.approx(1.0, abs=4.0 * math.sqrt(0.8 / count))
