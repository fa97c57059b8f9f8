"""What a node computes, without ROS: messages in, messages out.

A component is a deterministic process: what it sends depends only on the sequence of messages on each of
its inputs, never on how the inputs interleave. Several inputs are therefore joined on their stamp. The same
component object runs inside a ROS node, composed with others, or in the in-process flight; that is why the
three ways of running give the same bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from heli_common.layout import Values


class Message(NamedTuple):
    """One message between components: the numbers are in the order of the topic's layout."""

    topic: str
    stamp_ns: int
    values: Sequence[float] | Values


class Component(Protocol):
    """A deterministic process with named inputs and outputs."""

    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Take one message in; give back what it caused to be sent, in the order of sending."""
        ...


class StampJoin:
    """Collects one message from each of several topics for every stamp.

    Topics arrive in order of their stamps, but not in step with each other. A late consumer must not grow
    without bound: when a newer stamp is complete, older incomplete ones are dropped and counted.
    """

    def __init__(self, topics: Sequence[str]) -> None:
        self._topics = tuple(topics)
        self._waiting: dict[int, dict[str, Sequence[float]]] = {}
        self.dropped = 0

    def add(self, topic: str, stamp_ns: int, values: Sequence[float]) -> dict[str, Sequence[float]] | None:
        """The complete set of this stamp, or None while something is missing.

        Raises:
            ValueError: the topic is none of those joined.
        """
        if topic not in self._topics:
            raise ValueError(f"topic {topic!r} is none of {self._topics}")
        entry = self._waiting.setdefault(stamp_ns, {})
        entry[topic] = values
        if len(entry) < len(self._topics):
            return None
        del self._waiting[stamp_ns]
        stale = [stamp for stamp in self._waiting if stamp < stamp_ns]
        for stamp in stale:
            del self._waiting[stamp]
        self.dropped += len(stale)
        return entry
