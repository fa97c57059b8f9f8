"""The chunks of an MCAP file: unpacked, and where the messages of each topic are in them.

Behind each chunk stands where its messages are, by topic: with that a topic's messages of one size leave the
chunks in one go. Every place is checked.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.stream_reader import get_chunk_data_stream
from numpy.typing import NDArray

from heli_flight.mcap_file import MAGIC
from heli_flight.packed import Stamps

_HEAD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
_MESSAGE = struct.Struct("<HIQQ")
_BEGIN = struct.Struct("<BQH")
_INDEX = struct.Struct("<HI")
_MESSAGE_HEAD = np.dtype(
    {
        "names": ["opcode", "length", "channel", "log"],
        "formats": ["u1", "<u8", "<u2", "<u8"],
        "offsets": [0, 1, 9, 15],
        "itemsize": 31,
    }
)
_HEAD_BYTES = np.dtype(f"V{_MESSAGE_HEAD.itemsize}")
BROKEN = (ValueError, KeyError, EOFError, MemoryError, struct.error, zstandard.ZstdError, McapError)


class Piece(NamedTuple):
    """Messages of one topic in a chunk: log times [ns], from, to; `size` is 0 if they differ in size."""

    channel: int
    stamps: Stamps
    starts: Stamps
    ends: Stamps
    size: int


def expected_counts(data: memoryview) -> Counter[int]:
    """Messages by channel, as the indexes say."""
    counts: Counter[int] = Counter()
    place = len(MAGIC)
    while place + _HEAD.size + _INDEX.size <= len(data):
        opcode, length = _HEAD.unpack_from(data, place)
        place += _HEAD.size
        if opcode == Opcode.MESSAGE_INDEX and length <= len(data) - place:
            channel, _ = _INDEX.unpack_from(data, place)
            counts[channel] += (length - _INDEX.size) // 16
        place += length
    return counts


def chunk_content(payload: bytes) -> bytes:
    """The records in a chunk, its checksum verified."""
    *_, size, crc, name_length = _CHUNK.unpack_from(payload)
    name = payload[_CHUNK.size : _CHUNK.size + name_length]
    packed = memoryview(payload)[_CHUNK.size + name_length + 8 :]
    if name == b"zstd":
        if zstandard.frame_content_size(packed) not in (size, -1):
            raise ValueError("a chunk is not as long as it says")
        data = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    elif name == b"":
        data = bytes(packed)
    else:
        stream, _ = get_chunk_data_stream(Chunk.read(_stream(payload)), validate_crc=True)
        data = bytes(stream.read(size))
    if len(data) != size or (crc and zlib.crc32(data) != crc):
        raise ValueError("a chunk's checksum is wrong")
    return data


def beginning(payload: bytes) -> bytes:
    """What can be unpacked of the beginning of a chunk."""
    if len(payload) < _CHUNK.size:
        return b""
    name_length = _CHUNK.unpack_from(payload)[-1]
    name = payload[_CHUNK.size : _CHUNK.size + name_length]
    packed = payload[_CHUNK.size + name_length + 8 :]
    if name == b"":
        return packed
    return (
        zstandard.ZstdDecompressor().decompressobj().decompress(packed) if name == b"zstd" and packed else b""
    )


def pieces(data: bytes, group: list[tuple[bytes, list[bytes]]]) -> list[Piece]:
    """The messages by topic of chunks that were joined to `data`.

    Raises:
        ValueError: the indexes do not account for every byte.
    """
    found: dict[int, list[Stamps]] = {}
    base = 0
    for content, indexes in group:
        for payload in indexes:
            channel, length = _INDEX.unpack_from(payload)
            entries = np.frombuffer(payload, "<i8", length // 16 * 2, _INDEX.size)[1::2]
            if len(entries):
                found.setdefault(channel, []).append(entries + base)
        base += len(content)
    pieces = [_piece(data, channel, np.sort(np.concatenate(places))) for channel, places in found.items()]
    heads = sum(len(piece.starts) for piece in pieces) * _MESSAGE_HEAD.itemsize
    if heads + sum(int((piece.ends - piece.starts).sum()) for piece in pieces) != len(data):
        raise ValueError("the index does not lead to every message")
    return pieces


def _piece(data: bytes, channel: int, places: Stamps) -> Piece:
    """The messages of one topic by the places of their records, ascending.

    Raises:
        ValueError: what stands there is no message of this topic.
    """
    last = len(data) - _MESSAGE_HEAD.itemsize
    if places[-1] > last or places[0] < 0:
        raise ValueError("a place outside of the chunk")
    # every place of the data as the head of a message, without copying; then those that are one
    rows: NDArray[np.void] = np.ndarray((last + 1,), _HEAD_BYTES, data, strides=(1,))[places]
    heads = rows.view(_MESSAGE_HEAD)
    starts = places + _MESSAGE_HEAD.itemsize
    size = int(heads["length"][0]) - _MESSAGE.size
    begin = np.frombuffer(_BEGIN.pack(Opcode.MESSAGE, size + _MESSAGE.size, channel), np.uint8)
    if (rows.view(np.uint8).reshape(-1, _MESSAGE_HEAD.itemsize)[:, : _BEGIN.size] == begin).all():
        ends = starts + size
    else:
        if not ((heads["opcode"] == Opcode.MESSAGE) & (heads["channel"] == channel)).all():
            raise ValueError("no message of this topic at its place")
        ends = starts + heads["length"].view(np.int64) - _MESSAGE.size
        size = 0
    if (ends < starts).any() or ends.max() > len(data):
        raise ValueError("a message reaches beyond its chunk")
    return Piece(channel, heads["log"].astype(np.int64), starts, ends, size)


def _stream(payload: bytes) -> Any:
    return ReadDataStream(BytesIO(payload))
