"""One arm's angle: the inverse kinematics again, its derivative by differences and by the Jacobian."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.rig_geometry import RigGeometry
from heli_navigation.arm_angle import OUT_OF_REACH, arm_angle
from heli_navigation.arm_kinematics import arm_jacobian, arms_from_position
from heli_navigation.filter_memory import Work
from heli_navigation.filter_parameters import FilterParameters, filter_constants

GEOMETRY = RigGeometry()
C = filter_constants(FilterParameters(), GEOMETRY)
PLACE = st.tuples(st.floats(-0.33, 0.33), st.floats(-0.33, 0.33), st.floats(-0.35, 0.44))


def angle_and_slope(arm: int, place: tuple[float, float, float]) -> tuple[float, np.ndarray]:
    work = np.zeros(Work.end)
    return arm_angle(arm, *place, C, work), work[Work.slope : Work.angle].copy()


def test_in_the_centre_all_arms_stand_alike() -> None:
    for arm in range(3):
        angle, slope = angle_and_slope(arm, (0.0, 0.0, 0.0))
        assert math.degrees(angle) == pytest.approx(41.28, abs=0.005)  # spec 2.1
        assert slope[2] == pytest.approx(angle_and_slope(0, (0.0, 0.0, 0.0))[1][2])
        assert slope[2] < 0.0  # up turns every arm up


@settings(deadline=None, max_examples=60)
@given(PLACE)
def test_it_is_the_inverse_kinematics(place: tuple[float, float, float]) -> None:
    expected = arms_from_position(place, GEOMETRY)
    assert [angle_and_slope(arm, place)[0] for arm in range(3)] == pytest.approx(expected, abs=1e-12)


@settings(deadline=None, max_examples=60)
@given(PLACE)
def test_its_slope_by_differences_and_by_the_jacobian(place: tuple[float, float, float]) -> None:
    step = 1e-6
    slopes = np.array([angle_and_slope(arm, place)[1] for arm in range(3)])
    for axis in range(3):
        up, down = list(place), list(place)
        up[axis] += step
        down[axis] -= step
        for arm in range(3):
            difference = angle_and_slope(arm, tuple(up))[0] - angle_and_slope(arm, tuple(down))[0]
            assert slopes[arm, axis] == pytest.approx(difference / (2.0 * step), abs=1e-6)
    jacobian = np.array(arm_jacobian(arms_from_position(place, GEOMETRY), place, GEOMETRY))
    assert slopes @ jacobian == pytest.approx(np.eye(3), abs=1e-9)


def test_out_of_reach_is_said() -> None:
    assert angle_and_slope(0, (0.0, 0.0, -5.0))[0] == OUT_OF_REACH
    assert angle_and_slope(1, (math.nan, 0.0, 0.0))[0] == OUT_OF_REACH
