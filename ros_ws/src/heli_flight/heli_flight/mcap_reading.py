"""Reading an MCAP file, whole, cut off anywhere, or damaged (spec 7.5).

Its records follow each other with their lengths, so everything before a cut is readable without the index at
the end. Behind each chunk stands where its messages are, by topic: with that a topic's messages of one size
leave the chunk in one go. Every place is checked, and a chunk whose index is missing or wrong is gone through
message by message.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_flight.bag_metadata import FLIGHT_RECORD_NAME
from heli_flight.mcap_file import LIBRARY, MAGIC
from heli_flight.packed import Stamps, Table
from heli_flight.storage_content import StorageContent

_HEAD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
_MESSAGE = struct.Struct("<HIQQ")
_MESSAGE_HEAD = np.dtype(
    {
        "names": ["opcode", "length", "channel", "log"],
        "formats": ["u1", "<u8", "<u2", "<u8"],
        "offsets": [0, 1, 9, 15],
        "itemsize": 31,
    }
)
_BROKEN = (ValueError, KeyError, EOFError, MemoryError, struct.error, zstandard.ZstdError, McapError)

Piece = tuple[int, Stamps, "Table | list[bytes]", int]
"""Channel, log times [ns], messages, bytes that their records take."""


def read_mcap(path: Path) -> StorageContent:
    """Everything readable in a file.

    Raises:
        InputError: the file is no MCAP file, or two of its topics differ in their namespace only.
    """
    reader = _Reader(path)
    if path.stat().st_size:
        with (
            path.open("rb") as stream,
            mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content,
            memoryview(content) as data,
        ):
            reader.read(data)
    else:
        reader.end(whole=False)
    return reader.content


class _Reader:
    def __init__(self, path: Path) -> None:
        self.content = StorageContent(path)
        self._schemas: dict[int, str] = {}
        self._own = self._sealed = False
        self._chunk: bytes | None = None
        self._indexes: list[bytes] = []

    def read(self, data: memoryview) -> None:
        if bytes(data[: len(MAGIC)]) != MAGIC[: len(data)]:
            raise InputError("is no MCAP file", file=self.content.path)
        place, whole = len(MAGIC), False
        while place + _HEAD.size <= len(data):
            opcode, length = _HEAD.unpack_from(data, place)
            place += _HEAD.size
            complete = length <= len(data) - place
            payload = bytes(data[place : place + length])
            place += length
            whole = whole or opcode == Opcode.DATA_END
            self._attempt(opcode, payload, complete)
            if not complete:
                break
        self._attempt(Opcode.FOOTER, b"", complete=True)
        self.end(whole)

    def end(self, whole: bool) -> None:
        """Say whether the recorder finished; our own files have an end of data at every moment."""
        self.content.closed = whole and (self._sealed or not self._own)
        if not whole:
            self.content.problems.append("the file was cut off: the recorder did not close it")
        elif not self.content.closed:
            self.content.problems.append("the recorder did not close it")

    def _attempt(self, opcode: int, payload: bytes, complete: bool) -> None:
        try:
            if opcode == Opcode.MESSAGE_INDEX and complete:
                self._indexes.append(payload)
                return
            self._finish_chunk()
            if complete:
                self._record(opcode, payload)
            elif opcode == Opcode.CHUNK:
                self._scan(_beginning(payload), cut=True)
        except InputError:
            raise
        except _BROKEN as error:
            self.content.problems.append(f"a damaged part was left out: {error or type(error).__name__}")

    def _record(self, opcode: int, payload: bytes) -> None:
        if opcode == Opcode.CHUNK:
            self._chunk = _chunk_content(payload)
        elif opcode == Opcode.MESSAGE:
            channel, _, stamp, _ = _MESSAGE.unpack_from(payload)
            self.content.of(channel).add([stamp], [payload[_MESSAGE.size :]])
        elif opcode == Opcode.METADATA:
            record = Metadata.read(_stream(payload))
            self._sealed = self._sealed or record.name == "rosbag2"
            if record.name == FLIGHT_RECORD_NAME:
                self.content.custom_data |= record.metadata
        elif opcode == Opcode.HEADER:
            self._own = Header.read(_stream(payload)).library == LIBRARY
        else:
            self._note(opcode, payload)

    def _note(self, opcode: int, payload: bytes) -> None:
        """Learn schemas and channels, also from the repetition at the file's end; nothing else is of use."""
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(_stream(payload))
            self._schemas[schema.id] = schema.name
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(_stream(payload))
            self.content.announce(channel.id, channel.topic, self._schemas.get(channel.schema_id, ""))

    def _finish_chunk(self) -> None:
        """Take the messages of the chunk before, now that its index has been read."""
        data, indexes = self._chunk, self._indexes
        self._chunk, self._indexes = None, []
        if data is None:
            return
        pieces = _pieces(data, indexes)
        if pieces is None:
            self._scan(data)
            return
        places = [self.content.of(channel) for channel, *_ in pieces]
        for blocks, (_, stamps, messages, _) in zip(places, pieces, strict=True):
            blocks.add(stamps, messages)

    def _scan(self, data: bytes, cut: bool = False) -> None:
        """Go through the records of a chunk one by one."""
        place = 0
        while place + _HEAD.size <= len(data):
            opcode, length = _HEAD.unpack_from(data, place)
            place += _HEAD.size
            if length > len(data) - place:
                if cut:
                    return
                raise ValueError(f"a record of {length} bytes reaches beyond its chunk")
            if opcode == Opcode.MESSAGE:
                channel, _, stamp, _ = _MESSAGE.unpack_from(data, place)
                self.content.of(channel).add([stamp], [data[place + _MESSAGE.size : place + length]])
            else:
                self._note(opcode, data[place : place + length])
            place += length


