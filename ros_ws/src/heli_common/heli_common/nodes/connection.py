"""One component's connection to the graph: raw fixed-layout messages out and in, readiness, diagnostics."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable, Mapping
from time import monotonic
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import String

from heli_common.component import Message
from heli_common.errors import InputError
from heli_common.nodes.inbox import Inbox, OnMessage
from heli_common.nodes.messages import diagnostic, message_class
from heli_common.nodes.qos import DATA, LATCHED, READY
from heli_common.topics import TOPICS, listeners

DISCOVERY_SECONDS = 0.6
"""How long a node looks for another one of its name before it says anything on a data topic."""

PATIENCE_SECONDS = 20.0
"""How long a node waits for the nodes it needs before it gives up by name."""


class Connection:
    """Publishers and subscriptions of one node for the topics of the table.

    Args:
        node: the ROS node.
        name: what this node is in the table of topics; the ROS name may be remapped.
        running: the nodes of this graph. Every publisher waits for those among them that listen to it.
        inputs: topics of the table that it hears.
        outputs: topics of the table that it speaks on.
        waking: inputs that come last in a burst, see `Inbox`.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        running: tuple[str, ...],
        inputs: Iterable[str],
        outputs: Iterable[str],
        waking: Iterable[str] = (),
    ) -> None:
        self.node, self.name, self.running = node, name, running
        self.ready_nodes: set[str] = set()
        self._identity = f"{name} {uuid.uuid4().hex}"
        self._twin = False
        self._since = monotonic()
        self._announced = False
        layouts = {topic: TOPICS[topic].layout for topic in outputs}
        self._publishers = {
            topic: node.create_publisher(message_class(layout.ros_type), topic, DATA)
            for topic, layout in layouts.items()
        }
        self._pack = {topic: layout.pack for topic, layout in layouts.items()}
        self._send: dict[str, Callable[[bytes], None]] = {
            topic: publisher.publish for topic, publisher in self._publishers.items()
        }
        self.inbox = Inbox(node, inputs, waking)
        self._inputs = tuple(inputs)
        self._sent = False
        self._diagnostics = node.create_publisher(DiagnosticArray, "diagnostics", DATA)
        self._ready = node.create_publisher(String, "ready", LATCHED)
        self._others = node.create_subscription(String, "ready", self._on_ready, READY)

    def _on_ready(self, message: String) -> None:
        name = message.data.partition(" ")[0]
        self.ready_nodes.add(name)
        if name == self.name and message.data != self._identity and not self._announced:
            self._twin = True

    def wired(self) -> bool:
        """Whether everyone who must hear the node does, and it has looked for another one of its name.

        Raises:
            InputError: another node of this name runs on the same graph.
            TimeoutError: a node of this graph did not appear.
        """
        self.inbox.discard()
        if self._twin:
            place = f"namespace {self.node.get_namespace()}"
            raise InputError(
                f"another {self.name} already runs on this graph ({place})",
                allowed="one per namespace; use another namespace or ROS_DOMAIN_ID",
            )
        waited = monotonic() - self._since
        missing = self.missing()
        if missing and waited > PATIENCE_SECONDS:
            raise TimeoutError(f"waited {waited:.0f} s in vain for {', '.join(missing)}")
        return not missing and waited >= DISCOVERY_SECONDS

    def open(self) -> bool:
        """Say that the node is ready, once it is wired; returns whether it has been said.

        Others begin to fly as soon as all have said so: whatever takes long must have been done before.

        Raises:
            InputError, TimeoutError: as `wired`.
        """
        if not self._announced and self.wired():
            self._announced = True
            self._ready.publish(String(data=self._identity))
        return self._announced

    def absent(self) -> list[str]:
        """Nodes of this graph that have not said yet that they are ready."""
        return [node for node in self.running if node not in (*self.ready_nodes, self.name)]

    def missing(self) -> list[str]:
        """Listeners and speakers that this node still waits for, each as `node (topic)`."""
        absent = []
        for topic, publisher in self._publishers.items():
            expected = listeners(topic, self.running)
            if publisher.get_subscription_count() < len(expected):
                absent.append(f"{' or '.join(expected)} ({topic})")
        for topic in self._inputs:
            if self.inbox.publisher_count(topic) == 0:
                absent.append(f"the publisher of {topic}")
        return absent

    def take(self, on_message: OnMessage) -> int:
        """Deliver every message that has arrived; returns how many.

        Args:
            on_message: called with topic and serialized message.
        """
        self._sent = False
        count = self.inbox.take(on_message)
        if count and not self._sent:
            self.inbox.incomplete()
        return count

    def publish(self, messages: Iterable[Message]) -> None:
        """Send messages of this node's output topics."""
        self._sent = True
        for topic, stamp_ns, values in messages:
            self._send[topic](self._pack[topic](stamp_ns, values))

    def publish_serialized(self, topic: str, data: bytes) -> None:
        """Send a message that is serialized already."""
        self._send[topic](data)

    def publisher(self, topic: str) -> Publisher[Any]:
        """The publisher of an output topic."""
        return self._publishers[topic]

    def divert(self, topic: str, send: Callable[[bytes], None]) -> None:
        """From now on give serialized messages of an output topic to `send`, not to its publisher."""
        self._send[topic] = send

    def diagnose(
        self, stamp_ns: int, level: str, text: str, values: Mapping[str, object] | None = None
    ) -> None:
        """Say on `diagnostics` how this node is; `level` is ok, warn or error."""
        self._diagnostics.publish(diagnostic(stamp_ns, self.name, level, text, values))

    def flush(self, seconds: float = 0.5) -> None:
        """Wait until every living subscriber has got what was published, or the time is over."""
        deadline = monotonic() + seconds
        for publisher in (*self._publishers.values(), self._diagnostics):
            left = max(0.0, deadline - monotonic())
            publisher.wait_for_all_acked(Duration(nanoseconds=int(left * 1e9)))
