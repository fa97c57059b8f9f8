"""Messages of one size behind each other in one array: a list of bytes without an object per message."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np
from numpy.typing import NDArray

from heli_common.layout import Layout, Values

Table = NDArray[np.uint8]
Stamps = NDArray[np.int64]

_FIRST_ROWS = 256


class PackedMessages(Sequence[bytes]):
    """Serialized messages; equal to a list of the same bytes.

    Args:
        table: one message per row, shape (n, bytes of a message).
    """

    def __init__(self, table: Table) -> None:
        self.table = np.ascontiguousarray(table)

    def __len__(self) -> int:
        return len(self.table)

    @overload
    def __getitem__(self, index: int) -> bytes: ...
    @overload
    def __getitem__(self, index: slice) -> PackedMessages: ...
    def __getitem__(self, index: int | slice) -> bytes | PackedMessages:
        """One message, or some as a view."""
        if isinstance(index, slice):
            return PackedMessages(self.table[index])
        return bytes(self.table[index].tobytes())

    def __iter__(self) -> Iterator[bytes]:
        size = self.table.shape[1]
        whole = self.table.tobytes()
        return (whole[place : place + size] for place in range(0, len(whole), size))

    def __eq__(self, other: object) -> bool:
        if isinstance(other, PackedMessages):
            return np.array_equal(self.table, other.table)
        if isinstance(other, Sequence):
            return list(self) == list(other)
        return NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"PackedMessages({self.table.shape[0]} of {self.table.shape[1]} bytes)"


def pack(messages: Sequence[bytes]) -> Sequence[bytes]:
    """The same messages in one array if all have one size, as they are if not."""
    if isinstance(messages, PackedMessages) or not messages:
        return messages
    size = len(messages[0])
    if not size or set(map(len, messages)) != {size}:
        return messages
    return PackedMessages(np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), size))


def read_layout(layout: Layout, messages: Sequence[bytes]) -> tuple[Stamps, Values]:
    """Stamps [ns], shape (n,), and numbers, shape (n, number of fields), of messages of one layout.

    Raises:
        ValueError: a message has another size than the layout.
    """
    packed = pack(messages)
    return layout.read_table(packed.table) if isinstance(packed, PackedMessages) else layout.read(packed)


class TopicBlocks:
    """The messages of one topic as a reader finds them, piece by piece, in the order of the file.

    While all have one size they stand in one table that grows in place.

    Attributes:
        count: messages so far.
        expected: messages that there will be, as far as known; room for them is taken at once.
    """

    def __init__(self) -> None:
        self.count = 0
        self.expected = 0
        self._stamps: list[Stamps] = []
        self._table: Table = np.empty((0, 0), np.uint8)
        self._loose: list[bytes] | None = None

    def add(self, stamps: Sequence[int] | Stamps, messages: Sequence[bytes]) -> None:
        """Append messages with their log times [ns]."""
        found = pack(messages)
        if isinstance(found, PackedMessages) and self._fits(found.table.shape[1]):
            if self.count:
                self._room(*found.table.shape)[:] = found.table
            else:
                self._table = found.table
        else:
            self._loosen().extend(messages)
        self._note(stamps)

    def add_rows(
        self, stamps: Stamps, data: bytes | NDArray[np.uint8], starts: NDArray[np.int64], size: int
    ) -> None:
        """Append messages of one size that begin at these places of the data."""
        if not self._fits(size):
            self.add(stamps, [bytes(data[start : start + size]) for start in starts.tolist()])
            return
        rows: NDArray[np.void] = np.ndarray((len(data) - size + 1,), f"V{size}", data, strides=(1,))
        self._room(len(starts), size)[:] = rows[starts].view(np.uint8).reshape(len(starts), size)
        self._note(stamps)

    def joined(self) -> tuple[list[int], Sequence[bytes]]:
        """All of them: log times and messages, packed where they have one size."""
        if not self.count:
            return [], []
        stamps = np.concatenate(self._stamps).tolist()
        if self._loose is not None:
            return stamps, self._loose
        return stamps, PackedMessages(self._table[: self.count])

    def extend(self, other: TopicBlocks) -> None:
        """Append what was found in the next file."""
        stamps, messages = other.joined()
        if stamps:
            self.add(stamps, messages)

    def _fits(self, size: int) -> bool:
        return self._loose is None and size > 0 and (not self.count or size == self._table.shape[1])

    def _room(self, count: int, size: int) -> Table:
        """Place for further messages at the end of the table."""
        needed = self.count + count
        if not self.count:
            self._table = np.empty((max(count, self.expected, _FIRST_ROWS), size), np.uint8)
        elif needed > len(self._table):
            if not self._table.flags.owndata:
                self._table = self._table[: self.count].copy()
            # a large block of memory is moved by the operating system without copying it
            self._table.resize((max(needed, 3 * len(self._table) // 2), size), refcheck=False)
        return self._table[self.count : needed]

    def _loosen(self) -> list[bytes]:
        if self._loose is None:
            self._loose = list(PackedMessages(self._table[: self.count])) if self.count else []
            self._table = np.empty((0, 0), np.uint8)
        return self._loose

    def _note(self, stamps: Sequence[int] | Stamps) -> None:
        self._stamps.append(np.asarray(stamps, dtype=np.int64))
        self.count += len(stamps)
