"""The flight in one process: the same components, called directly, no ROS.

Numbers pass through the same wire records as on the graph, so that the bytes are the same.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

from heli_bench_sim.simulator import BenchSimulator
from heli_common.component import Component, Message, update_of
from heli_common.topics import TOPICS

Sink = Callable[[str, int, bytes], None]
"""Called with topic, stamp [ns] and serialized message of everything that is sent."""

Receive = Callable[[str, int, Sequence[float]], list[Message]]
Update = Callable[[], list[Message]]


class InProcessGraph:
    """Routes messages between a bench and the components of a flight.

    Args:
        bench: the simulated bench.
        components: everything else; each topic has one source among them.
        sink: sees every message once, in the order of sending.
    """

    def __init__(self, bench: BenchSimulator, components: Sequence[Component], sink: Sink) -> None:
        self.bench = bench
        self._sink = sink
        self._receivers: dict[str, list[tuple[Receive, Update]]] = {}
        for component in (*components, bench):
            for topic in component.inputs:
                called = (component.receive, update_of(component))
                self._receivers.setdefault(topic, []).append(called)

    def advance(self) -> None:
        """Go on by one sensor period and let everybody act on the sample.

        Raises:
            RuntimeError: a command the bench needs was not sent by anybody.
        """
        if missing := self.bench.missing():
            raise RuntimeError(f"no component sent {', '.join(missing)}")
        queue = deque(self.bench.tick())
        while queue:
            queue.extend(self._deliver(queue.popleft()))

    def _deliver(self, message: Message) -> list[Message]:
        topic, stamp_ns, values = message
        layout = TOPICS[topic].layout
        data = layout.pack(stamp_ns, values)
        self._sink(topic, stamp_ns, data)
        receivers = self._receivers.get(topic, ())
        if not receivers:
            return []
        _, received = layout.unpack(data)
        sent: list[Message] = []
        for receive, update in receivers:
            sent += receive(topic, stamp_ns, received)
            sent += update()
        return sent
