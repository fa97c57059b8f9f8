"""Reading a flight's bag, also one that was cut off in flight or lost its metadata (spec 7.5)."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import zstandard

from heli_common.errors import InputError
from heli_common.files import read_yaml
from heli_flight.bag_metadata import METADATA_FILE, PACKED_SUFFIX
from heli_flight.mcap_reading import read_mcap
from heli_flight.packed import TopicBlocks
from heli_flight.sqlite_reading import read_sqlite
from heli_flight.storage_content import StorageContent, topic_name

__all__ = ["Bag", "read_bag", "topic_name"]

_READERS = {".mcap": read_mcap, ".db3": read_sqlite}


@dataclass(frozen=True)
class Bag:
    """A bag in memory.

    Attributes:
        folder: it came from.
        types: ROS type of every topic, those without messages included.
        stamps: log times [ns] of every topic in the order of the file.
        messages: serialized messages, in the same order; packed in one array where they have one size.
        custom_data: remarks of the recorder, see `bag_metadata`.
        problems: what is missing or damaged; empty when the bag is whole.
        promised: messages by the metadata, which are renewed once a second; None without metadata.
    """

    folder: Path
    types: dict[str, str]
    stamps: dict[str, list[int]]
    messages: Mapping[str, Sequence[bytes]]
    custom_data: dict[str, str]
    problems: tuple[str, ...]
    promised: int | None = None

    @property
    def complete(self) -> bool:
        """Whether the recorder closed the bag and nothing is damaged."""
        return not self.problems

    @property
    def counts(self) -> dict[str, int]:
        """Messages per topic."""
        return {topic: len(messages) for topic, messages in self.messages.items()}


@dataclass(frozen=True)
class _Metadata:
    """What metadata.yaml says: names of the storage files, remarks, messages, way of compression."""

    files: tuple[str, ...] = ()
    custom_data: Mapping[str, str] | None = None
    promised: int | None = None
    compression: str = ""
    problem: str = ""


def read_bag(folder: Path) -> Bag:
    """The whole bag; one that was cut off up to its last readable message.

    Args:
        folder: a rosbag2 folder, or a storage file (`.mcap` or `.db3`).

    Raises:
        InputError: no such folder, no storage file in it, or not such a file; two topics that differ in
            their namespace only.
    """
    root = folder.parent if folder.is_file() else folder
    about = _read_metadata(root)
    files = [folder] if folder.is_file() else _storage_files(root, about.files)
    contents = [_read(path) for path in files]
    types: dict[str, str] = {}
    custom_data: dict[str, str] = {}
    blocks: dict[str, TopicBlocks] = {}
    problems = [about.problem] if about.problem else []
    for content in contents:
        types |= content.types
        custom_data |= content.custom_data
        problems += content.problems
        for topic, found in content.blocks.items():
            if topic in blocks:
                blocks[topic].extend(found)
            else:
                blocks[topic] = found
    stamps: dict[str, list[int]] = {}
    messages: dict[str, Sequence[bytes]] = {}
    for topic, found in blocks.items():
        stamps[topic], messages[topic] = found.joined()
        if about.compression == "message":
            unpack = zstandard.ZstdDecompressor().decompress
            messages[topic] = [unpack(data) for data in messages[topic]]
    count = sum(map(len, stamps.values()))
    if about.promised is not None and about.promised != count and not problems:
        problems.append(f"{METADATA_FILE} counts {about.promised} messages, the bag holds {count}")
    custom_data |= about.custom_data or {}
    return Bag(root, types, stamps, messages, custom_data, tuple(problems), about.promised)


def _read_metadata(root: Path) -> _Metadata:
    path = root / METADATA_FILE
    if not path.exists():
        return _Metadata(problem=f"{METADATA_FILE} is missing" if root.is_dir() else "")
    try:
        information = read_yaml(path)["rosbag2_bagfile_information"]
        custom = information.get("custom_data") or {}
        return _Metadata(
            tuple(Path(name).name for name in information["relative_file_paths"]),
            {str(key): str(value) for key, value in custom.items()},
            int(information["message_count"]),
            str(information.get("compression_mode") or "").lower(),
        )
    except (InputError, KeyError, TypeError, ValueError, AttributeError):
        return _Metadata(problem=f"{METADATA_FILE} is unreadable")


def _storage_files(root: Path, names: Sequence[str]) -> list[Path]:
    if not root.is_dir():
        raise InputError("no such bag", allowed="a rosbag2 folder or an MCAP file", file=root)
    listed = [root / name for name in names if _ending(Path(name)) in _READERS and (root / name).exists()]
    found = sorted(root.glob("*.mcap"), key=lambda path: (len(path.name), path.name))
    files = listed or found or sorted(root.glob("*.db3"), key=lambda path: (len(path.name), path.name))
    if not files:
        raise InputError("holds no MCAP file and no sqlite3 file", allowed="a rosbag2 folder", file=root)
    return files


def _ending(path: Path) -> str:
    return Path(path.stem).suffix if path.suffix == PACKED_SUFFIX else path.suffix


def _read(path: Path) -> StorageContent:
    with _unpacked(path) as file:
        reader = _READERS.get(file.suffix)
        if reader is None:
            raise InputError("is no storage file", allowed=", ".join(_READERS), file=path)
        return reader(file)


@contextmanager
def _unpacked(path: Path) -> Iterator[Path]:
    """The file itself, or what is in one that was compressed as a whole."""
    if path.suffix != PACKED_SUFFIX:
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="heli_") as folder:
        file = Path(folder) / path.stem
        with path.open("rb") as packed, file.open("wb") as plain:
            shutil.copyfileobj(zstandard.ZstdDecompressor().stream_reader(packed), plain)
        yield file
