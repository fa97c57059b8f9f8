"""Encoder error budget: two points by hand, the covariance against counted noise, the hard bound, the map."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import chi2

from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_common.rotations import Vector3
from heli_navigation.arm_kinematics import arm_jacobian, arms_from_position, position_from_arms
from heli_navigation.encoder_budget import (
    attitude_three_sigma,
    budget,
    position_error,
    ring_error,
    steps,
)

GEOMETRY = RigGeometry()
Array = NDArray[np.float64]


def place(height: float, radius: float, azimuth: float) -> Vector3:
    return (radius * math.cos(azimuth), radius * math.sin(azimuth), GEOMETRY.centre_height - height)


work_space = st.builds(
    place,
    st.floats(GEOMETRY.work_bottom, GEOMETRY.work_top),
    st.floats(0.0, GEOMETRY.work_radius),
    st.floats(0.0, 2.0 * math.pi),
)


@pytest.mark.parametrize("height", [0.45, 0.90, 1.25])
def test_on_the_axis_by_hand(height: float) -> None:
    """All arms alike: height and elbow angle from one right-angled triangle, sideways by symmetry.

    With D the height of the platform above the elbows and s = 0.24 + 0.75 cos alpha how far they stand out,
    D^2 + s^2 = 0.81. All arms together lift by dH = 0.75 cos alpha + 0.75 sin alpha s / D per radian, one
    alone by a third. Sideways one arm pulls 2/3 of what moves its elbow's sphere: 2/3 D/s of the same.
    """
    alpha = arms_from_position(place(height, 0.0, 0.0), GEOMETRY)[0]
    out, rise = 0.24 + 0.75 * math.cos(alpha), height - 0.75 * math.sin(alpha)
    assert math.hypot(out, rise) == pytest.approx(0.90, abs=1e-12)
    lift = 0.75 * math.cos(alpha) + 0.75 * math.sin(alpha) * out / rise
    up, side = lift / 3.0, 2.0 / 3.0 * lift * rise / out
    error = position_error(place(height, 0.0, 0.0), GEOMETRY)
    assert error.per_count == pytest.approx([math.hypot(up, side) * RADIAN_PER_COUNT] * 3, rel=1e-9)
    sigma = RADIAN_PER_COUNT / math.sqrt(12.0)
    # three independent arms: up * sqrt(3); sideways three vectors 120 deg apart: side * sqrt(3 / 2)
    down, north = 3.0 * sigma * up * math.sqrt(3.0), 3.0 * sigma * side * math.sqrt(1.5)
    assert error.three_sigma == pytest.approx((north, north, down), rel=1e-9)
    assert error.worst == pytest.approx(max(north, down), rel=1e-9)
    assert abs(error.worst_direction[2]) == pytest.approx(1.0 if down > north else 0.0, abs=1e-9)


def test_the_specs_figures() -> None:
    """Spec 2.1: 2.3 mm per count at the centre holds; its 8 mm at the bottom is reached lower down."""
    centre, bottom = (ring_error(height, 0.0, GEOMETRY) for height in (0.90, 0.45))
    assert centre.per_count == pytest.approx(2.3e-3, abs=5e-5)
    assert bottom.per_count == pytest.approx(4.7e-3, abs=5e-5)
    assert bottom.down == pytest.approx(7.0e-3, abs=5e-5)
    assert bottom.worst == pytest.approx(bottom.down, rel=1e-9)
    # one count down on all arms is the farthest whole-count step there
    assert 2.0 * bottom.down == pytest.approx(13.9e-3, abs=5e-5)
    assert ring_error(0.405, 0.0, GEOMETRY).per_count == pytest.approx(8.0e-3, abs=5e-5)


def counted(position: Vector3) -> Vector3:
    """Where forward kinematics puts the platform when the arms are read in whole counts."""
    lines = [round(angle / RADIAN_PER_COUNT) for angle in arms_from_position(position, GEOMETRY)]
    return position_from_arms(tuple(line * RADIAN_PER_COUNT for line in lines), GEOMETRY)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("height", "radius", "azimuth"),
    [(0.90, 0.0, 0.0), (0.47, 0.0, 0.0), (0.45, 0.48, 1.0), (1.23, 0.48, 4.0), (0.70, 0.30, 2.5)],
)
def test_covariance_is_that_of_counted_positions(height: float, radius: float, azimuth: float) -> None:
    """Numerical twin: true angles of random positions rounded to counts, against J J' count^2 / 12.

    Errors whitened by the predicted covariance are sums of three evenly spread ones; their squares scatter
    less than a normal's, so chi-square bounds hold with room. The box of 2 cm spans several counts of each
    arm; the covariance is taken at every position, as it changes inside the box near the bottom.
    """
    generator = np.random.default_rng(20030401)
    number = 3000
    centre = place(height, radius, azimuth)
    whitened = np.empty((number, 3))
    for row, offset in enumerate(generator.uniform(-0.01, 0.01, (number, 3)).tolist()):
        position = (centre[0] + offset[0], centre[1] + offset[1], centre[2] + offset[2])
        error = np.subtract(counted(position), position)
        factor = np.linalg.cholesky(np.array(position_error(position, GEOMETRY).covariance))
        whitened[row] = np.linalg.solve(factor, error)
    scatter = whitened.T @ whitened
    low, high = chi2.ppf([1e-5, 1.0 - 1e-5], number)
    for direction in itertools.product((-1.0, 0.0, 1.0), repeat=3):
        if any(direction):
            unit = np.array(direction) / np.linalg.norm(direction)
            assert low < unit @ scatter @ unit < high, direction
    # and it is no accident of slack bounds: 15 % more or less in any variance would be seen
    assert high / low < 1.15**2
    low, high = chi2.ppf([1e-5, 1.0 - 1e-5], 3 * number)
    assert low < np.trace(scatter) < high


@settings(deadline=None, max_examples=200)
@given(work_space, st.integers(0, 7))
def test_three_sigma_is_the_farthest_of_all(position: Vector3, corner: int) -> None:
    """Any half counts together stay inside three sigma, in every axis and in the worst direction."""
    error = position_error(position, GEOMETRY)
    jacobian = np.array(arm_jacobian(arms_from_position(position, GEOMETRY), position, GEOMETRY))
    halves = np.array([1.0 if corner >> arm & 1 else -1.0 for arm in range(3)]) * 0.5 * RADIAN_PER_COUNT
    moved = jacobian @ halves
    assert (np.abs(moved) <= np.array(error.three_sigma) * (1.0 + 1e-12)).all()
    assert np.linalg.norm(moved) <= error.worst * (1.0 + 1e-12)


@settings(deadline=None, max_examples=50)
@given(work_space)
def test_a_read_position_is_within_three_sigma(position: Vector3) -> None:
    """The same of the curved kinematics."""
    assert math.dist(counted(position), position) < 1.04 * position_error(position, GEOMETRY).worst


def test_curvature_adds_three_per_cent_at_the_bottom() -> None:
    bottom = place(GEOMETRY.work_bottom, 0.0, 0.0)
    angles = arms_from_position(bottom, GEOMETRY)
    low = tuple(angle - 0.5 * RADIAN_PER_COUNT for angle in angles)
    moved = math.dist(position_from_arms(low, GEOMETRY), bottom)  # type: ignore[arg-type]
    assert moved / position_error(bottom, GEOMETRY).worst == pytest.approx(1.031, abs=5e-4)


@settings(deadline=None, max_examples=50)
@given(work_space)
def test_worst_direction_is_where_the_covariance_says(position: Vector3) -> None:
    error = position_error(position, GEOMETRY)
    direction, covariance = np.array(error.worst_direction), np.array(error.covariance)
    assert 3.0 * math.sqrt(direction @ covariance @ direction) == pytest.approx(error.worst, rel=1e-9)
    assert max(error.three_sigma) <= error.worst * (1.0 + 1e-12)
    assert [covariance[axis, axis] for axis in range(3)] == pytest.approx(
        [(value / 3.0) ** 2 for value in error.three_sigma], rel=1e-12
    )


@settings(deadline=None, max_examples=30)
@given(
    st.floats(GEOMETRY.work_bottom, GEOMETRY.work_top),
    st.floats(0.0, GEOMETRY.work_radius),
    st.floats(0.0, 2.0 * math.pi),
)
def test_the_rig_has_three_arms(height: float, radius: float, azimuth: float) -> None:
    """A third of a turn, or the mirror image in the plane of arm 1, changes nothing."""
    here = position_error(place(height, radius, azimuth), GEOMETRY)
    turned = position_error(place(height, radius, azimuth + 2.0 * math.pi / 3.0), GEOMETRY)
    mirrored = position_error(place(height, radius, -azimuth), GEOMETRY)
    assert turned.worst == pytest.approx(here.worst, rel=1e-9)
    assert mirrored.three_sigma == pytest.approx(here.three_sigma, rel=1e-9)
    assert turned.per_count == pytest.approx(
        (here.per_count[2], here.per_count[0], here.per_count[1]), rel=1e-9
    )


def test_attitude_is_known_to_a_sixth_of_a_degree() -> None:
    """0.18 deg / sqrt(12) = 0.05196 deg, three times; half a count, 0.09 deg, is the most there can be."""
    assert [math.degrees(angle) for angle in attitude_three_sigma()] == pytest.approx(
        [0.155885] * 3, abs=1e-6
    )
    turned = np.random.default_rng(7).uniform(-0.4, 0.4, 4000)
    error = np.rint(turned / RADIAN_PER_COUNT) * RADIAN_PER_COUNT - turned
    low, high = chi2.ppf([1e-5, 1.0 - 1e-5], len(error))
    assert low < (error @ error) / (attitude_three_sigma().psi / 3.0) ** 2 < high


def test_ring_is_searched_finely_enough() -> None:
    every_degree = [math.radians(degree) for degree in range(360)]
    for height in (0.45, 0.9, 1.25):
        fine = ring_error(height, 0.5, GEOMETRY, every_degree)
        coarse = ring_error(height, 0.5, GEOMETRY)
        for name in ("per_count", "north", "east", "down", "worst"):
            assert getattr(coarse, name) == pytest.approx(getattr(fine, name), rel=2e-3), name
            assert getattr(coarse, name) <= getattr(fine, name) * (1.0 + 1e-9)
        # two azimuths of equal error 120 deg apart, or mirrored: the first of them is told
        assert coarse.azimuth <= math.pi / 3.0 + 1e-9


def test_the_worst_place_of_the_work_space_is_its_bottom_on_the_axis() -> None:
    heights = list(steps(GEOMETRY.work_bottom, GEOMETRY.work_top, 9))
    radii = list(steps(0.0, GEOMETRY.work_radius, 3))
    rings = budget(heights, radii, GEOMETRY)
    assert [(ring.height, ring.radius) for ring in rings] == list(itertools.product(heights, radii))
    worst = max(rings, key=lambda ring: ring.worst)
    assert (worst.height, worst.radius) == (GEOMETRY.work_bottom, 0.0)
    generator = np.random.default_rng(5)
    for height, radius, azimuth in generator.uniform((0.45, 0.0, 0.0), (1.25, 0.5, 6.3), (500, 3)).tolist():
        assert position_error(place(height, radius, azimuth), GEOMETRY).worst < worst.worst


def test_out_of_reach_is_refused_with_the_position() -> None:
    with pytest.raises(ValueError, match=r"\(1\.5, 0\.0, 0\.0\)"):
        position_error((1.5, 0.0, 0.0), GEOMETRY)
    with pytest.raises(ValueError, match="not above the fold"):
        ring_error(0.30, 0.0, GEOMETRY)


def test_steps_meet_both_ends() -> None:
    assert list(steps(0.45, 1.25, 3)) == [0.45, pytest.approx(0.85), 1.25]
