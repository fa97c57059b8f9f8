"""What a reader found in one storage file of a bag."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from heli_common.errors import InputError
from heli_common.topics import TOPICS
from heli_flight.packed import TopicBlocks


def topic_name(absolute: str) -> str:
    """The name in the table of topics, whatever the namespace; other topics lose only the leading slash."""
    last = absolute.rsplit("/", 1)[-1]
    return last if last in TOPICS else absolute.lstrip("/")


@dataclass
class StorageContent:
    """Topics, messages and state of one file.

    Attributes:
        path: of the file.
        types: ROS type by topic, those without messages included.
        blocks: messages by topic.
        custom_data: remarks at the head of the file.
        problems: what is missing or damaged.
        closed: whether the recorder closed the file.
    """

    path: Path
    types: dict[str, str] = field(default_factory=dict)
    blocks: dict[str, TopicBlocks] = field(default_factory=dict)
    custom_data: dict[str, str] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    closed: bool = False
    _channels: dict[int, str] = field(default_factory=dict)

    def announce(self, channel: int, absolute: str, ros_type: str) -> None:
        """A topic has a number in this file; said again, it must be the same.

        Raises:
            InputError: two topics differ in their namespace only.
        """
        name = topic_name(absolute)
        others = {known for number, known in self._channels.items() if number != channel}
        if self._channels.get(channel, name) != name or name in others:
            raise InputError(f"topic {name!r} occurs twice", file=self.path)
        self._channels[channel] = name
        self.types[name] = ros_type
        self.blocks.setdefault(name, TopicBlocks())

    def of(self, channel: int) -> TopicBlocks:
        """The messages of a topic by its number.

        Raises:
            KeyError: it was not announced.
        """
        return self.blocks[self._channels[channel]]
