"""Writing a flight's bag: a rosbag2 folder that is readable at every moment (spec 6.3, 7.5).

The folder has its final name from the first moment. The storage file is flushed every half second of stamps,
is whole after each flush, and metadata.yaml is renewed every second, so that a recorder killed at any time
leaves everything up to half a second before, for every reader. When the disk is full the writer says so once
and the bag ends with the last flush. Messages are kept as they came, log time = publish time = stamp.
"""

from __future__ import annotations

import contextlib
import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import zstandard

from heli_common.errors import InputError
from heli_common.files import write_atomically
from heli_common.topics import TOPICS
from heli_flight.bag_metadata import (
    FLIGHT_RECORD_NAME,
    METADATA_FILE,
    NO_START,
    PACKED_SUFFIX,
    RecordedTopic,
    bag_information,
    dump_yaml,
    metadata_text,
    qos_profile,
    with_topics,
)
from heli_flight.bag_reader import Bag, read_bag, topic_name
from heli_flight.mcap_file import McapFile
from heli_flight.message_definition import message_definition
from heli_flight.sqlite_file import SqliteFile

__all__ = ["STORAGES", "Bag", "BagWriter", "read_bag", "topic_name"]

STORAGES: dict[str, Callable[[Path], McapFile | SqliteFile]] = {
    "mcap": McapFile,
    "sqlite3": SqliteFile,
    "mcap_uncompressed": lambda path: McapFile(path, level=0),
    "mcap_packed": lambda path: McapFile(path, level=0),
    "sqlite3_packed": SqliteFile,
}
"""Ways of storing. Packed: when the bag is closed, zstd compresses the whole file, as rosbag2's mode FILE."""

_PACKING_LEVEL, _WINDOW = 12, 24
FLUSH_INTERVAL_NS = 500_000_000
METADATA_INTERVAL_NS = 1_000_000_000
MOST_WAITING = 4096
"""So many messages are written whatever their stamps say."""


def _no_remarks() -> dict[str, str]:
    return {}


