"""The beginning: means at rest, and a first covariance that covers what counts can hide."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.records import packed
from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_navigation.arm_kinematics import arms_from_position
from heli_navigation.beginning import FirstRest, first_memory, lever_slope
from heli_navigation.filter_memory import SIZE, Estimate, Memory, Work
from heli_navigation.filter_parameters import FilterParameters, filter_constants
from heli_navigation.strapdown import lean, orient

GEOMETRY = RigGeometry()
C = packed(filter_constants(FilterParameters(), GEOMETRY))
LEVER = np.array([C.x, C.y, C.z])
NO_BIAS = (np.zeros(3), 1e-4)


def test_the_mean_at_rest_is_the_bias() -> None:
    rest = FirstRest(2.5e-3, 0.4)
    generator = np.random.default_rng(1)
    bias = np.radians([0.4, -0.7, 0.2])
    for k in range(800):
        angles = (0.0,) * 6 if k >= 200 else (0.01 * k,) * 6
        rest.add(angles, bias + generator.normal(0.0, math.radians(0.4), 3))
    # 1.5 s at rest, of which the first 0.4 s only show that it rests
    assert rest.time == pytest.approx(1.1, abs=0.01)
    found, variance = rest.bias(C.gyro_density, C.gyro_bias)
    assert variance == pytest.approx(4.0 * math.radians(0.02) ** 2 / rest.time)
    assert np.abs(found - bias).max() < 4.0 * math.sqrt(variance)


def test_without_rest_nothing_is_known_of_the_bias() -> None:
    rest = FirstRest(2.5e-3, 0.4)
    for k in range(400):
        rest.add((0.01 * k,) * 6, (1.0, 1.0, 1.0))
    found, variance = rest.bias(C.gyro_density, C.gyro_bias)
    assert not found.any()
    assert variance == C.gyro_bias


def counts(angles: np.ndarray) -> np.ndarray:
    return RADIAN_PER_COUNT * np.floor(angles / RADIAN_PER_COUNT + 0.5)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000))
def test_the_first_estimate_is_within_what_it_says(seed: int) -> None:
    generator = np.random.default_rng(seed)
    place = tuple(generator.uniform(-0.25, 0.25, 3).tolist())
    gimbal = generator.uniform(-0.3, 0.3, 3)
    arms = counts(np.array(arms_from_position(place, GEOMETRY)))
    memory = first_memory(
        tuple(arms.tolist()), tuple(counts(gimbal).tolist()), (0.0,) * 3, (0.0,) * 3, NO_BIAS, C, GEOMETRY
    )
    work = np.zeros(Work.end)
    orient(*gimbal, work)
    truth = np.array(place) + work[Work.body : Work.rates].reshape(3, 3) @ LEVER
    error = np.concatenate([memory[: Estimate.velocity] - truth, memory[Estimate.angle : 9] - gimbal])
    covariance = memory[Memory.covariance : Memory.gyro].reshape(SIZE, SIZE)
    placed = covariance[np.ix_([0, 1, 2, 6, 7, 8], [0, 1, 2, 6, 7, 8])]
    # six half counts together: at most sqrt(3) deviations each, and a little curvature
    assert error @ np.linalg.solve(placed, error) < 6.0 * 3.0 * 1.1
    assert np.array_equal(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance)[0] > 0.0


def test_arms_that_fit_no_position_are_refused() -> None:
    with pytest.raises(ValueError, match="arm angles"):
        first_memory((-1.5, 1.5, 1.5), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3, NO_BIAS, C, GEOMETRY)


def test_the_levers_slope_is_the_filters_own() -> None:
    work = np.zeros(Work.end)
    orient(0.7, -0.2, 0.3, work)
    body = work[Work.body : Work.rates].reshape(3, 3).copy()
    lean(*(body @ LEVER), work)
    assert lever_slope(body @ LEVER, body) == pytest.approx(work[Work.lean : Work.rate].reshape(3, 3))
