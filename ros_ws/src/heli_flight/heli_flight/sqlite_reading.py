"""Reading a rosbag2 sqlite3 file, also one that its recorder left in the middle of a transaction.

sqlite opens the file, takes back what was cut off, and gives topics and metadata. The messages are taken from
the pages themselves, many at a time, where these are as rosbag2 makes them, else row by row from sqlite.
"""

from __future__ import annotations

import shutil
import sqlite3
import tempfile
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

import numpy as np

from heli_common.errors import InputError
from heli_flight.sqlite_pages import Bytes, MessagePlaces, UnusualPagesError, find_messages, map_file
from heli_flight.storage_content import StorageContent

_MAGIC = b"SQLite format 3\0"
_COLUMNS = [
    ("id", "INTEGER", 1),
    ("topic_id", "INTEGER", 0),
    ("timestamp", "INTEGER", 0),
    ("data", "BLOB", 0),
]
"""Of the table of messages: name, type, and whether it is the key."""
_MESSAGES_AT_ONCE = 16384


def read_sqlite(path: Path) -> StorageContent:
    """Everything readable in a file.

    Raises:
        InputError: the file is no rosbag2 database, or two of its topics differ in their namespace only.
    """
    content = StorageContent(path)
    with path.open("rb") as stream:
        head = stream.read(len(_MAGIC))
    if head != _MAGIC[: len(head)]:
        raise InputError("is no sqlite3 file", file=path)
    journal = path.with_name(f"{path.name}-journal")
    if journal.is_file() and journal.stat().st_size:
        # a transaction was cut off: on a copy, sqlite takes it back
        with tempfile.TemporaryDirectory(prefix="heli_") as folder:
            copy = Path(shutil.copy(path, folder))
            shutil.copy(journal, folder)
            _read(content, sqlite3.connect(copy), copy)
    else:
        _read(content, sqlite3.connect(f"file:{quote(str(path))}?mode=ro&immutable=1", uri=True), path)
    if not content.closed:
        content.problems.append("the recorder did not close it")
    return content


def _read(content: StorageContent, database: sqlite3.Connection, path: Path) -> None:
    """Read a database and close it; its file is at this path."""
    numbers: list[int] = []
    try:
        # else sqlite refuses a file that is shorter than it was, whatever it still holds
        database.execute("PRAGMA writable_schema = ON")
        for number, name, ros_type in database.execute("SELECT id, name, type FROM topics"):
            if not (isinstance(name, str) and isinstance(ros_type, str)):
                raise sqlite3.DataError(f"name or type of topic {number} is no text")
            content.announce(number, name, ros_type)
            numbers.append(number)
        try:
            data = map_file(path)
            _take_places(content, data, _find(database, data, numbers))
        except UnusualPagesError:
            _take_rows(content, database, numbers)
        content.closed = _is_closed(database)
    except (sqlite3.Error, KeyError) as error:
        content.problems.append(f"a damaged part was left out: {error}")
    finally:
        database.close()


def _find(database: sqlite3.Connection, data: Bytes, numbers: Sequence[int]) -> MessagePlaces:
    """Where all messages lie.

    Args:
        database: open.
        data: its whole file.
        numbers: of the topics.

    Raises:
        UnusualPagesError: sqlite itself must read them.
    """
    about = database.execute("PRAGMA table_info(messages)")
    columns = [(name, kind.upper(), key) for _, name, kind, _, _, key in about]
    select = "SELECT rootpage FROM sqlite_master WHERE type = 'table' AND name = 'messages'"
    row = database.execute(select).fetchone()
    if columns != _COLUMNS or row is None or not isinstance(row[0], int):
        raise UnusualPagesError
    (pages,) = database.execute("PRAGMA page_count").fetchone()
    places = find_messages(data, row[0], pages)
    if not np.isin(places.topics, numbers).all():
        raise UnusualPagesError
    return places


def _take_places(content: StorageContent, data: Bytes, places: MessagePlaces) -> None:
    """Take all messages from where they lie, topic by topic within a stretch of the file."""
    for number, count in zip(*np.unique(places.topics, return_counts=True), strict=True):
        content.of(int(number)).expected = int(count)
    for first in range(0, len(places.topics), _MESSAGES_AT_ONCE):
        stretch = places[first : first + _MESSAGES_AT_ONCE]
        for number in np.unique(stretch.topics).tolist():
            found = stretch[stretch.topics == number]
            size = int(found.sizes[0])
            if (found.sizes == size).all():
                content.of(number).add_rows(found.stamps, data, found.starts, size)
            else:
                bounds = zip(found.starts.tolist(), (found.starts + found.sizes).tolist(), strict=True)
                content.of(number).add(found.stamps, [data[start:end].tobytes() for start, end in bounds])


def _take_rows(content: StorageContent, database: sqlite3.Connection, numbers: Sequence[int]) -> None:
    """Take the messages as sqlite hands them out, those before a damaged place if there is one.

    Raises:
        sqlite3.Error, KeyError: there is.
    """
    found: dict[int, tuple[list[int], list[bytes]]] = {number: ([], []) for number in numbers}
    notes = {number: (stamps.append, messages.append) for number, (stamps, messages) in found.items()}
    try:
        rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id")
        for number, stamp, data in rows:
            note_stamp, note_message = notes[number]
            if not (isinstance(stamp, int) and isinstance(data, bytes)):
                raise sqlite3.DataError(f"a message of topic {number} is not of its table's types")
            note_stamp(stamp)
            note_message(data)
    finally:
        for number, (stamps, messages) in found.items():
            content.of(number).add(stamps, messages)


def _is_closed(database: sqlite3.Connection) -> bool:
    """Whether rosbag2's metadata are in the file, or its version is from before they were."""
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if "metadata" not in tables:
        return True
    (count,) = database.execute("SELECT count(*) FROM metadata").fetchone()
    return bool(count)
