"""Fixed-layout CDR: one description serves publishing, subscribing and reading bags (spec 7.1).

A ROS message whose strings and array lengths never change has its numbers at constant places. A `Layout`
is that message serialized once, with the places of its stamp and of its float64 numbers; on the wire it is
the standard message, byte for byte what any ROS 2 node sends (little-endian XCDR1, padding zero).
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

_ENCAPSULATION = b"\x00\x01\x00\x00"
_NANOSECONDS = 1_000_000_000


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
        start = len(self.data) + len(_ENCAPSULATION)
        self.number_offsets += range(start, start + 8 * count, 8)
        self.data += bytes(8 * count)


@dataclass(frozen=True)
class Layout:
    """Where the stamp and the numbers of one kind of message stand.

    Attributes:
        ros_type: e.g. `sensor_msgs/msg/JointState`.
        fields: a name per number, in the order of `values` everywhere in this project.
        template: the serialized message with stamp and numbers zero.
        stamp_offset: byte offset of `int32 sec, uint32 nanosec`.
        offsets: byte offset of every number.
    """

    ros_type: str
    fields: tuple[str, ...]
    template: bytes
    stamp_offset: int
    offsets: tuple[int, ...]

    def __post_init__(self) -> None:
        if len(self.fields) != len(self.offsets):
            raise ValueError(f"{self.ros_type}: {len(self.fields)} names for {len(self.offsets)} numbers")
        if len(self.template) % 4:
            # the middleware pads a payload to four bytes, a serializer does not: the sizes would differ
            raise ValueError(f"{self.ros_type}: {len(self.template)} bytes are no multiple of four")
        runs: list[tuple[int, int, int]] = []
        for index, offset in enumerate(self.offsets):
            if runs and offset == runs[-1][0] + 8 * runs[-1][2]:
                runs[-1] = (runs[-1][0], runs[-1][1], runs[-1][2] + 1)
            else:
                runs.append((offset, index, 1))
        skipped = f"<{self.stamp_offset}xiI"
        end, plan = self.stamp_offset + 8, []
        for offset, first, n in runs:
            skipped += f"{offset - end}x{n}d"
            plan.append((self.template[end:offset], offset, first, first + n))
            end = offset + 8 * n
        rest = len(self.template) - end
        object.__setattr__(self, "_runs", tuple(plan))
        object.__setattr__(self, "_ends", (self.template[: self.stamp_offset], self.template[end:]))
        object.__setattr__(self, "_numbers", struct.Struct(f"<{len(self.fields)}d").pack)
        object.__setattr__(self, "_unpack", struct.Struct(f"{skipped}{rest}x").unpack)
        object.__setattr__(self, "_stamp", struct.Struct("<iI"))

    @property
    def size(self) -> int:
        """Bytes of a serialized message, encapsulation header included."""
        return len(self.template)

    def pack(self, stamp_ns: int, values: Sequence[float] | Values) -> bytes:
        """The serialized message.

        Args:
            stamp_ns: simulated time [ns].
            values: one number per field.

        Raises:
            ValueError: the number of values does not fit the layout.
        """
        if len(values) != len(self.fields):
            raise ValueError(f"{self.ros_type}: {len(values)} values for {len(self.fields)} fields")
        if isinstance(values, np.ndarray) and values.dtype.char == "d":
            numbers = values.tobytes()
        else:
            numbers = self._numbers(*values)  # type: ignore[attr-defined]
        head, tail = self._ends  # type: ignore[attr-defined]
        parts = [head, self._stamp.pack(*divmod(stamp_ns, _NANOSECONDS))]  # type: ignore[attr-defined]
        for constant, _, first, last in self._runs:  # type: ignore[attr-defined]
            parts.append(constant)
            parts.append(numbers[8 * first : 8 * last])
        parts.append(tail)
        return b"".join(parts)

    def unpack(self, data: bytes) -> tuple[int, tuple[float, ...]]:
        """Stamp [ns] and numbers of a serialized message of exactly this layout.

        Raises:
            ValueError: another size, so other names, frames or array lengths than agreed.
        """
        if len(data) != len(self.template):
            raise ValueError(f"{self.ros_type}: {len(data)} bytes instead of {len(self.template)}")
        found = self._unpack(data)  # type: ignore[attr-defined]
        return found[0] * _NANOSECONDS + found[1], found[2:]

    def stamp(self, data: bytes) -> int:
        """The stamp alone [ns] of a serialized message.

        Raises:
            ValueError: another size than agreed.
        """
        if len(data) != len(self.template):
            raise ValueError(f"{self.ros_type}: {len(data)} bytes instead of {len(self.template)}")
        seconds, nanoseconds = self._stamp.unpack_from(data, self.stamp_offset)  # type: ignore[attr-defined]
        return int(seconds * _NANOSECONDS + nanoseconds)

    def canonical(self, data: bytes) -> bytes:
        """The same message as this codec writes it: constants checked, padding zero.

        Raises:
            ValueError: a constant part (names, frames, lengths) differs from the agreed one.
        """
        again = self.pack(*self.unpack(data))
        if again != data and self._constants(again) != self._constants(data):
            raise ValueError(f"{self.ros_type}: names, frames or lengths differ from the agreed layout")
        return again

    def _constants(self, data: bytes) -> list[bytes]:
        """The strings and lengths of a message, without padding, stamp and numbers."""
        return [bytes(data[first:last]) for first, last in _constant_spans(self)]

    @property
    def dtype(self) -> np.dtype[np.void]:
        """Structured type over a whole serialized message, for `numpy.frombuffer` on many of them."""
        names = ["sec", "nanosec", *self.fields]
        formats = ["<i4", "<u4", *["<f8"] * len(self.fields)]
        offsets = [self.stamp_offset, self.stamp_offset + 4, *self.offsets]
        spec = {"names": names, "formats": formats, "offsets": offsets, "itemsize": self.size}
        return np.dtype(spec)  # type: ignore[call-overload,no-any-return]

    def read(self, messages: Sequence[bytes]) -> tuple[NDArray[np.int64], Values]:
        """Many messages at once.

        Returns:
            stamps [ns], shape (n,), and numbers, shape (n, len(fields)).
        """
        for data in messages:
            if len(data) != self.size:
                raise ValueError(f"{self.ros_type}: {len(data)} bytes instead of {self.size}")
        table = np.frombuffer(b"".join(messages), dtype=np.uint8)
        return self.read_table(table.reshape(len(messages), self.size))

    def read_table(self, table: NDArray[np.uint8]) -> tuple[NDArray[np.int64], Values]:
        """Many messages at once that stand behind each other, one per row.

        Returns:
            stamps [ns], shape (n,), and numbers, shape (n, len(fields)).

        Raises:
            ValueError: a row is no message of this layout.
        """
        if table.shape[1] != self.size:
            raise ValueError(f"{self.ros_type}: {table.shape[1]} bytes instead of {self.size}")
        rows = np.ascontiguousarray(table)
        stamp = rows[:, self.stamp_offset : self.stamp_offset + 8].copy().view("<u4").astype(np.int64)
        stamps = stamp[:, 0].astype(np.int32) * np.int64(_NANOSECONDS) + stamp[:, 1]
        values = np.empty((len(rows), len(self.fields)))
        for _, offset, first, last in self._runs:  # type: ignore[attr-defined]
            values[:, first:last] = rows[:, offset : offset + 8 * (last - first)].view("<f8")
        return stamps, values


def _constant_spans(layout: Layout) -> list[tuple[int, int]]:
    """Byte spans of a template that hold neither stamp nor numbers nor padding: its nonzero bytes."""
    nonzero = [index for index, byte in enumerate(layout.template) if byte and index >= len(_ENCAPSULATION)]
    return [(index, index + 1) for index in nonzero]


def _finish(ros_type: str, writer: _CdrWriter, fields: Sequence[str], stamp_offset: int = 4) -> Layout:
    template = _ENCAPSULATION + bytes(writer.data)
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
