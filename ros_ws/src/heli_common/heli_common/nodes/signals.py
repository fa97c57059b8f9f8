"""SIGINT and SIGTERM as a flag, set before rclpy is imported so that a node can drain and close in order."""

from __future__ import annotations

import signal
from types import FrameType


class StopFlag:
    """True once a signal has asked the process to end."""

    def __init__(self) -> None:
        self.signal_number = 0

    def __bool__(self) -> bool:
        return self.signal_number != 0

    def _on_signal(self, number: int, _frame: FrameType | None) -> None:
        self.signal_number = number

    def install(self) -> None:
        """Take SIGINT and SIGTERM over from Python's defaults."""
        signal.signal(signal.SIGINT, self._on_signal)
        signal.signal(signal.SIGTERM, self._on_signal)


STOP = StopFlag()
