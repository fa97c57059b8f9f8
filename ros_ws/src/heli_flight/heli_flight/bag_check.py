"""Whether a bag is whole, what of it is lost, and the same flight written again as a whole bag (spec 6.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader, ReaderError

from heli_common.errors import InputError
from heli_flight.bag import BagWriter
from heli_flight.bag_reader import Bag
from heli_flight.flight_hash import TopicCount, bag_hash, count_check

REPAIRED, LEFT_OUT, WHOLE_HASH = "repaired", "left_out", "sha256_with_left_out"
_OF_THE_WRITER = ("counts", "losses")


@dataclass(frozen=True)
class BagState:
    """What a bag is like.

    Attributes:
        problems: what is missing or damaged; empty when it is whole.
        until_ns: newest log time in it [ns].
        unwritten: messages that the metadata count but the file does not hold.
        losses: topics with missing stamps.
        readers: programs other than ours by name; why they cannot read it, or an empty string.
    """

    problems: tuple[str, ...]
    until_ns: int
    unwritten: int
    losses: tuple[TopicCount, ...]
    readers: dict[str, str]

    @property
    def whole(self) -> bool:
        """Whether nothing is missing and everybody can read it."""
        return not (self.problems or self.losses or any(self.readers.values()))


def bag_state(bag: Bag, path: Path) -> BagState:
    """Look at a bag.

    Args:
        bag: as read.
        path: of its folder or file.
    """
    held = sum(bag.counts.values())
    return BagState(
        problems=bag.problems,
        until_ns=max((stamps[-1] for stamps in bag.stamps.values() if stamps), default=0),
        unwritten=max(0, (bag.promised or 0) - held),
        losses=tuple(count for count in count_check(bag) if count.lost),
        readers=other_readers(path),
    )


def other_readers(path: Path) -> dict[str, str]:
    """Why rosbags and mcap cannot read a bag; an empty string where they can."""
    found = {}
    try:
        with Reader(path):
            found["rosbags"] = ""
    except (ReaderError, OSError, ValueError, AssertionError, TypeError) as error:
        found["rosbags"] = str(error) or type(error).__name__
    for file in sorted(path.glob("*.mcap")) if path.is_dir() else [path] * (path.suffix == ".mcap"):
        try:
            with file.open("rb") as stream:
                missing = make_reader(stream).get_summary() is None
            found["mcap"] = "no summary" if missing else ""
        except (McapError, OSError, ValueError) as error:
            found["mcap"] = str(error) or type(error).__name__
    return found


def write_again(bag: Bag, folder: Path, storage: str = "mcap", without: Sequence[str] = ()) -> None:
    """Write what was read of a bag as a bag that is whole, sorted by log time.

    Args:
        bag: as read.
        folder: of the new bag.
        storage: see `bag.STORAGES`.
        without: topics that are left out; the bag says which.

    Raises:
        InputError: no such topic, the folder is not empty or cannot be written, or a type is unknown.
        OSError: the disk is full.
    """
    custom_data = {key: text for key, text in bag.custom_data.items() if key not in _OF_THE_WRITER}
    if bag.problems:
        custom_data[REPAIRED] = "; ".join(bag.problems)
    for name in without:
        if name not in bag.types:
            raise InputError(f"no topic {name!r}", allowed=", ".join(bag.types), file=bag.folder)
    if without:
        custom_data |= {LEFT_OUT: ", ".join(without), WHOLE_HASH: bag_hash(bag)}
    names = [name for name in bag.messages if bag.types.get(name) and name not in without]
    counts = [len(bag.stamps[name]) for name in names]
    with BagWriter(folder, custom_data, storage) as writer:
        for name in names:
            try:
                writer.add_topic(name, bag.types[name])
            except ValueError as error:
                raise InputError(str(error), file=bag.folder, key=name) from None
        stamps = np.concatenate(
            [np.array(bag.stamps[name], np.int64) for name in names] or [np.empty(0, np.int64)]
        )
        order = np.argsort(stamps, kind="stable")
        sources = [iter(bag.messages[name]) for name in names]
        numbers = np.repeat(np.arange(len(names)), counts)[order].tolist()
        for number, stamp in zip(numbers, stamps[order].tolist(), strict=True):
            writer.write(names[number], stamp, next(sources[number]))
