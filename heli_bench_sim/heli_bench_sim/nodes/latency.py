"""How long commands take from the sample they answer, in wall time; figures for diagnostics only."""

from __future__ import annotations

from collections.abc import Iterable
from time import perf_counter

import numpy as np


class Latency:
    """Collects the time from the publication of a sample to the arrival of each command of its stamp.

    Args:
        topics: of the commands.
    """

    def __init__(self, topics: Iterable[str]) -> None:
        self._published: dict[int, float] = {}
        self._seconds: dict[str, list[float]] = {topic: [] for topic in topics}
        self._last = dict.fromkeys(self._seconds, -1)

    def published(self, stamp_ns: int) -> None:
        """The sample of this stamp has just been sent."""
        self._published[stamp_ns] = perf_counter()

    def arrived(self, topic: str, stamp_ns: int) -> None:
        """A command of this stamp has just come."""
        sent = self._published.get(stamp_ns)
        if sent is not None:
            self._seconds[topic].append(perf_counter() - sent)
        self._last[topic] = stamp_ns
        done = min(self._last.values())
        for stamp in [stamp for stamp in self._published if stamp < done]:
            del self._published[stamp]

    def figures(self) -> dict[str, str]:
        """Median, 99.9 % quantile and maximum per topic [ms]."""
        found = {}
        for topic, seconds in self._seconds.items():
            if seconds:
                median, rare, worst = 1e3 * np.quantile(seconds, (0.5, 0.999, 1.0))
                found[f"latency_{topic}_ms"] = f"median {median:.2f}, 99.9 % {rare:.2f}, max {worst:.2f}"
        return found
