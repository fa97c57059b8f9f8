"""A rosbag2 sqlite3 file that is whole at every moment (spec 6.3, 7.5).

rosbags' own writer commits once, when it closes: a recorder killed before leaves nothing. Here messages wait
in memory and each flush writes them in one transaction. The pages go to the file at the commit only, because
rosbags opens files without looking at a journal.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heli_flight.bag_metadata import METADATA_VERSION, ROS_DISTRO

SCHEMA_VERSION = 4
_TABLES = f"""
PRAGMA journal_mode = DELETE;
PRAGMA synchronous = OFF;
PRAGMA cache_spill = OFF;
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
  type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
  data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES ({SCHEMA_VERSION}, '{ROS_DISTRO}');
"""


class SqliteFile:
    """Writes one sqlite3 file; the same words as `McapFile`.

    Args:
        stem: path of the file without its ending; it must not exist.

    Raises:
        OSError: the file cannot be made.
    """

    suffix = ".db3"
    identifier = "sqlite3"

    def __init__(self, stem: Path) -> None:
        self.path = path = stem.with_name(f"{stem.name}{self.suffix}")
        self._waiting: list[tuple[int, int, bytes]] = []
        self._statements: list[tuple[str, tuple[object, ...]]] = []
        self._topics = self._types = 0
        path.touch(exist_ok=False)
        try:
            # the runner calls a node from one thread, but not always from the one that built it
            self._database = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
            self._database.executescript(_TABLES)
        except sqlite3.Error as error:
            raise OSError(str(error)) from None

    def add_schema(self, name: str, definition: str, type_hash: str) -> int:
        """Announce a message type with its RIHS01 hash."""
        self._types += 1
        row = (self._types, name, "ros2msg", definition, type_hash)
        self._statements.append(("INSERT INTO message_definitions VALUES (?, ?, ?, ?, ?)", row))
        return self._types

    def add_channel(self, topic: str, ros_type: str, schema: int, about: Mapping[str, str]) -> int:  # noqa: ARG002
        """Announce a topic, see `McapFile.add_channel`."""
        self._topics += 1
        row = (self._topics, topic, ros_type, "cdr", about["offered_qos_profiles"], about["topic_type_hash"])
        self._statements.append(("INSERT INTO topics VALUES (?, ?, ?, ?, ?, ?)", row))
        return self._topics

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """sqlite3 files have no place for remarks; metadata.yaml has them."""

    def add_messages(self, channel: int, stamps: NDArray[np.int64], size: int, data: bytes) -> None:
        """Append messages of one size, see `McapFile.add_messages`."""
        for number, stamp_ns in enumerate(stamps.tolist()):
            self._waiting.append((channel, stamp_ns, data[size * number : size * (number + 1)]))

    def flush(self) -> None:
        """Commit everything.

        Raises:
            OSError: the file cannot be written; it ends as after the flush before.
        """
        database = self._database
        try:
            database.execute("BEGIN")
            for statement, row in self._statements:
                database.execute(statement, row)
            insert = "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)"
            database.executemany(insert, self._waiting)
            database.execute("COMMIT")
        except sqlite3.Error as error:
            if database.in_transaction:
                database.execute("ROLLBACK")
            raise OSError(str(error)) from None
        self._statements.clear()
        self._waiting.clear()

    def close(self, metadata: str) -> None:
        """Finish the file with rosbag2's metadata in it.

        Raises:
            OSError: the file cannot be written.
        """
        row = (METADATA_VERSION, metadata)
        insert = "INSERT INTO metadata (metadata_version, metadata) VALUES (?, ?)"
        self._statements.append((insert, row))
        try:
            self.flush()
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Close the file as it is."""
        self._database.close()
