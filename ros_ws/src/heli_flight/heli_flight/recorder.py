"""What the recorder does with messages, without ROS: a bag that ends exactly where the flight ended."""

from __future__ import annotations

from heli_common.flight_state import flight_state_from_code
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import TOPICS, data_topics
from heli_flight.bag import BagWriter

ACKNOWLEDGE_NS = 100_000_000
"""An acknowledgement is due each time the bag is complete for so much longer."""


class FlightRecorder:
    """Holds a message until the flight state of its stamp is known, then writes it, or drops what came after.

    Topics arrive in order of their stamps but may come in bursts, one topic after the other; whichever
    message completes a stretch of the flight makes the acknowledgement due.

    Args:
        bag: to write into.
        topics: that are recorded.

    Attributes:
        ended_at: stamp of the first flight state that ends the flight [ns], or None.
    """

    def __init__(self, bag: BagWriter, topics: tuple[str, ...] = data_topics()) -> None:
        self.ended_at: int | None = None
        self._bag = bag
        self._held: list[tuple[int, str, bytes]] = []
        self._last = dict.fromkeys(topics, -1)
        # a slow topic says nothing of the time until its next message
        self._until_next = {name: max(0, TOPICS[name].period_ns - CONTROL_PERIOD_NS) for name in topics}
        self._stamps = {topic: TOPICS[topic].layout.stamp for topic in topics}
        self._state_layout = TOPICS["flight_state"].layout
        self._acknowledged_ns = -1

    @property
    def complete_until(self) -> int:
        """Stamp up to which every topic has arrived [ns]."""
        return min(last + (self._until_next[topic] if last >= 0 else 0) for topic, last in self._last.items())

    @property
    def complete(self) -> bool:
        """Whether the flight has ended and everything of it has arrived."""
        return self.ended_at is not None and self.complete_until >= self.ended_at

    def receive(self, topic: str, data: bytes) -> int | None:
        """Take a serialized message in.

        Returns:
            the stamp to acknowledge [ns], or None if nothing is due.
        """
        stamp_ns = self._stamps[topic](data)
        self._last[topic] = stamp_ns
        self._held.append((stamp_ns, topic, data))
        if topic == "flight_state":
            state = flight_state_from_code(self._state_layout.unpack(data)[1][0])
            if self.ended_at is None and state.ended:
                self.ended_at = stamp_ns
            self.release(stamp_ns)
        elif self.ended_at is not None:
            self.release(self.ended_at)
        complete = self.complete_until
        if complete - self._acknowledged_ns >= ACKNOWLEDGE_NS or (
            self.complete and complete > self._acknowledged_ns
        ):
            self._acknowledged_ns = complete
            return complete
        return None

    def release(self, until_ns: int) -> None:
        """Write what is held up to a stamp, but nothing after the end of the flight."""
        end = until_ns if self.ended_at is None else min(until_ns, self.ended_at)
        kept = []
        for entry in self._held:
            if entry[0] <= end:
                self._bag.write(entry[1], entry[0], entry[2])
            else:
                kept.append(entry)
        self._held = kept

    def close(self, remarks: dict[str, str]) -> None:
        """Write what is still held of the flight and finish the bag."""
        self.release(self.ended_at if self.ended_at is not None else 2**62)
        self._bag.close(remarks)
