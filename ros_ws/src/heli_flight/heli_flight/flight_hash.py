"""One number for a flight, where two flights differ first, and whether a bag holds everything (spec 6.4).

The hash is a SHA-256 over the data topics, sorted by stamp, topic and index within the topic. Each message
enters as: topic (UTF-8), 0x00, stamp (int64), length (uint32), CDR; integers little-endian, padding zero.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.layout import Layout
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_flight.bag_reader import Bag
from heli_flight.packed import PackedMessages, pack

_BLOCK = 4096
"""Messages that are hashed at a time."""

Entry = tuple[int, str, int, bytes]
"""Stamp [ns], topic, index within the topic, canonical CDR."""


def canonical_messages(layout: Layout, messages: Sequence[bytes]) -> Sequence[bytes]:
    """The messages as this project's codec writes them; nearly all of them are so already.

    Raises:
        ValueError: names, frames or lengths differ from the agreed ones.
    """
    packed = pack(messages)
    if not isinstance(packed, PackedMessages) or packed.table.shape[1] != layout.size:
        return [layout.canonical(data) for data in messages]
    strange = np.zeros(len(packed), dtype=np.bool_)
    template = np.frombuffer(layout.template, dtype=np.uint8)
    for first, last in _fixed_spans(layout):
        strange |= np.any(packed.table[:, first:last] != template[first:last], axis=1)
    if not strange.any():
        return packed
    canonical = list(packed)
    for index in np.flatnonzero(strange).tolist():
        canonical[index] = layout.canonical(canonical[index])
    return canonical


def _fixed_spans(layout: Layout) -> list[tuple[int, int]]:
    """Which bytes are the same in every canonical message: all but stamp and numbers; from, to."""
    free = sorted((layout.stamp_offset, *layout.offsets))
    starts, ends = [0, *(place + 8 for place in free)], [*free, layout.size]
    return [(start, end) for start, end in zip(starts, ends, strict=True) if end > start]


def stamps_of(layout: Layout, messages: Sequence[bytes]) -> NDArray[np.int64]:
    """The stamps [ns] in the headers of messages of one layout, shape (n,)."""
    packed = pack(messages)
    table = packed.table if isinstance(packed, PackedMessages) else b"".join(packed)
    rows = np.frombuffer(table, dtype=layout.dtype)
    return np.asarray(rows["sec"].astype(np.int64) * 1_000_000_000 + rows["nanosec"])


def ordered(messages: Mapping[str, Sequence[bytes]]) -> list[Entry]:
    """Every message of the data topics in the order of the hash.

    Args:
        messages: serialized, by topic; other topics are left out.

    Raises:
        InputError: a message is not of its topic's layout.
    """
    entries: list[Entry] = []
    for topic in DATA_TOPICS:
        if not messages.get(topic):
            continue
        layout = TOPICS[topic].layout
        try:
            canonical = canonical_messages(layout, messages[topic])
        except ValueError as error:
            raise InputError(str(error), key=topic) from None
        stamps = stamps_of(layout, canonical).tolist()
        entries += [(stamps[index], topic, index, data) for index, data in enumerate(canonical)]
    entries.sort(key=lambda entry: entry[:3])
    return entries


class FlightHash:
    """The hash of a flight while it is being flown.

    Messages may come in any order between topics; within a topic, in the order of sending.
    """

    def __init__(self) -> None:
        self._messages: dict[str, list[bytes]] = {topic: [] for topic in DATA_TOPICS}

    def add(self, topic: str, data: bytes) -> None:
        """Take a serialized message; topics without a part in the hash are ignored."""
        if topic in self._messages:
            self._messages[topic].append(data)

    def hexdigest(self) -> str:
        """SHA-256 of what was added so far, 64 hex digits.

        Raises:
            InputError: a message is not of its topic's layout.
        """
        return hash_messages(self._messages)


def hash_messages(messages: Mapping[str, Sequence[bytes]]) -> str:
    """The hash of serialized messages by topic, 64 hex digits.

    Raises:
        InputError: a message is not of its topic's layout.
    """
    parts: list[bytes] = []
    stamps: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
    ranks: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
    for rank, topic in enumerate(sorted(DATA_TOPICS)):
        if not messages.get(topic):
            continue
        table = _hashed_rows(topic, messages[topic])
        stamps.append(table["stamp"].astype(np.int64))
        ranks.append(np.full(len(table), rank))
        content, width = table.tobytes(), table.dtype.itemsize
        parts += [content[place : place + width] for place in range(0, len(content), width)]
    # stable, so that messages of one topic and stamp stay as they were sent
    order = np.lexsort((np.concatenate(ranks), np.concatenate(stamps))).tolist()
    digest = hashlib.sha256()
    for start in range(0, len(order), _BLOCK):
        digest.update(b"".join([parts[place] for place in order[start : start + _BLOCK]]))
    return digest.hexdigest()


def _hashed_rows(topic: str, messages: Sequence[bytes]) -> NDArray[np.void]:
    """What enters the hash of one topic's messages, a row each."""
    layout, name = TOPICS[topic].layout, topic.encode() + b"\0"
    try:
        canonical = canonical_messages(layout, messages)
    except ValueError as error:
        raise InputError(str(error), key=topic) from None
    fields = [("topic", f"V{len(name)}"), ("stamp", "<i8"), ("length", "<u4"), ("data", f"V{layout.size}")]
    table = np.empty(len(canonical), dtype=fields)
    table["topic"], table["length"] = np.void(name), layout.size
    table["stamp"] = stamps_of(layout, canonical)
    packed = pack(canonical)
    rows = packed.table if isinstance(packed, PackedMessages) else b"".join(packed)
    table["data"] = np.frombuffer(rows, dtype=f"V{layout.size}")
    return table