class BagWriter:
    """Writes one bag.

    Args:
        folder: of the bag, final name; made here.
        custom_data: what is known of the flight at its start, see `bag_metadata`.
        storage: one of `STORAGES`.

    Attributes:
        remarks: asked each time the metadata are renewed for what has become known in flight.

    Raises:
        InputError: the folder exists and is not empty, is a file, or cannot be written; no such storage.
    """

    def __init__(
        self, folder: Path, custom_data: Mapping[str, str] | None = None, storage: str = "mcap"
    ) -> None:
        if storage not in STORAGES:
            raise InputError(f"{storage!r} is refused", allowed=", ".join(STORAGES), key="storage")
        self.custom_data = _checked(custom_data or {})
        self.remarks: Callable[[], Mapping[str, str]] = _no_remarks
        self.folder = folder
        self._topics: dict[str, RecordedTopic] = {}
        self._schemas: dict[str, int] = {}
        self._start_ns, self._end_ns = NO_START, 0
        self._next_flush = self._next_metadata = -1
        self._flushed_ns = self._waiting = 0
        self._open = True
        self._packs, self._packed = storage.endswith("_packed"), ""
        try:
            if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
                raise InputError("exists already", allowed="a new or an empty folder", file=folder)
            folder.mkdir(parents=True, exist_ok=True)
            name = f"{folder.resolve().name}_0"
            self._file = STORAGES[storage](folder / name)
            self._file.add_metadata(FLIGHT_RECORD_NAME, self.custom_data)
            self._file.flush()
            self._write_metadata()
        except OSError as error:
            problem = f"cannot be written: {error.strerror or error}"
            raise InputError(problem, allowed="a folder with space", file=folder) from None

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def counts(self) -> dict[str, int]:
        """Messages written so far, by the names given to `add_topic`."""
        self._settle()
        return {name: topic.count for name, topic in self._topics.items()}

    @property
    def losses(self) -> dict[str, dict[str, int]]:
        """Topics with missing stamps: how many messages (`lost`) in how many places (`gaps`)."""
        self._settle()
        return {
            name: {"lost": topic.lost, "gaps": topic.gaps}
            for name, topic in self._topics.items()
            if topic.lost
        }

    def add_topic(
        self, name: str, ros_type: str, *, depth: int = 1000, transient_local: bool = False
    ) -> None:
        """Announce a topic; without messages it is in the bag with a count of zero.

        Args:
            name: of the table of topics, or any other such as `/diagnostics`.
            ros_type: e.g. `sensor_msgs/msg/JointState`; any type of a plain Jazzy installation.
            depth: of the publisher's queue, remembered in the bag.
            transient_local: whether the publisher keeps its messages for those that come later.

        Raises:
            ValueError: the topic is announced already, or the type is unknown.
        """
        if name in self._topics:
            raise ValueError(f"topic {name!r} is announced already")
        definition, type_hash = message_definition(ros_type)
        if ros_type not in self._schemas:
            self._schemas[ros_type] = self._file.add_schema(ros_type, definition, type_hash)
        qos = qos_profile(depth, transient_local)
        absolute = name if name.startswith("/") else f"/{name}"
        about = {"offered_qos_profiles": dump_yaml([qos]), "topic_type_hash": type_hash}
        channel = self._file.add_channel(absolute, ros_type, self._schemas[ros_type], about)
        known = TOPICS.get(topic_name(name))
        period = known.period_ns if known else 0
        self._topics[name] = RecordedTopic(absolute, ros_type, type_hash, qos, period, channel)

    def write(self, topic: str, stamp_ns: int, data: bytes) -> None:
        """Append a serialized message.

        Args:
            topic: as given to `add_topic`.
            stamp_ns: of the message [ns], not negative.
            data: CDR with its encapsulation header.

        Raises:
            ValueError: the topic was not announced.
            OSError: the bag cannot be written any more; said once, what comes later is dropped.
        """
        self.write_all({topic: ((stamp_ns,), (data,))})

    def write_all(self, messages: Mapping[str, tuple[Sequence[int], Sequence[bytes]]]) -> None:
        """Append serialized messages of several topics, which are flushed together or not at all.

        Args:
            messages: by topic as given to `add_topic`, stamps [ns] and as many messages, at least one.

        Raises:
            ValueError, OSError: as `write`.
        """
        if not self._open:
            return
        newest = 0
        for topic, (stamps, data) in messages.items():
            track = self._topics.get(topic)
            if track is None:
                raise ValueError(f"topic {topic!r} was not announced")
            track.stamps += stamps
            track.waiting += data
            self._waiting += len(stamps)
            newest = max(newest, stamps[-1])
        if newest >= self._next_flush or self._waiting >= MOST_WAITING:
            self._flush_or_end(newest)

    def _flush_or_end(self, stamp_ns: int) -> None:
        try:
            self._flush(stamp_ns)
        except OSError as error:
            self._give_up()
            reason = error.strerror or str(error)
            kept = f"the bag ends at {self._flushed_ns * 1e-9:.2f} s"
            raise OSError(f"{self._file.path}: {reason}; {kept}") from None

    def close(self, extra_custom_data: Mapping[str, str] | None = None) -> None:
        """Finish the file and the metadata; a second call does nothing.

        Args:
            extra_custom_data: what became known in flight: late commands, result, parameters changed.

        Raises:
            OSError: the bag cannot be written any more; what was flushed is in it.
        """
        if not self._open:
            return
        self.custom_data |= _checked(extra_custom_data or {})
        self._open = False
        try:
            self._settle()
            self._file.close(dump_yaml(with_topics(self._information(), self._topics.values())))
            if self._packs:
                self._packed = _pack(self._file.path).name
            self._write_metadata()
        except OSError as error:
            raise OSError(f"{self._file.path}: {error.strerror or error}; not closed") from None

    def _give_up(self) -> None:
        """Leave the bag as the last flush left it; a last renewal of the metadata may find no space."""
        self._open = False
        self._file.abandon()
        with contextlib.suppress(OSError):
            self._write_metadata()

    def _settle(self) -> None:
        """Hand what waits to the file, topic by topic."""
        if not self._waiting:
            return
        self._waiting = 0
        for track in self._topics.values():
            if track.waiting:
                stamps, waiting = np.array(track.stamps), track.waiting
                track.stamps, track.waiting = [], []
                track.count_in(stamps)
                self._start_ns = min(self._start_ns, int(stamps.min()))
                self._end_ns = max(self._end_ns, int(stamps.max()))
                for first, last in _same_size(waiting):
                    size, data = len(waiting[first]), b"".join(waiting[first:last])
                    self._file.add_messages(track.channel, stamps[first:last], size, data)

    def _flush(self, stamp_ns: int) -> None:
        self._settle()
        self._file.flush()
        self._flushed_ns = self._end_ns
        self._next_flush = stamp_ns + FLUSH_INTERVAL_NS
        if stamp_ns >= self._next_metadata:
            self._next_metadata = stamp_ns + METADATA_INTERVAL_NS
            self._write_metadata()

    def _information(self) -> dict[str, Any]:
        figures = {"counts": json.dumps(self.counts), "losses": json.dumps(self.losses)}
        custom_data = self.custom_data | _checked(self.remarks()) | figures
        file = self._file
        name = self._packed or file.path.name
        return bag_information(
            name, file.identifier, self._topics.values(), self._start_ns, self._end_ns, custom_data
        )

    def _write_metadata(self) -> None:
        text = metadata_text(self._information(), self._topics.values())
        write_atomically(self.folder / METADATA_FILE, text)


def _same_size(messages: list[bytes]) -> list[tuple[int, int]]:
    """First and behind the last of every run of messages of one size."""
    lengths = (len(list(run)) for _, run in itertools.groupby(messages, len))
    return list(itertools.pairwise(itertools.accumulate(lengths, initial=0)))


def _pack(path: Path) -> Path:
    """Compress a file as a whole in its place."""
    packed = path.with_name(f"{path.name}{PACKED_SUFFIX}")
    settings = zstandard.ZstdCompressionParameters.from_level(_PACKING_LEVEL, window_log=_WINDOW)
    compressor = zstandard.ZstdCompressor(compression_params=settings)
    with path.open("rb") as plain, packed.open("wb") as stream:
        compressor.copy_stream(plain, stream, size=path.stat().st_size)
    path.unlink()
    return packed


def _checked(custom_data: Mapping[str, str]) -> dict[str, str]:
    for key, value in custom_data.items():
        if not isinstance(key, str) or not isinstance(value, str):
            raise ValueError(f"custom data {key!r}: {value!r} is not text")
    return dict(custom_data)
