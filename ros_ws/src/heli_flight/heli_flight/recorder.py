"""What the recorder does with messages, without ROS: a bag that ends exactly where the flight ended."""

from __future__ import annotations

from collections import deque

from heli_common.flight_state import flight_state_from_code
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_flight.bag import BagWriter

ACKNOWLEDGE_NS = 100_000_000
"""An acknowledgement is due each time the bag is complete for so much longer."""


class FlightRecorder:
    """Holds a message until the flight state of its stamp is known, then writes it, or drops what came after.

    Messages are kept as they come and looked at together, every now and then. Topics arrive in order of their
    stamps but may come in bursts, one topic after the other; whichever message completes a stretch of the
    flight makes the acknowledgement due.

    Args:
        bag: to write into.
        topics: that are recorded.

    Attributes:
        ended_at: stamp of the first flight state that ends the flight [ns], or None.
    """

    def __init__(self, bag: BagWriter, topics: tuple[str, ...] = DATA_TOPICS) -> None:
        self.ended_at: int | None = None
        self._bag = bag
        self._tracks = {topic: _Track(topic) for topic in topics}
        self._acknowledged_ns = -1

    @property
    def complete_until(self) -> int:
        """Stamp up to which every topic has arrived [ns]."""
        return min(track.complete_until for track in self._tracks.values())

    @property
    def complete(self) -> bool:
        """Whether the flight has ended and everything of it has arrived."""
        return self.ended_at is not None and self.complete_until >= self.ended_at

    def receive(self, topic: str, data: bytes) -> None:
        """Take a serialized message in."""
        self._tracks[topic].arrived.append(data)

    def settle(self) -> int | None:
        """Write what has arrived, as far as the flight state is known.

        Returns:
            the stamp to acknowledge [ns], or None if nothing is due.

        Raises:
            ValueError: a message of another size than agreed.
            OSError: the bag cannot be written any more.
        """
        for track in self._tracks.values():
            track.read()
        state = self._tracks.get("flight_state")
        if state is not None:
            self._look_for_end(state)
            self._release(state.last)
        complete = self.complete_until
        if complete - self._acknowledged_ns >= ACKNOWLEDGE_NS or (
            self.complete and complete > self._acknowledged_ns
        ):
            self._acknowledged_ns = complete
            return complete
        return None

    def close(self, remarks: dict[str, str]) -> None:
        """Write what is still held of the flight and finish the bag."""
        self.settle()
        self._release(2**62)
        self._bag.close(remarks)

    def _look_for_end(self, state: _Track) -> None:
        for stamp_ns, data in state.held:
            if self.ended_at is None and flight_state_from_code(state.layout.unpack(data)[1][0]).ended:
                self.ended_at = stamp_ns

    def _release(self, until_ns: int) -> None:
        """Write what is held up to a stamp, but nothing after the end of the flight."""
        end = until_ns if self.ended_at is None else min(until_ns, self.ended_at)
        for topic, track in self._tracks.items():
            held = track.held
            while held and held[0][0] <= end:
                stamp_ns, data = held.popleft()
                self._bag.write(topic, stamp_ns, data)


class _Track:
    """What has come of one topic and is not written yet."""

    def __init__(self, topic: str) -> None:
        self.layout = TOPICS[topic].layout
        self.arrived: list[bytes] = []
        self.held: deque[tuple[int, bytes]] = deque()
        self.last = -1
        # a slow topic says nothing of the time until its next message
        self._until_next = max(0, TOPICS[topic].period_ns - CONTROL_PERIOD_NS)

    @property
    def complete_until(self) -> int:
        """Stamp up to which the topic has arrived [ns]."""
        return self.last + (self._until_next if self.last >= 0 else 0)

    def read(self) -> None:
        """Hold what has arrived by its stamps."""
        if self.arrived:
            arrived, self.arrived = self.arrived, []
            self.held += zip(map(self.layout.stamp, arrived), arrived, strict=True)
            self.last = self.held[-1][0]
