"""Where the messages of a rosbag2 sqlite3 file lie, found in its pages with numpy.

sqlite hands out rows one by one, and for small messages that takes longer than anything else about them. The
table's pages follow a documented format (https://www.sqlite.org/fileformat2.html, "B-tree Pages" and "Record
Format"): a tree whose leaves hold records of id, topic, time stamp and message. Records are taken as rosbag2
writes them, each message within one page. Whatever else is met, damage included, ends the search, and the
caller asks sqlite.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]

_PAGE_SIZE, _RESERVED = slice(16, 18), 20
"""Where the head of the file says how large a page is and how much of its end is not used."""
_BRANCH, _LEAF = 5, 13
_HEADS = {_BRANCH: 12, _LEAF: 8}
"""Bytes at the head of a page by its kind."""
_MOST_LEVELS = 20
_LEAST_SPARE = 35
"""A record of more than a page less this [bytes] is continued on other pages."""
_WIDTHS = np.array([-1, 1, 2, 3, 4, 6, 8, -1, 0, 0] + 246 * [-1])
"""Bytes of an integer by its type in a record; types 8 and 9 are the numbers 0 and 1; -1 is no integer."""


_BYTES_AT_ONCE = 4_000_000


class UnusualPagesError(Exception):
    """The pages are damaged, or are sound but not as this module takes them apart."""


@dataclass(frozen=True)
class MessagePlaces:
    """The messages of a file in the order of their ids; arrays of shape (n,).

    Attributes:
        topics: number of the topic.
        stamps: log time [ns].
        starts: where the serialized message begins in the file [bytes].
        sizes: of the serialized message [bytes].
    """

    topics: Integers
    stamps: Integers
    starts: Integers
    sizes: Integers

    def __getitem__(self, chosen: slice | NDArray[np.bool_]) -> MessagePlaces:
        """Some of them."""
        return MessagePlaces(
            self.topics[chosen], self.stamps[chosen], self.starts[chosen], self.sizes[chosen]
        )


def map_file(path: Path) -> Bytes:
    """The bytes of a file that is not empty; they are read from it as they are used."""
    return np.asarray(np.memmap(path, dtype=np.uint8, mode="r"))


def find_messages(data: Bytes, root: int, pages: int) -> MessagePlaces:
    """Where every message lies.

    Args:
        data: the whole file, its head verified by sqlite.
        root: number of the first page of a table with the columns id (the key), topic_id, timestamp and data.
        pages: of the database by sqlite; a file that is being written can have more, one that was cut fewer.

    Raises:
        UnusualPagesError: sqlite itself must read this file.
    """
    page = int.from_bytes(data[_PAGE_SIZE].tobytes(), "big")
    page = 65536 if page == 1 else page
    usable = page - int(data[_RESERVED])
    leaves = _leaves(data[: pages * page], root, page, usable)
    # as many at a time as the processor's cache holds
    step = max(1, _BYTES_AT_ONCE // page)
    found = [_records(data, leaves[k : k + step], usable) for k in range(0, len(leaves), step)]
    ids, topics, stamps, starts, sizes = map(np.concatenate, zip(*found, strict=True))
    _demand(np.diff(ids) > 0)
    return MessagePlaces(topics, stamps, starts, sizes)


def _records(data: Bytes, leaves: Integers, usable: int) -> tuple[Integers, ...]:
    """Ids, topics, stamps, starts and sizes of the messages in some leaves, see `MessagePlaces`."""
    cells, counts = _cells(data, leaves, _HEADS[_LEAF], usable)
    payload, places = _varints(data, cells)
    ids, places = _varints(data, places)
    ends = places + payload
    _demand((payload > 4) & (payload <= usable - _LEAST_SPARE))
    _demand(ends <= np.repeat(leaves + usable, counts))
    _demand(data[places + 1] == 0)
    topic_kinds, stamp_kinds = data[places + 2], data[places + 3]
    data_kinds, heads_end = _varints(data, places + 4)
    _demand(data[places] == heads_end - places)
    topics, topics_end = _integers(data, heads_end, topic_kinds)
    stamps, starts = _integers(data, topics_end, stamp_kinds)
    # a blob of n bytes has the type 12 + 2 n
    _demand((data_kinds >= 12) & (data_kinds % 2 == 0))
    sizes = (data_kinds - 12) // 2
    _demand(starts + sizes == ends)
    return ids, topics, stamps, starts, sizes


def _demand(as_expected: NDArray[np.bool_]) -> None:
    if not as_expected.all():
        raise UnusualPagesError


def _leaves(data: Bytes, root: int, page: int, usable: int) -> Integers:
    """Where the leaves of a table begin, in the order of its keys, shape (leaves,)."""
    numbers = np.array([root])
    for _ in range(_MOST_LEVELS):
        # page 1 holds the schema
        _demand((numbers > 1) & (numbers <= len(data) // page))
        starts = (numbers - 1) * page
        # pages that lead to each other would never end
        _demand(np.diff(np.sort(starts)) > 0)
        kinds = data[starts]
        if (kinds == _LEAF).all():
            # only a table without rows has an empty page
            _demand((_unsigned(data, starts + 3, 2) > 0) | (len(starts) == 1))
            return starts
        _demand(kinds == _BRANCH)
        cells, counts = _cells(data, starts, _HEADS[_BRANCH], usable)
        _demand(counts > 0)
        # a cell begins with the page of smaller keys; the page of the largest keys is in the head
        numbers = np.insert(_unsigned(data, cells, 4), np.cumsum(counts), _unsigned(data, starts + 8, 4))
    raise UnusualPagesError


def _cells(data: Bytes, starts: Integers, head: int, usable: int) -> tuple[Integers, Integers]:
    """Where the cells of pages of one kind begin, shape (cells,), and how many each page has, (pages,)."""
    counts = _unsigned(data, starts + 3, 2)
    _demand(head + 2 * counts <= usable)
    index = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    pages = np.repeat(starts, counts)
    offsets = _unsigned(data, pages + head + 2 * index, 2)
    _demand(offsets >= np.repeat(head + 2 * counts, counts))
    _demand(offsets <= usable - 4)
    return pages + offsets, counts


def _unsigned(data: Bytes, places: Integers, width: int) -> Integers:
    """Numbers of 2 or 4 bytes, the highest first."""
    windows: NDArray[np.uint] = np.ndarray((len(data) - width + 1,), f">u{width}", data, strides=(1,))
    return windows[places].astype(np.int64)


def _integers(data: Bytes, places: Integers, kinds: Bytes) -> tuple[Integers, Integers]:
    """Signed numbers of 0 to 8 bytes, the highest first, and where they end."""
    widths = _WIDTHS[kinds]
    ends = places + widths
    _demand((widths >= 0) & (ends <= len(data)))
    windows: Integers = np.ndarray((len(data) - 7,), ">i8", data, strides=(1,))
    # eight bytes up to the end of the number; those before it are shifted out
    shifts = np.minimum(64 - 8 * widths, 63)
    values = windows[ends - 8].astype(np.int64) << shifts >> shifts
    return np.where(widths, values, kinds == 9), ends


def _varints(data: Bytes, places: Integers) -> tuple[Integers, Integers]:
    """Numbers of 7 bits per byte, the highest first, the top bit set in all but the last; where they end."""
    values, ends = np.zeros_like(places), places.copy()
    unfinished = np.arange(len(places))
    for _ in range(8):
        here = ends[unfinished]
        _demand(here < len(data))
        found = data[here]
        values[unfinished] = values[unfinished] << 7 | found & 0x7F
        ends[unfinished] = here + 1
        unfinished = unfinished[found > 0x7F]
        if not len(unfinished):
            return values, ends
    raise UnusualPagesError
