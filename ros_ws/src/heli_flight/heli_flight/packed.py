"""Messages of one size behind each other in one array: a list of bytes without an object per message."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np
from numpy.typing import NDArray

from heli_common.layout import Layout, Values

Table = NDArray[np.uint8]
Stamps = NDArray[np.int64]


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
        return self.table[index].tobytes()

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
    if not size or any(len(data) != size for data in messages):
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
    """The messages of one topic as a reader finds them, piece by piece, in the order of the file."""

    def __init__(self) -> None:
        self.count = 0
        self._blocks: list[tuple[Stamps, Sequence[bytes]]] = []

    def add(self, stamps: Sequence[int] | Stamps, messages: Sequence[bytes] | Table) -> None:
        """Append messages with their log times [ns]; a table has one message per row."""
        if len(stamps):
            found = PackedMessages(messages) if isinstance(messages, np.ndarray) else pack(messages)
            self._blocks.append((np.asarray(stamps, dtype=np.int64), found))
            self.count += len(stamps)

    @classmethod
    def chained(cls, parts: Sequence[TopicBlocks]) -> TopicBlocks:
        """Those of several files, one after the other."""
        whole = cls()
        for part in parts:
            whole._blocks += part._blocks
            whole.count += part.count
        return whole

    def joined(self) -> tuple[list[int], Sequence[bytes]]:
        """All of them: log times and messages, packed where they have one size."""
        if not self._blocks:
            return [], []
        stamps = np.concatenate([stamps for stamps, _ in self._blocks]).tolist()
        parts = [messages for _, messages in self._blocks]
        tables = [part.table for part in parts if isinstance(part, PackedMessages)]
        if len(tables) == len(parts) and len({table.shape[1] for table in tables}) == 1:
            return stamps, PackedMessages(np.concatenate(tables))
        return stamps, [message for part in parts for message in part]
