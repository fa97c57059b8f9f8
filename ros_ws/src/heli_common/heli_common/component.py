"""What a node computes, without ROS: messages in, messages out.

A component is a deterministic process: what it sends depends only on the sequence of messages on each of
its inputs, never on how the inputs interleave. Several inputs are therefore joined on their stamp. The same
component object runs inside a ROS node, composed with others, or in the in-process flight; that is why the
three ways of running give the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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


def update_of(component: Component) -> Callable[[], list[Message]]:
    """What is to be called when the messages of `receive` are out: the component's `update`, if it has one.

    Somebody waits for a command, but nobody for the states of the next sample: `update` brings them up to
    date and gives back what need not have gone out at once, as digital controllers do against computational
    delay (Astrom, Wittenmark: Computer-Controlled Systems). Not called, it is done with the next message.
    """
    return getattr(component, "update", list)


PATIENCE = 5
"""Stamps in a row without an optional topic after which it is no longer waited for."""


class StampJoin:
    """Collects one message from each of several topics for every stamp.

    Topics arrive in order of their stamps, but not in step with each other. A late consumer must not grow
    without bound: when a newer stamp is complete, older incomplete ones are dropped and counted.

    An optional topic is waited for until all others are there for a newer stamp too; then the older set is
    given without it. In lockstep that cannot happen: no newer stamp comes before the older one is answered.

    Args:
        topics: without which no set is complete.
        optional: topics of a node that may be lost while the flight goes on.

    Attributes:
        stamp_ns: of the set given last [ns].
        dropped: incomplete sets so far.
    """

    def __init__(self, topics: Sequence[str], optional: Sequence[str] = ()) -> None:
        self._topics = (*topics, *optional)
        self._needed, self._all = frozenset(topics), frozenset(self._topics)
        self._missed = 0
        self._waiting: dict[int, dict[str, Sequence[float]]] = {}
        self.stamp_ns = -1
        self.dropped = 0

    def add(self, topic: str, stamp_ns: int, values: Sequence[float]) -> dict[str, Sequence[float]] | None:
        """The complete set of a stamp, or None while something is missing.

        Raises:
            ValueError: the topic is none of those joined.
        """
        if topic not in self._topics:
            raise ValueError(f"topic {topic!r} is none of {self._topics}")
        entry = self._waiting.setdefault(stamp_ns, {})
        entry[topic] = values
        if not entry.keys() >= self._needed:
            return None
        if entry.keys() >= self._all:
            self._missed = 0
        elif self._missed < PATIENCE:
            older = [s for s, e in self._waiting.items() if s < stamp_ns and e.keys() >= self._needed]
            if not older:
                return None
            self._missed += 1
            if self._missed < PATIENCE:
                stamp_ns = max(older)
        return self._take(stamp_ns)

    def _take(self, stamp_ns: int) -> dict[str, Sequence[float]]:
        self.stamp_ns = stamp_ns
        entry = self._waiting.pop(stamp_ns)
        if not self._waiting:
            return entry
        stale = [stamp for stamp in self._waiting if stamp < stamp_ns]
        for stamp in stale:
            del self._waiting[stamp]
        self.dropped += len(stale)
        return entry
