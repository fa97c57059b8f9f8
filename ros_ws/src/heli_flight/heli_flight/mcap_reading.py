"""Reading an MCAP file, whole, cut off anywhere, or damaged (spec 7.5).

Its records follow each other with their lengths, so everything before a cut is readable without the index at
the end. A chunk whose index is missing or wrong is gone through message by message.
"""

from __future__ import annotations

import mmap
import struct
from collections import Counter
from io import BytesIO
from pathlib import Path
from typing import Any

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Header, Metadata, Schema

from heli_common.errors import InputError
from heli_flight.bag_metadata import FLIGHT_RECORD_NAME
from heli_flight.mcap_chunks import BROKEN, beginning, chunk_content, expected_counts, pieces
from heli_flight.mcap_file import LIBRARY, MAGIC
from heli_flight.storage_content import StorageContent

_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_GROUP_BYTES = 8_000_000


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
        self._group: list[tuple[bytes, list[bytes]]] = []
        self._group_bytes = 0
        self._expected: Counter[int] = Counter()

    def read(self, data: memoryview) -> None:
        if bytes(data[: len(MAGIC)]) != MAGIC[: len(data)]:
            raise InputError("is no MCAP file", file=self.content.path)
        self._expected = expected_counts(data)
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
        self._finish_group()
        self.end(whole)
        if whole and bytes(data[-len(MAGIC) :]) != MAGIC:
            self.content.problems.append("the index at the end of the file is cut off")

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
                self._finish_group()
                self._scan(beginning(payload), cut=True)
        except InputError:
            raise
        except BROKEN as error:
            self._leave_out(error)

    def _record(self, opcode: int, payload: bytes) -> None:
        if opcode == Opcode.CHUNK:
            self._chunk = chunk_content(payload)
        elif opcode == Opcode.MESSAGE:
            self._finish_group()
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
        """Put the chunk before, now that its index has been read, to those that are taken apart together."""
        if self._chunk is not None:
            self._group.append((self._chunk, self._indexes))
            self._group_bytes += len(self._chunk)
        self._chunk, self._indexes = None, []
        if self._group_bytes > _GROUP_BYTES:
            self._finish_group()

    def _finish_group(self) -> None:
        """Take the messages of several chunks, each topic's in one go."""
        group, self._group, self._group_bytes = self._group, [], 0
        if len(group) > 1 and self._take(group):
            return
        for chunk in group:
            try:
                if not self._take([chunk]):
                    self._scan(chunk[0])
            except InputError:
                raise
            except BROKEN as error:
                self._leave_out(error)

    def _take(self, group: list[tuple[bytes, list[bytes]]]) -> bool:
        """Whether the indexes of these chunks lead to every message in them, which then are taken."""
        data = b"".join(content for content, _ in group) if len(group) > 1 else group[0][0]
        try:
            found = pieces(data, group)
            places = [self.content.of(piece.channel) for piece in found]
        except BROKEN:
            return False
        for blocks, piece in zip(places, found, strict=True):
            if piece.size:
                blocks.expected = self._expected[piece.channel]
                blocks.add_rows(piece.stamps, data, piece.starts, piece.size)
            else:
                bounds = zip(piece.starts.tolist(), piece.ends.tolist(), strict=True)
                blocks.add(piece.stamps, [data[start:end] for start, end in bounds])
        return True

    def _leave_out(self, error: BaseException) -> None:
        self.content.problems.append(f"a damaged part was left out: {error or type(error).__name__}")

    def _scan(self, data: bytes, cut: bool = False) -> None:
        """Go through the records of a chunk one by one."""
        found: dict[int, tuple[list[int], list[bytes]]] = {}
        place = 0
        try:
            while place + _HEAD.size <= len(data):
                opcode, length = _HEAD.unpack_from(data, place)
                place += _HEAD.size
                if length > len(data) - place:
                    if cut:
                        break
                    raise ValueError(f"a record of {length} bytes reaches beyond its chunk")
                if opcode == Opcode.MESSAGE:
                    channel, _, stamp, _ = _MESSAGE.unpack_from(data, place)
                    stamps, messages = found.setdefault(channel, ([], []))
                    stamps.append(stamp)
                    messages.append(data[place + _MESSAGE.size : place + length])
                else:
                    self._note(opcode, data[place : place + length])
                place += length
        finally:
            for channel, (stamps, messages) in found.items():
                self.content.of(channel).add(stamps, messages)


def _stream(payload: bytes) -> Any:
    return ReadDataStream(BytesIO(payload))
