"""Fixed-layout CDR: one description serves publishing, subscribing and reading bags (spec 7.1).

A ROS message whose strings and array lengths never change has its numbers at constant places. A `Layout`
is that message serialized once, with the places of its stamp and of its float64 numbers; on the wire it is
the standard message, byte for byte what any ROS 2 node sends (little-endian XCDR1, padding zero).
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

ENCAPSULATION = b"\x00\x01\x00\x00"
"""In front of every message: CDR, little-endian."""

_NANOSECONDS = 1_000_000_000
_STAMP = struct.Struct("<iI")


class _Codec:
    """One formatting of bytes to write a message, one `struct` call to read it.

    Args:
        template: the serialized message with stamp and numbers zero.
        stamp_offset: of the stamp.
        runs: offset, index of the first number and how many, of numbers that stand behind each other.

    Attributes:
        runs: offset, first and behind the last number of each.
    """

    def __init__(self, template: bytes, stamp_offset: int, runs: Sequence[tuple[int, int, int]]) -> None:
        self.runs = tuple((offset, first, first + count) for offset, first, count in runs)
        constants, read, end = [template[:stamp_offset]], f"<{stamp_offset}xiI", stamp_offset + _STAMP.size
        for offset, first, last in self.runs:
            constants.append(template[end:offset])
            read += f"{offset - end}x{last - first}d"
            end = offset + 8 * (last - first)
        constants.append(template[end:])
        self._message = b"%b".join(part.replace(b"%", b"%%") for part in constants)
        self._numbers = struct.Struct(f"<{sum(count for _, _, count in runs)}d").pack
        self._cut = _cutter([slice(8 * first, 8 * last) for _, first, last in self.runs])
        self._read = struct.Struct(f"{read}{len(template) - end}x").unpack
        self._latest: tuple[bytes, tuple[int, tuple[float, ...]]] = (b"", (0, ()))

    def pack(self, stamp_ns: int, values: Sequence[float] | Values) -> bytes:
        """The serialized message."""
        if isinstance(values, np.ndarray) and values.dtype.char == "d":
            numbers = values.tobytes()
        else:
            numbers = self._numbers(*values)
        return self._message % (_STAMP.pack(*divmod(stamp_ns, _NANOSECONDS)), *self._cut(numbers))

    def unpack(self, data: bytes) -> tuple[int, tuple[float, ...]]:
        """Stamp [ns] and numbers; nodes of one process that are handed the same object read it once."""
        known, found = self._latest
        if known is not data:
            parts = self._read(data)
            found = (parts[0] * _NANOSECONDS + parts[1], parts[2:])
            self._latest = (data, found)
        return found


def _cutter(slices: Sequence[slice]) -> Callable[[bytes], tuple[bytes, ...]]:
    """Gives the slices of all bytes; a single one is the whole."""
    if len(slices) > 1:
        return itemgetter(*slices)
    return lambda numbers: (numbers,) if slices else ()


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
    _codec: _Codec = field(init=False, repr=False, compare=False)

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
        object.__setattr__(self, "_codec", _Codec(self.template, self.stamp_offset, runs))

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
        return self._codec.pack(stamp_ns, values)

    def unpack(self, data: bytes) -> tuple[int, tuple[float, ...]]:
        """Stamp [ns] and numbers of a serialized message of exactly this layout.

        Raises:
            ValueError: another size, so other names, frames or array lengths than agreed.
        """
        if len(data) != len(self.template):
            raise ValueError(f"{self.ros_type}: {len(data)} bytes instead of {len(self.template)}")
        return self._codec.unpack(data)

    def stamp(self, data: bytes) -> int:
        """The stamp alone [ns] of a serialized message.

        Raises:
            ValueError: another size than agreed.
        """
        if len(data) != len(self.template):
            raise ValueError(f"{self.ros_type}: {len(data)} bytes instead of {len(self.template)}")
        seconds, nanoseconds = _STAMP.unpack_from(data, self.stamp_offset)
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
        for offset, first, last in self._codec.runs:
            values[:, first:last] = rows[:, offset : offset + 8 * (last - first)].view("<f8")
        return stamps, values


def _constant_spans(layout: Layout) -> list[tuple[int, int]]:
    """Byte spans of a template that hold neither stamp nor numbers nor padding: its nonzero bytes."""
    nonzero = [index for index, byte in enumerate(layout.template) if byte and index >= len(ENCAPSULATION)]
    return [(index, index + 1) for index in nonzero]
