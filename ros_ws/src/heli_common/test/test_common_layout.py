"""The fixed-layout codec against rclpy's own serialization, in both directions, for every topic."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common import standard_layouts
from heli_common.nodes.messages import message_class
from heli_common.topics import DATA_TOPICS, RECORDER, TOPICS, listeners

rclpy_serialization = pytest.importorskip("rclpy.serialization")

NUMBER = st.floats(allow_nan=False, width=64)
STAMP = st.integers(0, 2**31 * 10**9 - 1)


def filled(topic, stamp_ns, values):
    """The message of a topic, filled through rclpy's own setters."""
    described = TOPICS[topic].layout
    message = message_class(described.ros_type)()
    header = message if described.ros_type.endswith("Header") else getattr(message, "header", None)
    stamp = message.clock if header is None else header.stamp
    stamp.sec, stamp.nanosec = divmod(stamp_ns, 10**9)
    worlds = dict.fromkeys(("odometry", "odometry_imu", "ground_truth", "reference", "wind"), "world")
    headings = dict.fromkeys(("velocity_reference", "reference_excitation"), "heading")
    imus = dict.fromkeys(("imu", "imu_attitude"), "imu_link")
    frame = (worlds | headings | imus).get(topic, "rig")
    if header is not None:
        header.frame_id = frame
    if hasattr(message, "child_frame_id"):
        message.child_frame_id = "base_link"
    if described.ros_type.endswith("JointState"):
        message.name = list(dict.fromkeys(field.partition(".")[2] for field in described.fields))
        for field, value in zip(described.fields, values, strict=True):
            getattr(message, field.partition(".")[0]).append(value)
        return message
    body = {"pose_covariance": "pose.covariance", "twist_covariance": "twist.covariance"}
    for field, value in zip(described.fields, values, strict=True):
        name, _, rest = field.partition("[")
        if rest:
            if hasattr(message, name):
                getattr(message, name)[int(rest[:-1])] = value
            else:
                getattr(message, body[name].partition(".")[0]).covariance[int(rest[:-1])] = value
            continue
        part, axis = field.split(".")
        if hasattr(message, part):
            setattr(getattr(message, part), axis, value)
            continue
        owner = getattr(message, "pose", None) if part in ("position", "orientation") else message.twist
        owner = getattr(owner, "pose", getattr(owner, "twist", owner))
        setattr(getattr(owner, part), axis, value)
    return message


@pytest.mark.parametrize("topic", TOPICS)
def test_wire_is_what_rclpy_writes(topic):
    described = TOPICS[topic].layout
    values = np.random.default_rng(7).normal(size=len(described.fields)).tolist()
    stamp_ns = 12_345_678_901
    theirs = rclpy_serialization.serialize_message(filled(topic, stamp_ns, values))
    ours = described.pack(stamp_ns, values)
    assert described.canonical(theirs) == ours
    read = rclpy_serialization.deserialize_message(ours, message_class(described.ros_type))
    assert (
        rclpy_serialization.serialize_message(read) == theirs
        or described.canonical(rclpy_serialization.serialize_message(read)) == ours
    )


@pytest.mark.parametrize("topic", TOPICS)
@settings(deadline=None, max_examples=25)
@given(data=st.data(), stamp_ns=STAMP)
def test_round_trip_is_exact(topic, data, stamp_ns):
    described = TOPICS[topic].layout
    count = len(described.fields)
    values = data.draw(st.lists(NUMBER, min_size=count, max_size=count))
    wire = described.pack(stamp_ns, values)
    assert described.unpack(wire) == (stamp_ns, tuple(values))
    assert described.stamp(wire) == stamp_ns
    assert described.canonical(wire) == wire


def test_joint_state_by_hand():
    described = standard_layouts.joint_state("r", ["a"])
    wire = described.pack(1_500_000_000, [1.0, 2.0, 3.0])
    by_hand = struct.pack(
        "<4xiI I2s2x I I2s2x Id I4xd I4xd", 1, 500_000_000, 2, b"r", 1, 2, b"a", 1, 1.0, 1, 2.0, 1, 3.0
    )
    assert wire[4:] == by_hand[4:]
    assert wire[:4] == b"\x00\x01\x00\x00"


def test_many_messages_read_as_arrays():
    described = TOPICS["encoders"].layout
    rows = np.random.default_rng(3).normal(size=(50, len(described.fields)))
    wires = [described.pack(k * 2_500_000, row) for k, row in enumerate(rows)]
    stamps, values = described.read(wires)
    assert stamps.tolist() == [k * 2_500_000 for k in range(50)]
    np.testing.assert_array_equal(values, rows)
    empty_stamps, empty = described.read([])
    assert empty_stamps.shape == (0,)
    assert empty.shape == (0, 18)


def test_a_message_of_another_shape_is_refused():
    described = TOPICS["servo_command"].layout
    with pytest.raises(ValueError, match="bytes instead of"):
        described.unpack(TOPICS["motor_command"].layout.pack(0, [0.0] * 3))
    with pytest.raises(ValueError, match="3 values for 12 fields"):
        described.pack(0, [0.0] * 3)
    renamed = standard_layouts.joint_state("rig", ["B_1x", "A_1s", "theta_0", "theta_t"])
    with pytest.raises(ValueError, match="names, frames or lengths"):
        described.canonical(renamed.pack(0, [0.0] * 12))


def test_padding_does_not_count():
    described = standard_layouts.joint_state("rig", ["motor"])
    wire = bytearray(described.pack(5, [1.0, 2.0, 3.0]))
    padding = 4 + 8 + 4 + len("rig\0") + 4 + 4 + len("motor\0")
    assert wire[padding] == 0
    wire[padding] = 0xFF
    assert described.canonical(bytes(wire)) == described.pack(5, [1.0, 2.0, 3.0])


def test_not_a_number_survives_the_wire():
    described = TOPICS["motor_command"].layout
    _, values = described.unpack(described.pack(0, [math.nan, math.inf, -0.0]))
    assert math.isnan(values[0])
    assert values[1] == math.inf
    assert math.copysign(1.0, values[2]) == -1.0


def test_topic_table_is_consistent():
    running = tuple({topic.source for topic in TOPICS.values()})
    for name in DATA_TOPICS:
        assert RECORDER in listeners(name, running)
        assert TOPICS[name].source not in listeners(name, running)
    assert listeners("encoders", ("navigation",)) == ("navigation",)
    assert listeners("clock", running) == ()


def test_a_size_the_middleware_would_pad_is_refused():
    with pytest.raises(ValueError, match="no multiple of four"):
        standard_layouts.header("recorder")
