"""The recorder on the graph: raw messages into a bag, acknowledged, closed when the flight has ended."""

from __future__ import annotations

from time import monotonic

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from heli_common.component import Message
from heli_common.nodes.connection import Connection
from heli_common.nodes.qos import DATA
from heli_common.topics import BENCH_SIM, RECORDER
from heli_flight.arrivals import Arrivals
from heli_flight.bag import BagWriter
from heli_flight.recorder import FlightRecorder

DIAGNOSTICS = "diagnostics"
CLOSING_SECONDS = 3.0
TURN_SECONDS = 0.02


class RecorderProgram:
    """Writes every data topic and diagnostics until the flight has ended and is complete.

    Args:
        node: of the recorder.
        bag: to write into.
        topics: that are recorded.
        real_time: whether time between arrivals means anything.
    """

    name = RECORDER
    outputs: tuple[str, ...] = ("recorder_ack",)
    waking: tuple[str, ...] = ()
    ends = True

    def __init__(self, node: Node, bag: BagWriter, topics: tuple[str, ...], real_time: bool) -> None:
        # taken before what leads to it, the newest flight state has everything older behind it
        self.inputs = tuple(sorted(topics, key=lambda topic: topic != "flight_state"))
        self.finished = False
        self._bag = bag
        self._recorder = FlightRecorder(bag, topics)
        self._arrivals = Arrivals(topics) if real_time else None
        if self._arrivals is not None:
            bag.remarks = self._arrivals.remarks
        self._closing_since = 0.0
        self._said: dict[str, str] = {}
        self._words: list[tuple[int, bytes]] = []
        self._bench_ended = False
        self._connection: Connection | None = None
        self._subscription = node.create_subscription(
            DiagnosticArray, DIAGNOSTICS, self._on_diagnostics, DATA, raw=True
        )

    def start(self, connection: Connection) -> None:
        """Keep the connection for acknowledgements."""
        self._connection = connection

    def on_message(self, topic: str, data: bytes) -> None:
        """Keep a message."""
        self._recorder.receive(topic, data)
        if self._arrivals is not None and self._connection is not None:
            self._arrivals.note(topic, data, self._connection.inbox.arrived_ns * 1e-9)

    def _on_diagnostics(self, data: bytes) -> None:
        array = deserialize_message(data, DiagnosticArray)
        stamp_ns = array.header.stamp.sec * 1_000_000_000 + array.header.stamp.nanosec
        self._words.append((stamp_ns, data))
        for status in array.status:
            if status.level == DiagnosticStatus.ERROR:
                self._said.setdefault("result", f"{status.name}: {status.message}")
            elif status.name == BENCH_SIM:
                self._said |= {pair.key: pair.value for pair in status.values}
                self._bench_ended = status.message == "ended"

    def _write_words(self) -> None:
        """Diagnostics come by another way than data: written behind them, they flush nothing too early."""
        for stamp_ns, data in self._words:
            self._bag.write(DIAGNOSTICS, stamp_ns, data)
        self._words.clear()

    def turn(self) -> float:
        """Write and acknowledge; after the end, finish when bag and the bench's last figures are complete."""
        acknowledged = self._recorder.settle()
        self._write_words()
        if acknowledged is not None and self._connection is not None:
            self._connection.publish([Message("recorder_ack", acknowledged, ())])
        if self._recorder.ended_at is not None:
            now = monotonic()
            self._closing_since = self._closing_since or now
            complete = self._recorder.complete and self._bench_ended
            self.finished = complete or now - self._closing_since > CLOSING_SECONDS
        return TURN_SECONDS

    def close(self) -> None:
        """Store late commands and the reason of a stop, and finish the bag."""
        self._write_words()
        self._recorder.close(self._said)
