"""SIGINT and SIGTERM from the first moment on: one line and exit code 130, never a traceback.

Imported before anything heavy. A process that a shell has put into the background starts with SIGINT ignored,
so it is taken over explicitly.
"""

from __future__ import annotations

import signal
from types import FrameType
from typing import NoReturn


class Interrupted(SystemExit):
    """Raised while modules are still being loaded: nothing has begun yet."""


def _leave(_number: int, _frame: FrameType | None) -> NoReturn:
    raise Interrupted(130)


def _interrupt(_number: int, _frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt


def while_loading() -> None:
    """Until the command runs, a signal ends the process."""
    signal.signal(signal.SIGINT, _leave)
    signal.signal(signal.SIGTERM, _leave)


def while_running() -> None:
    """A running command cleans up on KeyboardInterrupt."""
    signal.signal(signal.SIGINT, _interrupt)
    signal.signal(signal.SIGTERM, _interrupt)


while_loading()
