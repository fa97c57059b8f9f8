"""How punctual a real-time flight is, in wall time: commands after samples, periods after deadlines.

Figures for diagnostics and the bag's remarks only; nothing that is simulated depends on them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from time import perf_counter

import numpy as np

_QUANTILES = {"median": 0.5, "99 %": 0.99, "99.9 %": 0.999, "max": 1.0}


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
        """Median, 99 % and 99.9 % quantile and maximum per topic [ms]."""
        return {f"latency_{topic}_ms": _text(seconds) for topic, seconds in self._seconds.items() if seconds}


class Jitter:
    """Collects by how much later than its deadline the bench begins each control period."""

    def __init__(self) -> None:
        self._seconds: list[float] = []

    def began(self, late: float) -> None:
        """A control period begins so long after its deadline [s]."""
        self._seconds.append(late)

    def figures(self) -> dict[str, str]:
        """Median, 99 % and 99.9 % quantile and maximum [ms]; nothing before the first period."""
        return {"period_jitter_ms": _text(self._seconds)} if self._seconds else {}


def _text(seconds: Sequence[float]) -> str:
    found = 1e3 * np.quantile(seconds, list(_QUANTILES.values()))
    return ", ".join(f"{name} {value:.2f}" for name, value in zip(_QUANTILES, found, strict=True))
