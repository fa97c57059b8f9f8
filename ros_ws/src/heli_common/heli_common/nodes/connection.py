"""One component's connection to the graph: raw fixed-layout messages out and in, readiness, diagnostics."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable, Mapping
from time import monotonic

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.duration import Duration
from rclpy.node import Node
from std_msgs.msg import String

from heli_common.component import Message
from heli_common.errors import InputError
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
        on_message: called with topic and serialized message; never before `open` returned True.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        running: tuple[str, ...],
        inputs: Iterable[str],
        outputs: Iterable[str],
        on_message: Callable[[str, bytes], object],
    ) -> None:
        self.node, self.name, self.running = node, name, running
        self.is_open = False
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
        self._ways_out = {
            topic: (publisher.publish, layouts[topic].pack) for topic, publisher in self._publishers.items()
        }
        self._subscriptions = [self._subscribe(topic, on_message) for topic in inputs]
        self._diagnostics = node.create_publisher(DiagnosticArray, "diagnostics", DATA)
        self._ready = node.create_publisher(String, "ready", LATCHED)
        self._others = node.create_subscription(String, "ready", self._on_ready, READY)

    def _subscribe(self, topic: str, on_message: Callable[[str, bytes], object]) -> object:
        def deliver(data: bytes) -> None:
            if self.is_open:
                on_message(topic, data)

        kind = message_class(TOPICS[topic].layout.ros_type)
        return self.node.create_subscription(kind, topic, deliver, DATA, raw=True)

    def _on_ready(self, message: String) -> None:
        name = message.data.partition(" ")[0]
        self.ready_nodes.add(name)
        if name == self.name and message.data != self._identity and not self._announced:
            self._twin = True

    def open(self) -> bool:
        """Whether the node may act: it is the only one of its name and everyone who must hear it does.

        Raises:
            InputError: another node of this name runs on the same graph.
            TimeoutError: a node of this graph did not appear.
        """
        if self.is_open:
            return True
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
        if missing or waited < DISCOVERY_SECONDS:
            return False
        self.is_open = self._announced = True
        self._ready.publish(String(data=self._identity))
        return True

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
        for subscription in self._subscriptions:
            topic = subscription.topic_name  # type: ignore[attr-defined]
            if self.node.count_publishers(topic) == 0:
                absent.append(f"the publisher of {topic}")
        return absent

    def publish(self, messages: Iterable[Message]) -> None:
        """Send messages of this node's output topics."""
        for topic, stamp_ns, values in messages:
            publish, pack = self._ways_out[topic]
            publish(pack(stamp_ns, values))

    def publish_serialized(self, topic: str, data: bytes) -> None:
        """Send a message that is serialized already."""
        self._publishers[topic].publish(data)

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
