"""Layouts of the standard messages in which everything of this project travels (spec 6.4, 7.1)."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from heli_common.layout import ENCAPSULATION, Layout


class _CdrWriter:
    """Serialized bytes in the making; alignment counts from behind the encapsulation header."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.number_offsets: list[int] = []

    def align(self, size: int) -> None:
        self.data += bytes(-len(self.data) % size)

    def uint32(self, value: int) -> None:
        self.align(4)
        self.data += struct.pack("<I", value)

    def string(self, text: str) -> None:
        encoded = text.encode() + b"\0"
        self.uint32(len(encoded))
        self.data += encoded

    def numbers(self, count: int) -> None:
        self.align(8)
        start = len(self.data) + len(ENCAPSULATION)
        self.number_offsets += range(start, start + 8 * count, 8)
        self.data += bytes(8 * count)


def _finish(ros_type: str, writer: _CdrWriter, fields: Sequence[str], stamp_offset: int = 4) -> Layout:
    template = ENCAPSULATION + bytes(writer.data)
    return Layout(ros_type, tuple(fields), template, stamp_offset, tuple(writer.number_offsets))


def _header(writer: _CdrWriter, frame_id: str) -> None:
    writer.data += bytes(8)  # stamp: int32 sec, uint32 nanosec
    writer.string(frame_id)


def _indexed(name: str, count: int) -> list[str]:
    return [f"{name}[{index}]" for index in range(count)]


def _xyz(name: str) -> list[str]:
    return [f"{name}.{axis}" for axis in "xyz"]


def _xyzw(name: str) -> list[str]:
    return [f"{name}.{axis}" for axis in "xyzw"]


def clock() -> Layout:
    """rosgraph_msgs/Clock: a bare stamp."""
    writer = _CdrWriter()
    writer.data += bytes(8)
    return _finish("rosgraph_msgs/msg/Clock", writer, [])


def header(frame_id: str) -> Layout:
    """std_msgs/Header: a stamp, for acknowledgements."""
    writer = _CdrWriter()
    _header(writer, frame_id)
    return _finish("std_msgs/msg/Header", writer, [])


def joint_state(frame_id: str, names: Sequence[str]) -> Layout:
    """sensor_msgs/JointState with position, velocity and effort of every joint, in that order."""
    writer = _CdrWriter()
    _header(writer, frame_id)
    writer.uint32(len(names))
    for name in names:
        writer.string(name)
    for _ in range(3):
        writer.uint32(len(names))
        writer.numbers(len(names))
    fields = [f"{quantity}.{name}" for quantity in ("position", "velocity", "effort") for name in names]
    return _finish("sensor_msgs/msg/JointState", writer, fields)


def pose_stamped(frame_id: str) -> Layout:
    """geometry_msgs/PoseStamped."""
    writer = _CdrWriter()
    _header(writer, frame_id)
    writer.numbers(7)
    return _finish("geometry_msgs/msg/PoseStamped", writer, _xyz("position") + _xyzw("orientation"))


def twist_stamped(frame_id: str) -> Layout:
    """geometry_msgs/TwistStamped."""
    writer = _CdrWriter()
    _header(writer, frame_id)
    writer.numbers(6)
    return _finish("geometry_msgs/msg/TwistStamped", writer, _xyz("linear") + _xyz("angular"))


def vector3_stamped(frame_id: str) -> Layout:
    """geometry_msgs/Vector3Stamped."""
    writer = _CdrWriter()
    _header(writer, frame_id)
    writer.numbers(3)
    return _finish("geometry_msgs/msg/Vector3Stamped", writer, _xyz("vector"))


def imu(frame_id: str) -> Layout:
    """sensor_msgs/Imu: attitude, angular velocity and specific force, each with covariance."""
    writer = _CdrWriter()
    _header(writer, frame_id)
    writer.numbers(37)
    fields = _xyzw("orientation") + _indexed("orientation_covariance", 9)
    for name in ("angular_velocity", "linear_acceleration"):
        fields += _xyz(name) + _indexed(f"{name}_covariance", 9)
    return _finish("sensor_msgs/msg/Imu", writer, fields)


def odometry(frame_id: str, child_frame_id: str) -> Layout:
    """nav_msgs/Odometry: pose in `frame_id`, twist in `child_frame_id`, both with covariance."""
    writer = _CdrWriter()
    _header(writer, frame_id)
    writer.string(child_frame_id)
    writer.numbers(85)
    pose = _xyz("position") + _xyzw("orientation") + _indexed("pose_covariance", 36)
    twist = _xyz("linear") + _xyz("angular") + _indexed("twist_covariance", 36)
    return _finish("nav_msgs/msg/Odometry", writer, pose + twist)


def transform(frame_id: str, child_frame_id: str) -> Layout:
    """tf2_msgs/TFMessage with the one transform that takes points of the child frame to the frame."""
    writer = _CdrWriter()
    writer.uint32(1)
    _header(writer, frame_id)
    writer.string(child_frame_id)
    writer.numbers(7)
    return _finish("tf2_msgs/msg/TFMessage", writer, _xyz("translation") + _xyzw("rotation"), 8)
