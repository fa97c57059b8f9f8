"""Messages written by compiled code: by hand, and the same conversions as those of vehicle_state."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.compiled_messages import (
    read_pose,
    write_imu_attitude,
    write_odometry,
    write_pose,
)
from heli_common.rotations import Euler
from heli_common.topics import TOPICS
from heli_common.vehicle_state import (
    VehicleState,
    imu_from_values,
    odometry_values,
    pose_from_values,
    pose_values,
    quaternion_enu,
)

ODOMETRY = TOPICS["odometry"].layout.fields
IMU = TOPICS["imu_attitude"].layout.fields
NUMBER = st.floats(-10.0, 10.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER)
ANGLE = st.floats(-3.1, 3.1)
EULER = st.builds(Euler, ANGLE, st.floats(-1.5, 1.5), ANGLE)
VARIANCES = st.lists(st.floats(0.0, 10.0), min_size=6, max_size=6)


def odometry(position, attitude, velocity, rates, pose, twist):
    values = np.full(len(ODOMETRY), np.nan)
    motion = np.concatenate([position, attitude, velocity, rates, np.ravel(pose), np.ravel(twist)])
    write_odometry(motion, values)
    return values


@settings(deadline=None, max_examples=50)
@given(VECTOR, EULER, VECTOR, VECTOR, VARIANCES, VARIANCES)
def test_odometry_is_that_of_vehicle_state(position, attitude, velocity, rates, pose, twist):
    ours = odometry(position, attitude, velocity, rates, np.diag(pose), np.diag(twist))
    north, east, down, *turns = pose
    enu = (east, north, down, turns[1], turns[0], turns[2])
    state = VehicleState(position, attitude, velocity, rates)
    assert ours.tolist() == list(odometry_values(state, enu, twist))


def test_covariances_change_their_axes_by_hand():
    pose, twist = np.zeros((6, 6)), np.zeros((6, 6))
    pose[0, 2], pose[1, 2], pose[0, 1], pose[0, 4] = 1.0, 2.0, 3.0, 4.0  # n d, e d, n e, n with rotation east
    twist[0, 1], twist[1, 2], twist[0, 4] = 5.0, 6.0, 7.0
    zero = (0.0, 0.0, 0.0)
    values = dict(zip(ODOMETRY, odometry(zero, zero, zero, zero, pose, twist).tolist(), strict=True))
    found = {name: value for name, value in values.items() if "covariance" in name and value}
    assert found == {
        "pose_covariance[8]": -1.0,  # north and down: y and z, z turned over
        "pose_covariance[2]": -2.0,
        "pose_covariance[6]": 3.0,
        "pose_covariance[9]": 4.0,
        "twist_covariance[1]": -5.0,
        "twist_covariance[8]": 6.0,
        "twist_covariance[4]": -7.0,
    }


@settings(deadline=None, max_examples=50)
@given(EULER, VECTOR)
def test_attitude_by_the_imu_has_the_same_quaternion_and_rates(attitude, rates):
    values = np.full(len(IMU), np.nan)
    write_imu_attitude(attitude, (1.0, 2.0, 3.0), rates, 4.0, values)
    assert tuple(values[:4]) == quaternion_enu(attitude)
    assert imu_from_values(values.tolist())[0] == rates
    assert values[4:13].reshape(3, 3).tolist() == np.diag([2.0, 1.0, 3.0]).tolist()
    assert values[16:25].reshape(3, 3).tolist() == (4.0 * np.eye(3)).tolist()
    assert values[IMU.index("linear_acceleration_covariance[0]")] == pytest.approx(-1.0)
    assert np.isfinite(values).all()


@settings(deadline=None, max_examples=50)
@given(VECTOR, EULER)
def test_poses_are_written_and_read_as_by_vehicle_state(position, attitude):
    pose, written = np.full(6, np.nan), np.full(7, np.nan)
    write_pose(position, attitude, written)
    assert written.tolist() == list(pose_values(position, attitude))
    assert read_pose(written, pose)
    place, angles = pose_from_values(written.tolist())
    assert pose.tolist() == [*place, *angles]


def test_what_is_no_rotation_is_not_read():
    values, pose = np.zeros(7), np.full(6, 7.0)
    for quaternion in ((0.0, 0.0, 0.0, 0.0), (np.nan, 0.0, 0.0, 1.0)):
        values[3:7] = quaternion
        assert not read_pose(values, pose)
        with pytest.raises(ValueError, match="is no rotation"):
            pose_from_values(values.tolist())
    assert (pose == 7.0).all()