def bag_hash(bag: Bag) -> str:
    """The hash of a recorded flight, 64 hex digits.

    Raises:
        InputError: a message is not of its topic's layout.
    """
    try:
        return hash_messages(bag.messages)
    except InputError as error:
        raise InputError(error.problem, file=bag.folder, key=error.key) from None


@dataclass(frozen=True)
class Difference:
    """The first place at which two flights are not the same.

    Attributes:
        topic: of the message.
        stamp_ns: of the message [ns].
        index: of the message within its topic.
        what: in words: missing in one flight, or which number differs how.
    """

    topic: str
    stamp_ns: int
    index: int
    what: str

    def __str__(self) -> str:
        return f"{self.topic} at {self.stamp_ns * 1e-9:.4f} s (message {self.index}): {self.what}"


def first_difference(first: Bag, second: Bag) -> Difference | None:
    """Where two flights differ first in the order of the hash, or None if they are the same.

    Raises:
        InputError: a message is not of its topic's layout.
    """
    for one, other in zip_longest(ordered(first.messages), ordered(second.messages)):
        if one == other:
            continue
        if other is None or (one is not None and one[:3] < other[:3]):
            return Difference(one[1], one[0], one[2], "only in the first flight")
        if one is None or one[:3] > other[:3]:
            return Difference(other[1], other[0], other[2], "only in the second flight")
        return Difference(one[1], one[0], one[2], _number_that_differs(one[1], one[3], other[3]))
    return None


def _number_that_differs(topic: str, first: bytes, second: bytes) -> str:
    layout = TOPICS[topic].layout
    for place, name in zip(layout.offsets, layout.fields, strict=True):
        if first[place : place + 8] != second[place : place + 8]:
            one, other = (struct.unpack_from("<d", data, place)[0] for data in (first, second))
            return f"{name} is {one!r} in the first and {other!r} in the second flight"
    return "the bytes differ outside the numbers"


@dataclass(frozen=True)
class TopicCount:
    """How complete one topic of a bag is.

    Attributes:
        topic: name.
        ros_type: e.g. `sensor_msgs/msg/JointState`.
        messages: recorded.
        expected: from the topic's period between its first and last stamp; None for irregular topics.
        lost: stamps of that grid without a message.
        gaps: places where messages are missing.
        first_gap_ns: first missing stamp [ns], None without a gap.
    """

    topic: str
    ros_type: str
    messages: int
    expected: int | None
    lost: int
    gaps: int
    first_gap_ns: int | None


def count_check(bag: Bag) -> list[TopicCount]:
    """Messages, expected messages and losses of every topic of a bag."""
    order = {topic: place for place, topic in enumerate(TOPICS)}
    names = sorted(bag.types, key=lambda name: (order.get(name, len(order)), name))
    return [_count(name, bag.types[name], bag.stamps[name]) for name in names]


def _count(topic: str, ros_type: str, stamps: Iterable[int]) -> TopicCount:
    times = np.array(list(stamps), dtype=np.int64)
    if topic not in TOPICS or not TOPICS[topic].hashed:
        return TopicCount(topic, ros_type, len(times), None, 0, 0, None)
    if not len(times):
        return TopicCount(topic, ros_type, 0, 0, 0, 0, None)
    period = TOPICS[topic].period_ns
    known = np.unique(times)
    missing = np.diff(known) // period - 1
    gaps = np.flatnonzero(missing > 0)
    lost = int(missing[gaps].sum())
    first = int(known[gaps[0]]) + period if len(gaps) else None
    expected = int((known[-1] - known[0]) // period) + 1
    return TopicCount(topic, ros_type, len(times), expected, lost, len(gaps), first)
