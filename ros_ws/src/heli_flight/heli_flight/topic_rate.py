"""How often messages come and how large they are, over a moving window, in the words of ros2cli."""

from __future__ import annotations

from collections import deque
from math import sqrt

RATE_WINDOW = 10_000
BANDWIDTH_WINDOW = 100

_UNITS = ((1e6, "MB", 2), (1e3, "KB", 2), (1.0, "B", 0))


class RateWindow:
    """Intervals between the latest messages.

    Args:
        size: number of intervals that are remembered.
    """

    def __init__(self, size: int) -> None:
        self._intervals: deque[float] = deque(maxlen=size)
        self._last: float | None = None

    def add(self, time: float) -> None:
        """A message has come.

        Args:
            time: of its arrival [s], never falling.
        """
        if self._last is not None:
            self._intervals.append(time - self._last)
        self._last = time

    def text(self) -> str:
        """Mean rate [1/s], extreme intervals and their standard deviation [s]; empty before two messages."""
        count = len(self._intervals)
        if not count:
            return ""
        mean = sum(self._intervals) / count
        deviation = sqrt(sum((interval - mean) ** 2 for interval in self._intervals) / count)
        rate = 1.0 / mean if mean > 0.0 else 0.0
        return (
            f"average rate: {rate:.3f}\n\tmin: {min(self._intervals):.3f}s max: {max(self._intervals):.3f}s "
            f"std dev: {deviation:.5f}s window: {count}"
        )


class BandwidthWindow:
    """Sizes of the latest messages.

    Args:
        size: number of messages that are remembered.
    """

    def __init__(self, size: int) -> None:
        self._messages: deque[tuple[float, int]] = deque(maxlen=size)

    def add(self, time: float, size: int) -> None:
        """A message has come.

        Args:
            time: of its arrival [s], never falling.
            size: of it, serialized [bytes].
        """
        self._messages.append((time, size))

    def text(self, now: float) -> str:
        """Bytes a second from the first message remembered until now, and sizes; empty before two messages.

        Args:
            now: on the clock of the arrivals [s].
        """
        if len(self._messages) < 2 or now <= self._messages[0][0]:
            return ""
        sizes = [size for _, size in self._messages]
        speed = sum(sizes) / (now - self._messages[0][0])
        unit, name, digits = next((each for each in _UNITS if speed >= each[0]), _UNITS[-1])
        shown = [f"{value / unit:.{digits}f} {name}" for value in (speed, sum(sizes) / len(sizes))]
        shown += [f"{value / unit:.{digits}f} {name}" for value in (min(sizes), max(sizes))]
        return (
            f"{shown[0]}/s from {len(sizes)} messages\n"
            f"\tMessage size mean: {shown[1]} min: {shown[2]} max: {shown[3]}"
        )
