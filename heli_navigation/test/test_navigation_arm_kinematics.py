from __future__ import annotations

import math
from math import atan2, cos, hypot, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.rig_geometry import ARM_AZIMUTH, RADIAN_PER_COUNT, RigGeometry
from heli_common.rotations import Vector3
from heli_navigation.arm_kinematics import (
    arm_jacobian,
    arms_from_position,
    position_from_arms,
    position_variance,
)

GEOMETRY = RigGeometry()


def arms_of(position: Vector3, geometry: RigGeometry = GEOMETRY) -> Vector3:
    """Inverse kinematics written independently: per arm a circle cut by a sphere, outer elbow."""
    angles = []
    height = geometry.centre_height - position[2]
    for azimuth in ARM_AZIMUTH:
        outward = position[0] * cos(azimuth) + position[1] * sin(azimuth) + geometry.platform_radius
        sideways = position[1] * cos(azimuth) - position[0] * sin(azimuth)
        reach = outward - geometry.base_radius
        span = hypot(reach, height)
        shortened = geometry.forearm**2 - sideways**2
        cosine = (geometry.upper_arm**2 + span**2 - shortened) / (2.0 * geometry.upper_arm * span)
        if abs(cosine) > 1.0:
            raise ValueError(f"{position} out of reach")
        angles.append(atan2(height, reach) - math.acos(cosine))
    return (angles[0], angles[1], angles[2])


def cylinder(radius: float, azimuth: float, height: float) -> Vector3:
    return (radius * cos(azimuth), radius * sin(azimuth), GEOMETRY.centre_height - height)


work_space = st.builds(
    cylinder,
    st.floats(0.0, GEOMETRY.work_radius),
    st.floats(0.0, 2.0 * math.pi),
    st.floats(GEOMETRY.work_bottom, GEOMETRY.work_top),
)


def test_centre_has_all_arms_at_41_degrees() -> None:
    # (0.24 + 0.75 cos a)^2 + (0.90 - 0.75 sin a)^2 = 0.81 gives 0.36 cos a - 1.35 sin a = -0.6201
    alpha = math.acos(-0.6201 / hypot(0.36, 1.35)) - atan2(1.35, 0.36)
    assert math.degrees(alpha) == pytest.approx(41.28, abs=0.005)
    assert position_from_arms((alpha, alpha, alpha), GEOMETRY) == pytest.approx((0, 0, 0), abs=1e-12)


def test_all_arms_up_is_up_and_arm_one_down_is_north() -> None:
    alpha = math.radians(41.28)
    assert position_from_arms((alpha + 0.1,) * 3, GEOMETRY)[2] < -0.05
    # the arm that points north leans further out and pulls the platform with it
    north, east, _ = position_from_arms((alpha - 0.1, alpha, alpha), GEOMETRY)
    assert north > 0.02
    assert east == pytest.approx(0.0, abs=1e-12)
    # arm 2 stands 120 deg clockwise from above, so south-east
    north, east, _ = position_from_arms((alpha, alpha - 0.1, alpha), GEOMETRY)
    assert north < 0.0 < east


@settings(deadline=None, max_examples=300)
@given(work_space)
def test_forward_undoes_inverse_in_the_work_space(position: Vector3) -> None:
    found = position_from_arms(arms_of(position), GEOMETRY)
    assert math.dist(found, position) < 1e-9


@settings(deadline=None, max_examples=300)
@given(work_space)
def test_the_pair_is_an_identity_in_the_work_space(position: Vector3) -> None:
    angles = arms_from_position(position, GEOMETRY)
    assert angles == pytest.approx(arms_of(position), abs=1e-12)
    assert math.dist(position_from_arms(angles, GEOMETRY), position) < 1e-9
    back = arms_from_position(position_from_arms(angles, GEOMETRY), GEOMETRY)
    assert back == pytest.approx(angles, abs=1e-9)


def test_the_pair_is_an_identity_on_every_face_of_the_work_space() -> None:
    """Draws seldom touch a face: bottom, top, rim and their edges, a degree apart."""
    worst = 0.0
    for azimuth in np.linspace(0.0, 2.0 * math.pi, 361):
        for radius, height in (
            (0.0, GEOMETRY.work_bottom),
            (0.0, GEOMETRY.work_top),
            *((GEOMETRY.work_radius, height) for height in np.linspace(0.45, 1.25, 9)),
            *((radius, GEOMETRY.work_bottom) for radius in (0.1, 0.25, 0.4)),
            *((radius, GEOMETRY.work_top) for radius in (0.1, 0.25, 0.4)),
        ):
            position = cylinder(radius, azimuth, height)
            for inverse in (arms_of(position), arms_from_position(position, GEOMETRY)):
                worst = max(worst, math.dist(position_from_arms(inverse, GEOMETRY), position))
    assert worst < 1e-9


OUT_OF_REACH = "out of the arms' reach"
BELOW = "not above the fold"


