"""Messages between nodes of one process, handed over without the middleware.

What rclcpp calls intra-process communication, and rclpy has not: what one node publishes goes straight to
the nodes of this process that subscribe to it, and to the middleware only while somebody outside listens. All
publishers and subscriptions stay visible in the graph. Copies that the middleware brings back are thrown
away, and so is what others publish on a topic whose source is in this process.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from functools import partial

from heli_common.nodes.node_run import FAILURES, NodeRun

_BATCH = 256
"""Messages handed over before the loop looks at its clock again."""


class IntraProcess:
    """What nodes of this process have sent each other and not taken yet, in the order of sending.

    Args:
        runs: the nodes, each with its connection; one alone has nobody to hand anything to.
    """

    def __init__(self, runs: Sequence[NodeRun]) -> None:
        self._queue: deque[tuple[_Line, bytes]] = deque()
        self._runs = runs if len(runs) > 1 else ()
        self._lines = [
            _Line(self._queue, run, topic, runs) for run in self._runs for topic in run.program.outputs
        ]

    def __len__(self) -> int:
        return len(self._queue)

    def look_outside(self) -> None:
        """See which topics somebody outside listens to, and throw away what the middleware brought back."""
        for line in self._lines:
            line.look_outside()
        for run in self._runs:
            run.inbox.discard_left()

    def deliver(self) -> int:
        """Hand over some of the messages, those sent meanwhile behind them; returns how many.

        A node that fails ends the delivery.
        """
        queue, run = self._queue, None
        try:
            for count in range(_BATCH):
                if not queue:
                    return count
                line, data = queue.popleft()
                for run in line.receivers:
                    run.program.on_message(line.topic, data)
        except FAILURES as error:
            if run is not None:
                run.fail(error)
        return _BATCH


class _Line:
    """One topic from its source to the other nodes of this process.

    Attributes:
        topic: of the table of topics.
        receivers: nodes of this process that act on its messages, in their turn.
    """

    def __init__(
        self, queue: deque[tuple[_Line, bytes]], source: NodeRun, topic: str, runs: Sequence[NodeRun]
    ) -> None:
        self.topic = topic
        self._queue = queue
        self._publisher = source.connection.publisher(topic)
        name = self._publisher.topic_name
        hearers = [run for run in runs if topic in run.program.inputs and run.inbox.full_name(topic) == name]
        for run in hearers:
            run.inbox.leave(topic)
        self.receivers = tuple(run for run in hearers if run.program.waking)
        # who waits for no message only keeps it until its own turn
        self._keepers = tuple(
            partial(run.program.on_message, topic) for run in hearers if not run.program.waking
        )
        source.connection.divert(topic, self._send)
        self._own, self._outside = len(hearers), False
        self.look_outside()

    def look_outside(self) -> None:
        """Whether the middleware knows of more subscriptions than those of this process."""
        self._outside = self._publisher.get_subscription_count() > self._own

    def _send(self, data: bytes) -> None:
        for keep in self._keepers:
            keep(data)
        if self.receivers:
            self._queue.append((self, data))
        if self._outside:
            self._publisher.publish(data)
