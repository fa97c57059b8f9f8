"""Reading a flight's bag, also one that was cut off in flight or lost its metadata (spec 7.5).

The records of an MCAP file follow each other with their lengths, so everything before the cut is readable
without the index at the end of the file, which a killed recorder never wrote.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream

from heli_common.errors import InputError
from heli_common.files import read_yaml
from heli_common.topics import TOPICS
from heli_flight.bag_metadata import METADATA_FILE

_MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_BROKEN = (ValueError, KeyError, struct.error, zstandard.ZstdError)


class BagMessage(NamedTuple):
    """One message as recorded; the topic is relative (`encoders`), the stamp is the bag's log time."""

    topic: str
    stamp_ns: int
    data: bytes


def topic_name(absolute: str) -> str:
    """The name in the table of topics, whatever the namespace; other topics lose only the leading slash."""
    last = absolute.rsplit("/", 1)[-1]
    return last if last in TOPICS else absolute.lstrip("/")


@dataclass(frozen=True)
class Bag:
    """A bag in memory.

    Attributes:
        folder: it came from.
        types: ROS type of every topic, those without messages included.
        stamps: log times [ns] of every topic in the order of the file.
        messages: serialized messages, in the same order.
        custom_data: remarks of the recorder, see `bag_metadata`.
        problems: what is missing or damaged; empty when the bag is whole.
    """

    folder: Path
    types: dict[str, str]
    stamps: dict[str, list[int]]
    messages: dict[str, list[bytes]]
    custom_data: dict[str, str]
    problems: tuple[str, ...]

    @property
    def complete(self) -> bool:
        """Whether the recorder closed the bag and nothing is damaged."""
        return not self.problems

    @property
    def counts(self) -> dict[str, int]:
        """Messages per topic."""
        return {topic: len(messages) for topic, messages in self.messages.items()}


