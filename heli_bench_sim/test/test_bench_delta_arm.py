"""Delta arm: a posture by hand, the round trip through an independent forward solution, the edges."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from heli_bench_sim.delta_arm import arm_angles, arm_jacobian
from heli_common.rig_geometry import RigGeometry

GEOMETRY = RigGeometry()
Array = NDArray[np.float64]


def forward(angles: Array) -> Array:
    """Platform position, NED, from the arm angles: meeting point of three spheres, the upper one.

    Written with lines and planes in a north-east-up frame, sharing nothing with the inverse.
    """
    centres = []
    for azimuth, angle in zip(np.radians([0.0, 120.0, 240.0]), angles, strict=True):
        out = 0.30 - 0.06 + 0.75 * math.cos(angle)
        centres.append([out * math.cos(azimuth), out * math.sin(azimuth), 0.75 * math.sin(angle)])
    first, second, third = np.array(centres)
    across, other = second - first, third - first
    normal = np.cross(across, other)
    sides = np.array([across, other, normal])
    inside = np.linalg.solve(sides, [0.5 * across @ across, 0.5 * other @ other, 0.0])
    height = math.sqrt(0.90**2 - inside @ inside) / math.sqrt(normal @ normal)
    up = first + inside + normal * height * math.copysign(1.0, normal[2])
    return np.array([up[0], up[1], 0.90 - up[2]])


def test_centre_of_the_flight_space() -> None:
    angles = arm_angles(np.zeros(3), GEOMETRY)
    assert np.degrees(angles) == pytest.approx([41.28] * 3, abs=0.005)


def test_arm_by_hand() -> None:
    """All upper arms 60 deg up: Pythagoras gives how far the platform stands above the elbows."""
    elbow_out = 0.30 + 0.75 * 0.5 - 0.06
    height = 0.75 * math.sqrt(0.75) + math.sqrt(0.90**2 - elbow_out**2)
    angles = arm_angles(np.array([0.0, 0.0, 0.90 - height]), GEOMETRY)
    assert np.degrees(angles) == pytest.approx([60.0] * 3, abs=1e-9)


@settings(deadline=None, max_examples=100)
@given(st.floats(0.0, 0.5), st.floats(-math.pi, math.pi), st.floats(0.45, 1.25))
def test_forward_undoes_inverse_over_the_work_space(radius: float, bearing: float, height: float) -> None:
    position = np.array([radius * math.cos(bearing), radius * math.sin(bearing), 0.90 - height])
    angles = arm_angles(position, GEOMETRY)
    assert np.abs(forward(angles) - position).max() < 1e-9


def test_forward_undoes_inverse_on_every_face_of_the_work_space() -> None:
    """Draws seldom touch a face: bottom, top, rim and their edges, two degrees apart."""
    rim = [(0.5, height) for height in np.linspace(0.45, 1.25, 5)]
    ends = [(radius, height) for radius in (0.0, 0.1, 0.25, 0.4) for height in (0.45, 1.25)]
    worst = 0.0
    for bearing in np.linspace(-math.pi, math.pi, 181):
        for radius, height in rim + ends:
            position = np.array([radius * math.cos(bearing), radius * math.sin(bearing), 0.90 - height])
            worst = max(worst, float(np.abs(forward(arm_angles(position, GEOMETRY)) - position).max()))
    assert worst < 1e-9


@settings(deadline=None, max_examples=30)
@given(st.floats(0.0, 0.5), st.floats(-math.pi, math.pi), st.floats(0.45, 1.25))
def test_a_third_of_a_turn_passes_the_angles_on(radius: float, bearing: float, height: float) -> None:
    def angles(direction: float) -> Array:
        here = np.array([radius * math.cos(direction), radius * math.sin(direction), 0.90 - height])
        return arm_angles(here, GEOMETRY)

    turned = angles(bearing + 2.0 * math.pi / 3.0)
    assert turned == pytest.approx(np.roll(angles(bearing), 1), abs=1e-9)


@pytest.mark.parametrize("position", [(0.0, 0.0, -1.0), (1.5, 0.0, 0.0), (0.0, -0.9, -0.3), (0.0, 0.0, -5.0)])
def test_pose_out_of_reach_is_an_error_with_the_pose(position: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="out of the arms' reach") as caught:
        arm_angles(np.array(position), GEOMETRY)
    assert repr(position) in str(caught.value)


def test_pose_that_is_no_number_is_an_error_too() -> None:
    with pytest.raises(ValueError, match="nan"):
        arm_angles(np.array([0.0, math.nan, 0.0]), GEOMETRY)


@settings(deadline=None, max_examples=200)
@given(st.tuples(*(st.floats(-2.0, 2.0) for _ in range(3))))
def test_any_position_has_its_forearms_length_or_is_refused_by_name(
    position: tuple[float, float, float],
) -> None:
    try:
        angles = arm_angles(np.array(position), GEOMETRY)
    except ValueError as refused:
        assert repr(position) in str(refused)
        return
    for azimuth, angle in zip(np.radians([0.0, 120.0, 240.0]), angles, strict=True):
        out = 0.30 - 0.06 + 0.75 * math.cos(angle)
        elbow = (out * math.cos(azimuth), out * math.sin(azimuth), 0.90 - 0.75 * math.sin(angle))
        assert math.dist(elbow, position) == pytest.approx(0.90, abs=1e-7)


def test_stops_bite_before_the_arms_are_out_of_reach() -> None:
    """A tenth of a metre beyond the cylinder on every side can still be measured."""
    for bearing in np.linspace(-math.pi, math.pi, 73):
        for height in (0.42, 0.9, 1.3):
            arm_angles(np.array([0.6 * math.cos(bearing), 0.6 * math.sin(bearing), 0.9 - height]), GEOMETRY)


@settings(deadline=None, max_examples=30)
@given(st.floats(-0.35, 0.35), st.floats(-0.35, 0.35), st.floats(-0.35, 0.45))
def test_jacobian_is_the_slope(x: float, y: float, z: float) -> None:
    position, step = np.array([x, y, z]), 1e-6
    columns = []
    for axis in np.eye(3):
        ahead = arm_angles(position + step * axis, GEOMETRY)
        columns.append((ahead - arm_angles(position - step * axis, GEOMETRY)) / (2.0 * step))
    assert arm_jacobian(position, GEOMETRY) == pytest.approx(np.column_stack(columns), abs=1e-7)


def test_one_count_at_the_centre_is_two_millimetres() -> None:
    """Spec 2.1: one count of one arm moves the platform by 2.3 mm at the centre."""
    moved = np.linalg.inv(arm_jacobian(np.zeros(3), GEOMETRY))[:, 0] * math.radians(0.18)
    assert np.linalg.norm(moved) == pytest.approx(2.3e-3, abs=0.1e-3)
