"""Rotations and the NED/FRD to ENU/FLU boundary: by hand, against SciPy, and as properties."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from heli_common.rotations import (
    Euler,
    Quaternion,
    euler_from_quaternion,
    matrix_from_euler,
    multiply,
    quaternion_from_euler,
    rotate,
    transpose,
    wrap,
)
from heli_common.vehicle_state import (
    UNKNOWN_VARIANCE,
    VehicleState,
    attitude_ned,
    odometry_values,
    pose_from_values,
    pose_values,
    quaternion_enu,
    state_from_odometry,
    swap_frames,
    twist_from_values,
    twist_values,
)

ANGLE = st.floats(-3.1, 3.1)
PITCH = st.floats(-1.5, 1.5)
NUMBER = st.floats(-10.0, 10.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER)
EULER = st.builds(Euler, ANGLE, PITCH, ANGLE)
NED_TO_ENU = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
FLU_TO_FRD = np.diag([1, -1, -1])


def scipy_rotation(euler):
    return Rotation.from_euler("ZYX", [euler.psi, euler.theta, euler.phi])


def test_level_and_facing_north_is_a_quarter_turn_in_enu():
    half = math.sqrt(0.5)
    assert quaternion_enu(Euler(0.0, 0.0, 0.0)) == pytest.approx((0.0, 0.0, half, half))
    # facing east, the ENU heading is zero
    assert quaternion_enu(Euler(math.pi / 2, 0.0, 0.0)) == pytest.approx((0.0, 0.0, 0.0, 1.0), abs=1e-12)


def test_nose_up_and_right_down_are_named_as_pilots_name_them():
    nose_up = rotate(matrix_from_euler(Euler(0.0, 0.1, 0.0)), (1.0, 0.0, 0.0))
    assert nose_up[2] == pytest.approx(-math.sin(0.1))
    right_down = rotate(matrix_from_euler(Euler(0.0, 0.0, 0.1)), (0.0, 1.0, 0.0))
    assert right_down[2] == pytest.approx(math.sin(0.1))


def test_position_and_velocity_cross_the_boundary_by_hand():
    values = pose_values((1.0, 2.0, 3.0), Euler(0.0, 0.0, 0.0))
    assert values[:3] == (2.0, 1.0, -3.0)
    assert twist_values((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)) == (1.0, -2.0, -3.0, 4.0, -5.0, -6.0)


def half_turned(quaternion):
    """A quaternion between half a turn about the axis between north and east and one about the nose."""
    half = math.sqrt(0.5)
    earth, body = Quaternion(half, half, 0.0, 0.0), Quaternion(1.0, 0.0, 0.0, 0.0)
    return multiply(earth, multiply(quaternion, body))


@given(st.builds(Quaternion, NUMBER, NUMBER, NUMBER, NUMBER))
def test_frames_are_swapped_by_two_half_turns(quaternion):
    assert swap_frames(quaternion) == half_turned(quaternion), "the same bits"


def test_a_helicopter_that_stands_keeps_its_zeros():
    quaternion = quaternion_enu(Euler(0.0, 0.0, 0.0))
    assert str(swap_frames(quaternion)) == str(half_turned(quaternion)), "and their signs"


@settings(deadline=None, max_examples=200)
@given(EULER)
def test_matrix_and_quaternion_are_scipys(euler):
    expected = scipy_rotation(euler)
    np.testing.assert_allclose(matrix_from_euler(euler), expected.as_matrix(), atol=1e-12)
    ours = np.array(quaternion_from_euler(euler))
    theirs = expected.as_quat()
    np.testing.assert_allclose(ours * np.sign(ours @ theirs), theirs, atol=1e-12)
    back = np.array(euler_from_quaternion(quaternion_from_euler(euler)))
    assert abs(wrap(back[0] - euler.psi)) < 1e-7
    np.testing.assert_allclose(back[1], euler.theta, atol=1e-7)
    assert abs(wrap(back[2] - euler.phi)) < 1e-7


@settings(deadline=None, max_examples=200)
@given(EULER)
def test_enu_attitude_is_the_matrix_product(euler):
    expected = NED_TO_ENU @ scipy_rotation(euler).as_matrix() @ FLU_TO_FRD
    ours = Rotation.from_quat(quaternion_enu(euler)).as_matrix()
    np.testing.assert_allclose(ours, expected, atol=1e-12)


@settings(deadline=None, max_examples=200)
@given(EULER)
def test_antipodal_quaternions_are_the_same_attitude(euler):
    quaternion = quaternion_enu(euler)
    assert quaternion.w >= 0.0
    opposite = Quaternion(*(-part for part in quaternion))
    assert attitude_ned(opposite) == pytest.approx(attitude_ned(quaternion), abs=1e-12)


@settings(deadline=None, max_examples=200)
@given(VECTOR, EULER, VECTOR, VECTOR, st.booleans())
def test_odometry_round_trip(position, attitude, velocity, rates, known):
    state = VehicleState(position, attitude, velocity, rates, known)
    variance = (1e-6 if known else UNKNOWN_VARIANCE,) * 6
    back = state_from_odometry(odometry_values(state, variance, (1e-4,) * 6))
    assert back.position == position
    assert back.velocity == velocity
    assert back.rates == rates
    assert back.known is known
    np.testing.assert_allclose(matrix_from_euler(back.attitude), matrix_from_euler(attitude), atol=1e-7)


@settings(deadline=None, max_examples=100)
@given(VECTOR, VECTOR, EULER)
def test_pose_and_twist_round_trip(position, other, attitude):
    assert pose_from_values(pose_values(position, attitude))[0] == position
    assert twist_from_values(twist_values(position, other)) == (position, other)


@given(EULER, VECTOR)
def test_rotation_keeps_length_and_is_undone_by_its_transpose(euler, vector):
    matrix = matrix_from_euler(euler)
    assert math.hypot(*rotate(matrix, vector)) == pytest.approx(math.hypot(*vector), abs=1e-9)
    assert rotate(transpose(matrix), rotate(matrix, vector)) == pytest.approx(vector, abs=1e-9)


@given(st.floats(-100.0, 100.0))
def test_wrapped_angles_point_the_same_way(angle):
    wrapped = wrap(angle)
    assert -math.pi <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.parametrize("theta", [math.pi / 2, -math.pi / 2])
def test_nose_straight_up_keeps_the_matrix(theta):
    euler = Euler(0.3, theta, 0.1)
    back = euler_from_quaternion(quaternion_from_euler(euler))
    np.testing.assert_allclose(matrix_from_euler(back), matrix_from_euler(euler), atol=1e-6)


@pytest.mark.parametrize(
    "parts", [(0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0), (math.inf, 0.0, 0.0, 1.0)]
)
def test_no_rotation_is_refused(parts):
    with pytest.raises(ValueError, match="no rotation"):
        euler_from_quaternion(Quaternion(*parts))


def test_an_odometry_that_is_read_again_means_the_same_and_a_changed_one_does_not():
    north = VehicleState((1.0, 0.0, 0.0), Euler(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    values = odometry_values(north, (1e-4,) * 6, (1e-4,) * 6)
    assert state_from_odometry(values) == state_from_odometry(values) == state_from_odometry((*values,))
    changing = list(values)
    assert state_from_odometry(changing).position[0] == 1.0
    changing[1] = 2.0
    assert state_from_odometry(changing).position[0] == 2.0
    with pytest.raises(IndexError):
        state_from_odometry(())
