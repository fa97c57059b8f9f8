"""One line of progress: written by the supervisor, read by people and by `heli fly`."""

from __future__ import annotations

import re
from dataclasses import dataclass

from heli_common.flight_state import FlightState

_LINE = re.compile(r"^ *(\d+\.\d) s  (\S+)  phase (\d+)/(\d+)(?:  (.*))?$")


@dataclass(frozen=True)
class Progress:
    """How far a flight is.

    Attributes:
        time: simulated time [s].
        state: stage of the flight.
        phase: number of the phase being flown, from 1.
        phases: how many the plan has, 0 without a plan.
        reason: why it was stopped, or an empty string.
    """

    time: float
    state: FlightState
    phase: int
    phases: int
    reason: str = ""

    def line(self) -> str:
        """For people, and for `parse`."""
        text = f"{self.time:6.1f} s  {self.state.word}  phase {self.phase}/{self.phases}"
        return f"{text}  {self.reason}" if self.reason else text


def parse(line: str) -> Progress | None:
    """The progress of a line, or None if it is none."""
    match = _LINE.match(line.rstrip())
    words = {state.word: state for state in FlightState}
    if match is None or match[2] not in words:
        return None
    return Progress(float(match[1]), words[match[2]], int(match[3]), int(match[4]), match[5] or "")