def _chunk_content(payload: bytes) -> bytes:
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


def _beginning(payload: bytes) -> bytes:
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


def _pieces(data: bytes, indexes: list[bytes]) -> list[Piece] | None:
    """The messages of a chunk by topic; None if the index does not account for every byte of the chunk."""
    try:
        pieces = [_piece(data, payload) for payload in indexes]
    except _BROKEN:
        return None
    return pieces if sum(piece[3] for piece in pieces) == len(data) else None


def _piece(data: bytes, payload: bytes) -> Piece:
    """The messages of one topic in a chunk.

    Raises:
        ValueError: the index does not lead to messages of this topic.
    """
    channel, length = struct.unpack_from("<HI", payload)
    entries = np.frombuffer(payload, "<u8", length // 16 * 2, 6).reshape(-1, 2)
    places = np.sort(entries[:, 1]).astype(np.int64)
    if not len(places):
        return channel, np.empty(0, np.int64), [], 0
    if places[-1] > len(data) - _MESSAGE_HEAD.itemsize or places[0] < 0:
        raise ValueError("a place outside of the chunk")
    heads = _windows(data, _MESSAGE_HEAD)[places]
    if not ((heads["opcode"] == Opcode.MESSAGE) & (heads["channel"] == channel)).all():
        raise ValueError("no message of this topic at its place")
    sizes = heads["length"].astype(np.int64) - _MESSAGE.size
    ends = places + _MESSAGE_HEAD.itemsize + sizes
    if (sizes < 0).any() or (ends > len(data)).any():
        raise ValueError("a message reaches beyond its chunk")
    stamps = heads["log"].astype(np.int64)
    taken = len(places) * _MESSAGE_HEAD.itemsize + int(sizes.sum())
    size = int(sizes[0])
    starts = places + _MESSAGE_HEAD.itemsize
    if size and (sizes == size).all():
        rows = _windows(data, np.dtype(f"V{size}"))[starts]
        return channel, stamps, rows.view(np.uint8).reshape(len(places), size), taken
    bounds = zip(starts.tolist(), ends.tolist(), strict=True)
    return channel, stamps, [data[start:end] for start, end in bounds], taken


def _windows(data: bytes, dtype: np.dtype[Any]) -> NDArray[Any]:
    """What would stand at every place of the data, without copying."""
    count = len(data) - dtype.itemsize + 1
    return np.ndarray((count,), dtype, data, strides=(1,))


def _stream(payload: bytes) -> Any:
    return ReadDataStream(BytesIO(payload))