class BagReader:
    """Goes through the messages of a bag in the order of recording.

    Args:
        folder: a rosbag2 folder with MCAP storage, or an MCAP file.

    Attributes:
        types: ROS type by topic; complete after `messages` has come to its end.
        custom_data: of the metadata.
        problems: what is missing or damaged; complete after `messages` has come to its end.

    Raises:
        InputError: no such folder, or no MCAP file in it.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.parent if folder.is_file() else folder
        self.types: dict[str, str] = {}
        self.custom_data: dict[str, str] = {}
        self.problems: list[str] = []
        self._promised: int | None = None
        names = self._read_metadata()
        self._files = [folder] if folder.is_file() else self._storage_files(names)
        self._topics: dict[int, str] = {}
        self._schemas: dict[int, str] = {}

    def messages(self) -> Iterator[BagMessage]:
        """Every readable message, in the order of the file.

        Raises:
            InputError: the file is no MCAP file, or two of its topics differ in their namespace only.
        """
        count = 0
        for path in self._files:
            self._topics, self._schemas = {}, {}
            with path.open("rb") as stream:
                for message in self._file_messages(path, stream):
                    count += 1
                    yield message
        if self._promised is not None and not self.problems and count != self._promised:
            self.problems.append(f"{METADATA_FILE} counts {self._promised} messages, the bag holds {count}")

    def _read_metadata(self) -> list[str]:
        """Names of the storage files in their order; remembers custom data and the number of messages."""
        path = self.folder / METADATA_FILE
        if not path.exists():
            if self.folder.is_dir():
                self.problems.append(f"{METADATA_FILE} is missing")
            return []
        try:
            information = read_yaml(path)["rosbag2_bagfile_information"]
            custom = information.get("custom_data") or {}
            self.custom_data = {str(key): str(value) for key, value in custom.items()}
            self._promised = int(information["message_count"])
            return [Path(name).name for name in information["relative_file_paths"]]
        except (InputError, KeyError, TypeError, ValueError, AttributeError):
            self.problems.append(f"{METADATA_FILE} is unreadable")
            return []

    def _storage_files(self, names: list[str]) -> list[Path]:
        if not self.folder.is_dir():
            raise InputError("no such bag", allowed="a rosbag2 folder or an MCAP file", file=self.folder)
        listed = [self.folder / name for name in names if (self.folder / name).exists()]
        found = sorted(self.folder.glob("*.mcap"), key=lambda path: (len(path.name), path.name))
        files = [path for path in listed if path.suffix == ".mcap"] or found
        if not files:
            raise InputError("holds no MCAP file", allowed="a rosbag2 folder", file=self.folder)
        return files

    def _file_messages(self, path: Path, stream: BinaryIO) -> Iterator[BagMessage]:
        magic = stream.read(len(_MAGIC))
        if magic != _MAGIC[: len(magic)]:
            raise InputError("is no MCAP file", file=path)
        closed = False
        for opcode, payload, whole in _records(stream, path.stat().st_size):
            if not whole:
                break
            closed = closed or opcode == Opcode.DATA_END
            try:
                yield from self._record_messages(opcode, payload)
            except InputError:
                raise
            except _BROKEN as error:
                self.problems.append(f"a damaged part was left out: {error}")
        if not closed:
            self.problems.append("the file was cut off: the recorder did not close it")

    def _record_messages(self, opcode: int, payload: bytes) -> Iterator[BagMessage]:
        if opcode == Opcode.CHUNK:
            stream, size = get_chunk_data_stream(Chunk.read(_stream(payload)), validate_crc=True)
            yield from self._chunk_messages(stream.read(size))
        elif opcode == Opcode.MESSAGE:
            channel, _, stamp, _ = _MESSAGE.unpack_from(payload)
            yield BagMessage(self._topics[channel], stamp, payload[_MESSAGE.size :])
        elif opcode == Opcode.METADATA:
            record = Metadata.read(_stream(payload))
            if record.name == "heli_flight":
                self.custom_data = {**record.metadata, **self.custom_data}
        else:
            self._note(opcode, payload)

    def _chunk_messages(self, data: bytes) -> Iterator[BagMessage]:
        topics, place = self._topics, 0
        while place < len(data):
            opcode, length = _HEAD.unpack_from(data, place)
            place += _HEAD.size
            if opcode == Opcode.MESSAGE:
                channel, _, stamp, _ = _MESSAGE.unpack_from(data, place)
                yield BagMessage(topics[channel], stamp, data[place + _MESSAGE.size : place + length])
            else:
                self._note(opcode, data[place : place + length])
            place += length

    def _note(self, opcode: int, payload: bytes) -> None:
        """Learn schemas and channels, also from the repetition at the file's end; nothing else is of use."""
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(_stream(payload))
            self._schemas[schema.id] = schema.name
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(_stream(payload))
            name = topic_name(channel.topic)
            if self._topics.get(channel.id, name) != name or name in {
                known for number, known in self._topics.items() if number != channel.id
            }:
                raise InputError(f"topic {name!r} occurs twice", file=self.folder)
            self._topics[channel.id] = name
            self.types[name] = self._schemas.get(channel.schema_id, "")


def read_bag(folder: Path) -> Bag:
    """The whole bag; one that was cut off up to its last readable message.

    Raises:
        InputError: no such folder, no MCAP file in it, or not an MCAP file.
    """
    reader = BagReader(folder)
    stamps: dict[str, list[int]] = {}
    messages: dict[str, list[bytes]] = {}
    for topic, stamp_ns, data in reader.messages():
        if topic not in stamps:
            stamps[topic], messages[topic] = [], []
        stamps[topic].append(stamp_ns)
        messages[topic].append(data)
    for topic in reader.types:
        stamps.setdefault(topic, [])
        messages.setdefault(topic, [])
    return Bag(
        reader.folder, dict(reader.types), stamps, messages, reader.custom_data, tuple(reader.problems)
    )


def _stream(payload: bytes) -> Any:
    return ReadDataStream(BytesIO(payload))


def _records(stream: BinaryIO, size: int) -> Iterator[tuple[int, bytes, bool]]:
    """Opcode and content of every record, and whether it is all there."""
    while True:
        head = stream.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return
        opcode, length = _HEAD.unpack(head)
        if length > size - stream.tell():
            yield opcode, b"", False
            return
        yield opcode, stream.read(length), True
