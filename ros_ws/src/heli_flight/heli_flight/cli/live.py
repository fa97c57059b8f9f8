"""Live progress of a flight: a bar on a terminal, a line for each change of stage anywhere else."""

from __future__ import annotations

from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from heli_common.flight_state import FlightState
from heli_flight import progress as flight_progress


class LiveProgress:
    """Shows how far a flight is, on standard error.

    Args:
        duration: estimate of the flight's length [s].
        quiet: show nothing.
    """

    def __init__(self, duration: float, quiet: bool) -> None:
        self._console = Console(stderr=True, quiet=quiet)
        self._bar = Progress(
            TextColumn("{task.fields[state]:>9}"),
            BarColumn(),
            TextColumn("{task.completed:5.1f} of about {task.total:.0f} s"),
            TimeRemainingColumn(),
            console=self._console,
            disable=not self._console.is_terminal,
        )
        self._task = self._bar.add_task("flight", total=duration, state="starting")
        self._state: FlightState | None = None

    def __enter__(self) -> LiveProgress:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def show(self, seen: flight_progress.Progress) -> None:
        """A line of progress of the supervisor."""
        self._bar.update(self._task, completed=seen.time, state=seen.state.word)
        if not self._console.is_terminal and seen.state is not self._state:
            self._state = seen.state
            self.warn(seen.line())

    def warn(self, text: str) -> None:
        """A remark that stays on the screen."""
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)
