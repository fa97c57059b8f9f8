"""An MCAP file that is whole at every moment: each flush leaves a valid end of file behind (spec 6.3, 7.5).

mcap's own writer puts index and footer at the end of the file when it closes, so a recorder killed before
leaves a file that rosbags refuses. Here every flush writes the finished chunk and a new end in one piece over
the old end. A disk that is full costs what was not flushed: the old end, whose place is still ours, is put
back. Records other than messages are written by the mcap library.
"""

from __future__ import annotations

import functools
import os
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from numpy.typing import NDArray

MAGIC = b"\x89MCAP0\r\n"
LIBRARY = "heli_flight"
"""Named in the header: this file has a footer although its recorder may not have closed it."""

CHUNK_BYTES = 512 * 1024
_MESSAGE = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
_INDEX = struct.Struct("<BQHI")
_FOOTER_HEAD = struct.Struct("<BQQQ")
_FIXED = _MESSAGE.itemsize - 9
_WRITABLE = 0o644

_Block = tuple[NDArray[np.int64], NDArray[np.int64]]
"""Stamps [ns] of messages of one topic, and where in the chunk their records begin."""


class McapFile:
    """Writes one MCAP file.

    Args:
        stem: path of the file without its ending; it must not exist.
        level: of the zstd compression, 0 for none.

    Raises:
        OSError: the file cannot be made.
    """

    suffix = ".mcap"
    identifier = "mcap"

    def __init__(self, stem: Path, level: int = 3) -> None:
        self.path = path = stem.with_name(f"{stem.name}{self.suffix}")
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _WRITABLE)
        self._compress = zstandard.ZstdCompressor(level=level).compress if level else None
        self._pending = bytearray(MAGIC + _record(Header("ros2", LIBRARY)))
        self._position = 0
        self._end = b""
        self._schemas: list[bytes] = []
        self._channels: list[bytes] = []
        self._metadata: list[bytes] = []
        self._chunks = bytearray()
        self._chunk_count = 0
        self._counts: dict[int, int] = {}
        self._first_ns, self._last_ns = 2**63 - 1, 0
        self._buffer: NDArray[np.uint8] = np.empty(2 * CHUNK_BYTES, dtype=np.uint8)
        self._size = self._chunk_last_ns = 0
        self._chunk_first_ns = 2**63 - 1
        self._blocks: dict[int, list[_Block]] = {}

    def add_schema(self, name: str, definition: str, type_hash: str) -> int:  # noqa: ARG002
        """Announce a message type; its hash has its place with the channels."""
        number = len(self._schemas) + 1
        self._schemas.append(_record(Schema(number, definition.encode(), "ros2msg", name)))
        self._pending += self._schemas[-1]
        return number

    def add_channel(self, topic: str, ros_type: str, schema: int, about: Mapping[str, str]) -> int:  # noqa: ARG002
        """Announce a topic of an announced type.

        Args:
            topic: absolute name.
            ros_type: of its messages.
            schema: number of the type.
            about: remarks of rosbag2, `offered_qos_profiles` and `topic_type_hash`.
        """
        number = len(self._channels) + 1
        self._channels.append(_record(Channel(number, topic, "cdr", dict(about), schema)))
        self._pending += self._channels[-1]
        self._counts[number] = 0
        return number

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Append a metadata record; between chunks, so the chunk in the making is closed."""
        self._close_chunk()
        record = _record(Metadata(name, dict(values)))
        place = self._position + len(self._pending)
        self._metadata.append(_record(MetadataIndex(place, len(record), name)))
        self._pending += record

    def add_messages(self, channel: int, stamps: NDArray[np.int64], size: int, data: bytes) -> None:
        """Append messages of one size, written by the next flush; log and publish time of each is its stamp.

        Args:
            channel: of `add_channel`.
            stamps: of the messages [ns], shape (n,).
            size: bytes of each.
            data: the messages behind each other.
        """
        count, record = len(stamps), _record_type(size)
        start, self._size = self._size, self._size + count * record.itemsize
        if self._size > len(self._buffer):
            self._buffer = np.concatenate((self._buffer[:start], np.empty(2 * self._size, dtype=np.uint8)))
        records = self._buffer[start : self._size].view(record)
        head = records["head"]
        head["opcode"], head["length"], head["channel"] = Opcode.MESSAGE, _FIXED + size, channel
        head["sequence"] = self._counts[channel] + np.arange(count)
        head["log_time"] = head["publish_time"] = stamps
        records["data"] = np.frombuffer(data, dtype=record["data"])
        self._counts[channel] += count
        self._blocks.setdefault(channel, []).append((stamps, start + record.itemsize * np.arange(count)))
        self._chunk_first_ns = min(self._chunk_first_ns, int(stamps.min()))
        self._chunk_last_ns = max(self._chunk_last_ns, int(stamps.max()))
        if self._size > CHUNK_BYTES:
            self._close_chunk()

    def flush(self) -> None:
        """Write everything and a new end of the file.

        Raises:
            OSError: the file cannot be written; it ends as after the flush before.
        """
        self._close_chunk()
        data = bytes(self._pending)
        place = self._position + len(data)
        end = self._summary(place)
        try:
            _write_at(self._descriptor, data + end, self._position)
        except OSError:
            _write_at(self._descriptor, self._end, self._position)
            os.truncate(self._descriptor, self._position + len(self._end))
            raise
        self._pending.clear()
        self._position, self._end = place, end

    def close(self, metadata: str) -> None:
        """Finish the file with rosbag2's metadata in it.

        Raises:
            OSError: the file cannot be written.
        """
        self.add_metadata("rosbag2", {"serialized_metadata": metadata})
        try:
            self.flush()
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Close the file as it is."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def _begin_chunk(self) -> None:
        self._blocks = {}
        self._size = self._chunk_last_ns = 0
        self._chunk_first_ns = 2**63 - 1

    def _close_chunk(self) -> None:
        if not self._size:
            return
        data = self._buffer[: self._size].data
        packed = self._compress(data) if self._compress else bytes(data)
        compression = "zstd" if self._compress else ""
        first, last = self._chunk_first_ns, self._chunk_last_ns
        chunk = _record(Chunk(compression, packed, last, first, zlib.crc32(data), len(data)))
        start = self._position + len(self._pending)
        self._pending += chunk
        places = {}
        index_start = len(self._pending)
        for channel, blocks in self._blocks.items():
            places[channel] = self._position + len(self._pending)
            content = np.concatenate([np.column_stack(block) for block in blocks]).astype("<u8").tobytes()
            self._pending += _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(content), channel, len(content))
            self._pending += content
        length = len(self._pending) - index_start
        self._chunks += _record(
            ChunkIndex(len(chunk), start, compression, len(packed), last, length, places, first, len(data))
        )
        self._chunk_count += 1
        self._first_ns, self._last_ns = min(self._first_ns, first), max(self._last_ns, last)
        self._begin_chunk()

    def _summary(self, place: int) -> bytes:
        """What stands behind the data: end of data, summary, footer, magic."""
        count = sum(self._counts.values())
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=self._chunk_count,
            message_count=count,
            message_end_time=self._last_ns,
            message_start_time=self._first_ns if count else 0,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        end = _record(DataEnd(0))
        parts = (*self._schemas, *self._channels, _record(statistics), bytes(self._chunks), *self._metadata)
        summary = b"".join(parts)
        start = place + len(end)
        crc = zlib.crc32(_FOOTER_HEAD.pack(Opcode.FOOTER, 20, start, 0), zlib.crc32(summary))
        return end + summary + _record(Footer(start, 0, crc)) + MAGIC


@functools.cache
def _record_type(size: int) -> np.dtype[np.void]:
    """A message record with so many bytes of data."""
    return np.dtype([("head", _MESSAGE), ("data", f"V{size}")])


def _record(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())


def _write_at(descriptor: int, data: bytes, position: int) -> None:
    view = memoryview(data)
    while view:
        written = os.pwrite(descriptor, view, position)
        position += written
        view = view[written:]
