"""How evenly the messages of a real-time flight arrived, as the recorder saw it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from math import sqrt

from heli_common.topics import TOPICS


class Arrivals:
    """Compares the time between two arrivals of a topic with that between their stamps.

    Args:
        topics: that are watched.
    """

    def __init__(self, topics: Iterable[str]) -> None:
        self._tracks = {topic: _Track(topic) for topic in topics}

    def note(self, topic: str, data: bytes, now: float) -> None:
        """A serialized message has arrived at this wall time [s]."""
        self._tracks[topic].note(data, now)

    def jitter(self) -> dict[str, dict[str, float]]:
        """Per topic with two messages or more: `rms_ms` and `max_ms` of the deviation."""
        return {topic: track.figures() for topic, track in self._tracks.items() if track.count}

    def remarks(self) -> dict[str, str]:
        """The same for a bag's custom data, see `bag_metadata`."""
        return {"jitter": json.dumps(self.jitter())}


class _Track:
    def __init__(self, topic: str) -> None:
        self.count = 0
        self._stamp = TOPICS[topic].layout.stamp
        self._last: tuple[int, float] | None = None
        self._squares = self._largest = 0.0

    def note(self, data: bytes, now: float) -> None:
        stamp_ns = self._stamp(data)
        if self._last is not None:
            deviation = (now - self._last[1]) - (stamp_ns - self._last[0]) * 1e-9
            self.count += 1
            self._squares += deviation * deviation
            self._largest = max(self._largest, abs(deviation))
        self._last = (stamp_ns, now)

    def figures(self) -> dict[str, float]:
        rms = sqrt(self._squares / self.count)
        return {"rms_ms": round(1e3 * rms, 4), "max_ms": round(1e3 * self._largest, 4)}
