"""What the recorder does with messages, without ROS: a bag that ends exactly where the flight ended."""

from __future__ import annotations

from bisect import bisect_right

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
        self._state_layout = TOPICS["flight_state"].layout
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
        for topic, track in self._tracks.items():
            arrived = track.read()
            if topic == "flight_state":
                self._look_for_end(arrived)
        if "flight_state" in self._tracks:
            self._release(self._tracks["flight_state"].last)
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

    def _look_for_end(self, states: list[bytes]) -> None:
        for data in states:
            stamp_ns, values = self._state_layout.unpack(data)
            if self.ended_at is None and flight_state_from_code(values[0]).ended:
                self.ended_at = stamp_ns

    def _release(self, until_ns: int) -> None:
        """Write what is held up to a stamp, but nothing after the end of the flight.

        All topics together, so that a flush of the bag leaves out nothing older.
        """
        end = until_ns if self.ended_at is None else min(until_ns, self.ended_at)
        released = {topic: track.release(end) for topic, track in self._tracks.items()}
        if released := {topic: messages for topic, messages in released.items() if messages[0]}:
            self._bag.write_all(released)


class _Track:
    """What has come of one topic and is not written, and how far the topic is.

    Attributes:
        arrived: messages that have not been looked at.
        last: newest stamp seen [ns], -1 before the first.
    """

    def __init__(self, topic: str) -> None:
        self.last = -1
        self.arrived: list[bytes] = []
        self._stamps: list[int] = []
        self._held: list[bytes] = []
        self._stamp = TOPICS[topic].layout.stamp
        # a slow topic says nothing of the time until its next message
        self._until_next = max(0, TOPICS[topic].period_ns - CONTROL_PERIOD_NS)

    @property
    def complete_until(self) -> int:
        """Stamp up to which the topic has arrived [ns]."""
        return self.last + (self._until_next if self.last >= 0 else 0)

    def read(self) -> list[bytes]:
        """What has arrived since the last look."""
        found, self.arrived = self.arrived, []
        if found:
            self._stamps += map(self._stamp, found)
            self._held += found
            self.last = self._stamps[-1]
        return found

    def release(self, until_ns: int) -> tuple[list[int], list[bytes]]:
        """Stamps and messages up to a stamp [ns], held no longer."""
        count = bisect_right(self._stamps, until_ns)
        released = self._stamps[:count], self._held[:count]
        del self._stamps[:count], self._held[:count]
        return released
