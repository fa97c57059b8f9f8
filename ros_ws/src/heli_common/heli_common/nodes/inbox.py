"""Data messages taken by hand: a node is woken once for a burst of messages, not once for each (spec 7.1).

An executor is told of every single message by the middleware's thread and wakes the node's thread for it.
Here the node waits on the topic that comes last in a burst and then takes whatever has arrived on all. The
executor knows nothing of these subscriptions and goes on to serve parameters, services and timers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.subscription import Subscription

from heli_common.nodes.messages import message_class
from heli_common.nodes.qos import DATA
from heli_common.topics import TOPICS

OnMessage = Callable[[str, bytes], object]
"""Called with topic and serialized message."""

_Source = tuple[str, Callable[[Any, bool], Any], Any]
"""Topic, how to take a message from it, class of its messages."""

_Taken = tuple[str, tuple[bytes, dict[str, int]]]
"""Topic, serialized message and what the middleware says about it."""


def _unused(_data: bytes) -> None:
    """Callback that rclpy asks for; messages are taken by hand."""


class Inbox:
    """The data subscriptions of one node.

    Args:
        node: that subscribes.
        topics: of the table of topics.
        waking: those that come last in a burst: a message on one of them ends a wait. When a wait ended
            without such a message, or what it brought was no complete burst, the next one ends with any.
            None for a node that waits for no message.

    Attributes:
        arrived_ns: when the middleware got the message being delivered [ns of the system clock].
    """

    def __init__(self, node: Node, topics: Iterable[str], waking: Iterable[str] = ()) -> None:
        self.arrived_ns = 0
        self._subscriptions = {topic: _subscribe(node, topic) for topic in topics}
        last = set(waking)
        sources: list[_Source] = [
            (topic, each.handle.take_message, each.msg_type) for topic, each in self._subscriptions.items()
        ]
        self._ends = [source for source in sources if source[0] in last]
        self._begins = [source for source in sources if source[0] not in last]
        self._last = [self._subscriptions[topic].handle for topic, _, _ in self._ends]
        self._any = [each.handle for each in self._subscriptions.values()] if self._ends else []
        self._whole = False
        self._left: list[_Source] = []

    def full_name(self, topic: str) -> str:
        """Name of a topic with its namespace, after remapping."""
        return str(self._subscriptions[topic].topic_name)

    def leave(self, topic: str) -> None:
        """Take no more messages of a topic from the middleware: they come by another way."""
        self._left += [source for source in (*self._begins, *self._ends) if source[0] == topic]
        self._begins = [source for source in self._begins if source[0] != topic]
        self._ends = [source for source in self._ends if source[0] != topic]
        left = self._subscriptions[topic].handle
        self._last = [handle for handle in self._last if handle is not left]
        self._any = [handle for handle in self._any if handle is not left]

    def publisher_count(self, topic: str) -> int:
        """How many publishers the middleware has matched with the subscription."""
        return int(self._subscriptions[topic].get_publisher_count())

    @property
    def awaited(self) -> list[Any]:
        """Handles of the subscriptions on which a message ends the next wait."""
        return self._last if self._whole else self._any

    def take(self, on_message: OnMessage) -> int:
        """Deliver what has come, behind it one message of each topic that ends a burst.

        When several bursts have come since the last look, all are delivered in the order of their stamps: who
        waits for the end of a burst must not think it lost because the beginnings of others stand before it.

        Returns:
            how many messages; 0 if nothing has come, or only the beginning of a burst.
        """
        ends = [(topic, taken) for topic, take, kind in self._ends if (taken := take(kind, True)) is not None]
        if self._whole and not ends:
            return 0
        self._whole = bool(ends)
        found = _drain(self._begins)
        if ends and len(found) > len(self._begins):
            ends += _drain(self._ends)
            found += _drain(self._begins)  # those of the ends just taken came before them
            found = sorted([*found, *ends], key=_stamp)
        else:
            found += ends  # a further end waits for the next look, for its burst may have come after this one
        for topic, (data, about) in found:
            self.arrived_ns = about["received_timestamp"]
            on_message(topic, data)
        return len(found)

    def discard(self) -> None:
        """Forget everything that has arrived."""
        _drain([*self._begins, *self._ends])
        self.discard_left()
        self._whole = False

    def discard_left(self) -> None:
        """Forget what has arrived on topics that were left."""
        _drain(self._left)

    def incomplete(self) -> None:
        """The last burst led to nothing, or none came: what is missing may come on any topic."""
        self._whole = False

    def close(self) -> None:
        """Give the subscriptions back before the context goes."""
        for subscription in self._subscriptions.values():
            subscription.destroy()


def _drain(sources: Iterable[_Source]) -> list[_Taken]:
    return [
        (topic, taken) for topic, take, kind in sources for taken in iter(partial(take, kind, True), None)
    ]


def _stamp(message: _Taken) -> int:
    topic, (data, _) = message
    return TOPICS[topic].layout.stamp(data)


def _subscribe(node: Node, topic: str) -> Subscription[Any]:
    kind = message_class(TOPICS[topic].layout.ros_type)
    subscription = node.create_subscription(kind, topic, _unused, DATA, raw=True)
    node._subscriptions.remove(subscription)  # out of the executor's sight, not out of the graph
    return subscription
