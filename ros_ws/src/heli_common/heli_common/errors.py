"""The one error of a user's bad input: file, key, value and what is allowed, in one line."""

from __future__ import annotations

from pathlib import Path


class InputError(ValueError):
    """Bad input from outside: a command ends with this line and exit code 2.

    Args:
        problem: what is wrong, with the offending value.
        allowed: what would have been accepted.
        file: the file it stands in, if any.
        key: the key within that file, dotted, if any.
    """

    def __init__(
        self, problem: str, *, allowed: str = "", file: str | Path | None = None, key: str = ""
    ) -> None:
        self.problem, self.allowed, self.file, self.key = problem, allowed, file, key
        place = ": ".join(str(part) for part in (file, key) if part)
        text = f"{place}: {problem}" if place else problem
        super().__init__(f"{text} (allowed: {allowed})" if allowed else text)


class SafetyStop(RuntimeError):
    """A flight that had to be ended for safety: exit code 3, the message says why."""


EXIT_FLOWN = 0
EXIT_DIFFERENT = 1
"""What was compared is not the same."""

EXIT_BAD_INPUT = 2
EXIT_SAFETY_STOP = 3
EXIT_INTERRUPTED = 130
