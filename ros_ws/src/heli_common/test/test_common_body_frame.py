"""The helicopter's frame as a standard tf2_msgs/TFMessage, by another implementation of the format."""

import numpy as np
from rosbags.typesys import Stores, get_typestore

from heli_common.body_frame import TRANSFORM, is_shown, transform_message
from heli_common.rotations import Euler
from heli_common.topics import TOPICS
from heli_common.vehicle_state import VehicleState, odometry_values


def test_pose_of_the_truth_is_the_transform():
    state = VehicleState((1.0, 2.0, 3.0), Euler(0.3, -0.2, 0.1), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    truth = odometry_values(state, (0.0,) * 6, (0.0,) * 6)
    store = get_typestore(Stores.ROS2_JAZZY)
    data = transform_message(12_050_000_000, truth)
    message = store.deserialize_cdr(data, TRANSFORM.ros_type)
    (transform,) = message.transforms
    pose = store.deserialize_cdr(
        TOPICS["ground_truth"].layout.pack(0, truth), "nav_msgs/msg/Odometry"
    ).pose.pose
    assert (transform.header.stamp.sec, transform.header.stamp.nanosec) == (12, 50_000_000)
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "base_link")
    moved, turned = transform.transform.translation, transform.transform.rotation
    assert (moved.x, moved.y, moved.z) == (2.0, 1.0, -3.0)
    assert turned == pose.orientation
    again = store.serialize_cdr(message, TRANSFORM.ros_type)
    assert bytes(again) == data
    assert np.allclose(TRANSFORM.unpack(data)[1], truth[:7])


def test_frames_are_shown_twenty_times_a_second():
    assert sum(is_shown(stamp) for stamp in range(0, 1_000_000_000, 2_500_000)) == 20