@pytest.mark.parametrize(
    ("position", "words"),
    [
        ((1.5, 0.0, 0.0), OUT_OF_REACH),
        ((0.0, 0.0, -1.0), OUT_OF_REACH),
        ((0.0, -0.9, -0.3), OUT_OF_REACH),
        ((0.0, 0.0, 1e200), OUT_OF_REACH),
        ((0.0, math.inf, 0.0), OUT_OF_REACH),
        ((math.nan, 0.0, 0.0), OUT_OF_REACH),
        ((0.0, 0.0, 0.55), BELOW),
        ((0.1, -0.2, 0.6), BELOW),
        ((0.0, 0.0, GEOMETRY.centre_height - GEOMETRY.fold_height), "do not meet|not above the fold"),
    ],
)
def test_unreachable_position_is_refused_by_name(position: Vector3, words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        arms_from_position(position, GEOMETRY)
    assert str(position) in str(caught.value)


@settings(deadline=None, max_examples=300)
@given(st.tuples(*(st.floats(-1.5, 1.5) for _ in range(3))))
def test_any_position_comes_back_or_is_refused_by_name(position: Vector3) -> None:
    try:
        angles = arms_from_position(position, GEOMETRY)
    except ValueError as refused:
        assert str(position) in str(refused)
        return
    assert all(math.isfinite(angle) for angle in angles)
    assert math.dist(position_from_arms(angles, GEOMETRY), position) < 1e-9


@settings(deadline=None, max_examples=60)
@given(work_space)
def test_jacobian_is_the_derivative_of_the_position(position: Vector3) -> None:
    angles = arms_of(position)
    jacobian = np.array(arm_jacobian(angles, position, GEOMETRY))
    step = 1e-6
    for arm in range(3):
        moved = [list(angles), list(angles)]
        moved[0][arm] += step
        moved[1][arm] -= step
        ahead, behind = (position_from_arms((a[0], a[1], a[2]), GEOMETRY) for a in moved)
        numeric = (np.array(ahead) - np.array(behind)) / (2.0 * step)
        np.testing.assert_allclose(jacobian[:, arm], numeric, atol=1e-6 * abs(numeric).max())


def test_one_count_at_the_centre_is_2_3_millimetres() -> None:
    jacobian = np.array(arm_jacobian(arms_of((0.0, 0.0, 0.0)), (0.0, 0.0, 0.0), GEOMETRY))
    assert np.linalg.norm(jacobian[:, 0]) * RADIAN_PER_COUNT == pytest.approx(2.3e-3, abs=5e-5)


def test_variance_is_the_diagonal_of_j_j_transposed() -> None:
    position = (0.2, -0.3, 0.1)
    jacobian = arm_jacobian(arms_of(position), position, GEOMETRY)
    expected = np.diag(np.array(jacobian) @ np.array(jacobian).T) * 0.25
    np.testing.assert_allclose(position_variance(jacobian, 0.25), expected, rtol=1e-14)


def test_platform_on_the_fold_and_below_is_refused() -> None:
    fold = math.asin(GEOMETRY.fold_height / GEOMETRY.upper_arm)
    assert position_from_arms((fold + 1e-2,) * 3, GEOMETRY)[2] < GEOMETRY.centre_height - GEOMETRY.fold_height
    with pytest.raises(ValueError, match="do not meet"):
        position_from_arms((fold - 1e-6,) * 3, GEOMETRY)
    with pytest.raises(ValueError, match=r"-0\.698.* not above the fold"):
        position_from_arms((math.radians(-40.0),) * 3, GEOMETRY)


@pytest.mark.parametrize("angles", [(1.5, 0.0, 0.0), (0.0, 0.0, 0.0), (-1.5, 0.8, 0.8)])
def test_arms_that_do_not_meet_are_refused_with_their_angles(angles: Vector3) -> None:
    with pytest.raises(ValueError, match="arm angles") as caught:
        position_from_arms(angles, GEOMETRY)
    assert str(angles) in str(caught.value)


@settings(deadline=None, max_examples=200)
@given(st.tuples(*(st.floats(-math.pi, math.pi) for _ in range(3))))
def test_any_angles_give_a_true_position_or_an_error(angles: Vector3) -> None:
    try:
        position = position_from_arms(angles, GEOMETRY)
    except ValueError:
        return
    for arm, azimuth in enumerate(ARM_AZIMUTH):
        out = GEOMETRY.base_radius - GEOMETRY.platform_radius + GEOMETRY.upper_arm * cos(angles[arm])
        elbow = (
            out * cos(azimuth),
            out * sin(azimuth),
            GEOMETRY.centre_height - GEOMETRY.upper_arm * sin(angles[arm]),
        )
        assert math.dist(position, elbow) == pytest.approx(GEOMETRY.forearm, abs=1e-9)
    assert all(math.isfinite(entry) for row in arm_jacobian(angles, position, GEOMETRY) for entry in row)


def test_degenerate_rigs_are_refused() -> None:
    straight_up = (math.pi / 2.0,) * 3
    with pytest.raises(ValueError, match="coincide"):
        position_from_arms(straight_up, RigGeometry(base_radius=0.3, platform_radius=0.3))
    with pytest.raises(ValueError, match="one plane"):
        arm_jacobian((0.0, 0.0, 0.0), (0.0, 0.0, GEOMETRY.centre_height), GEOMETRY)
