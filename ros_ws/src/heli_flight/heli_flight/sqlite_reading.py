"""Reading a rosbag2 sqlite3 file, also one that its recorder left in the middle of a transaction."""

from __future__ import annotations

import shutil
import sqlite3
import tempfile
from pathlib import Path
from urllib.parse import quote

from heli_common.errors import InputError
from heli_flight.storage_content import StorageContent

_MAGIC = b"SQLite format 3\0"


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
            _read(content, sqlite3.connect(copy))
    else:
        _read(content, sqlite3.connect(f"file:{quote(str(path))}?mode=ro&immutable=1", uri=True))
    if not content.closed:
        content.problems.append("the recorder did not close it")
    return content


def _read(content: StorageContent, database: sqlite3.Connection) -> None:
    found: dict[int, tuple[list[int], list[bytes]]] = {}
    try:
        # else sqlite refuses a file that is shorter than it was, whatever it still holds
        database.execute("PRAGMA writable_schema = ON")
        for number, name, ros_type in database.execute("SELECT id, name, type FROM topics"):
            content.announce(number, name, ros_type)
            found[number] = ([], [])
        notes = {number: (stamps.append, messages.append) for number, (stamps, messages) in found.items()}
        rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id")
        for number, stamp, data in rows:
            note_stamp, note_message = notes[number]
            note_stamp(stamp)
            note_message(data)
        content.closed = _is_closed(database)
    except (sqlite3.Error, KeyError) as error:
        content.problems.append(f"a damaged part was left out: {error}")
    finally:
        database.close()
    for number, (stamps, messages) in found.items():
        content.of(number).add(stamps, messages)


def _is_closed(database: sqlite3.Connection) -> bool:
    """Whether rosbag2's metadata are in the file, or its version is from before they were."""
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if "metadata" not in tables:
        return True
    (count,) = database.execute("SELECT count(*) FROM metadata").fetchone()
    return bool(count)
