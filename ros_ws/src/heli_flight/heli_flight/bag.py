"""Writing a flight's bag: a rosbag2 folder that is readable at every moment (spec 6.3, 7.5).

The folder has its final name from the first moment. MCAP chunks are closed and flushed every half second of
stamps and metadata.yaml is renewed every second, so that a recorder killed at any time leaves everything up
to half a second before. Messages are kept as they came, log time = publish time = stamp.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from heli_common.errors import InputError
from heli_common.files import write_atomically
from heli_common.topics import TOPICS
from heli_flight.bag_metadata import (
    METADATA_FILE,
    NO_START,
    RecordedTopic,
    bag_information,
    dump_yaml,
    qos_profile,
)
from heli_flight.bag_reader import Bag, BagReader, read_bag, topic_name

__all__ = ["Bag", "BagReader", "BagWriter", "read_bag", "topic_name"]

FLUSH_INTERVAL_NS = 500_000_000
METADATA_INTERVAL_NS = 1_000_000_000
CHUNK_BYTES = 512 * 1024
FLIGHT_RECORD_NAME = "heli_flight"
"""MCAP metadata record at the head of the file: the custom data known at the start."""


class BagWriter:
    """Writes one bag.

    Args:
        folder: of the bag, final name; made here.
        custom_data: what is known of the flight at its start, see `bag_metadata`.

    Raises:
        InputError: the folder exists and is not empty, or is a file.
    """

    def __init__(self, folder: Path, custom_data: Mapping[str, str] | None = None) -> None:
        if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
            raise InputError("exists already", allowed="a new or an empty folder", file=folder)
        self.folder = folder
        self.custom_data = _checked(custom_data or {})
        self._topics: dict[str, RecordedTopic] = {}
        self._schemas: dict[str, int] = {}
        self._start_ns, self._end_ns = NO_START, 0
        self._next_flush = self._next_metadata = -1
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / f"{folder.resolve().name}_0.mcap"
        self._stream = self._path.open("wb")
        self._writer = Writer(self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library="heli_flight")
        self._writer.add_metadata(FLIGHT_RECORD_NAME, self.custom_data)
        self._writer.flush()
        self._write_metadata()

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def counts(self) -> dict[str, int]:
        """Messages written so far, by the names given to `add_topic`."""
        return {name: topic.count for name, topic in self._topics.items()}

    @property
    def losses(self) -> dict[str, dict[str, int]]:
        """Topics with missing stamps: how many messages (`lost`) in how many places (`gaps`)."""
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
        definition, type_hash = _message_definition(ros_type)
        if ros_type not in self._schemas:
            self._schemas[ros_type] = self._writer.register_schema(ros_type, "ros2msg", definition.encode())
        qos = qos_profile(depth, transient_local)
        absolute = name if name.startswith("/") else f"/{name}"
        about = {"offered_qos_profiles": dump_yaml([qos]), "topic_type_hash": type_hash}
        channel = self._writer.register_channel(absolute, "cdr", self._schemas[ros_type], about)
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
        """
        track = self._topics.get(topic)
        if track is None:
            raise ValueError(f"topic {topic!r} was not announced")
        self._writer.add_message(track.channel, stamp_ns, data, stamp_ns, track.count)
        track.count += 1
        if track.period_ns and stamp_ns - track.last_ns != track.period_ns:
            self._note_gap(track, stamp_ns)
        track.last_ns = stamp_ns
        if stamp_ns < self._start_ns:
            self._start_ns = stamp_ns
        if stamp_ns > self._end_ns:
            self._end_ns = stamp_ns
        if stamp_ns >= self._next_flush:
            self._flush(stamp_ns)

    def close(self, extra_custom_data: Mapping[str, str] | None = None) -> None:
        """Finish the file and the metadata; a second call does nothing.

        Args:
            extra_custom_data: what became known in flight: late commands, result, parameters changed.
        """
        if self._stream.closed:
            return
        self.custom_data |= _checked(extra_custom_data or {})
        self.custom_data |= {"counts": json.dumps(self.counts), "losses": json.dumps(self.losses)}
        self._writer.flush()
        self._writer.add_metadata("rosbag2", {"serialized_metadata": dump_yaml(self._information())})
        self._writer.finish()
        self._stream.close()
        self._write_metadata()

    def _note_gap(self, track: RecordedTopic, stamp_ns: int) -> None:
        missing = (stamp_ns - track.last_ns) // track.period_ns - 1
        if track.last_ns >= 0 and missing > 0:
            track.lost += missing
            track.gaps += 1

    def _flush(self, stamp_ns: int) -> None:
        self._writer.flush()
        self._next_flush = stamp_ns + FLUSH_INTERVAL_NS
        if stamp_ns >= self._next_metadata:
            self._next_metadata = stamp_ns + METADATA_INTERVAL_NS
            self._write_metadata()

    def _information(self) -> dict[str, Any]:
        return bag_information(
            self._path.name, self._topics.values(), self._start_ns, self._end_ns, self.custom_data
        )

    def _write_metadata(self) -> None:
        document = {"rosbag2_bagfile_information": self._information()}
        write_atomically(self.folder / METADATA_FILE, dump_yaml(document))


def _checked(custom_data: Mapping[str, str]) -> dict[str, str]:
    for key, value in custom_data.items():
        if not isinstance(key, str) or not isinstance(value, str):
            raise ValueError(f"custom data {key!r}: {value!r} is not text")
    return dict(custom_data)


@functools.cache
def _message_definition(ros_type: str) -> tuple[str, str]:
    """Text of a message definition with all it contains, and its RIHS01 hash."""
    store = _typestore()
    if ros_type not in store.types:
        raise ValueError(f"type {ros_type!r} is not known in ROS 2 Jazzy")
    return str(store.generate_msgdef(ros_type, ros_version=2)[0]), str(store.hash_rihs01(ros_type))


@functools.cache
def _typestore() -> Any:
    return get_typestore(Stores.ROS2_JAZZY)
