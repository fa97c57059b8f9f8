"""Single keys of the terminal a node runs in, without waiting for them; none where there is no terminal."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from typing import Any

_ARROWS = {b"\x1b[A": "up", b"\x1b[B": "down", b"\x1b[C": "right", b"\x1b[D": "left"}


class Keys:
    """Reads keys as they are pressed.

    Args:
        descriptor: of the terminal; standard input without. A terminal in whose background we run gives none.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._descriptor = sys.stdin.fileno() if descriptor is None else descriptor
        self._before: list[Any] | None = None
        try:
            if os.isatty(self._descriptor) and (
                descriptor is not None or os.tcgetpgrp(self._descriptor) == os.getpgrp()
            ):
                self._before = termios.tcgetattr(self._descriptor)
                tty.setcbreak(self._descriptor)
        except OSError:
            self._before = None

    @property
    def open(self) -> bool:
        """Whether keys can come."""
        return self._before is not None

    def pressed(self) -> list[str]:
        """Keys since the last call: `up`, `down`, `left`, `right` or the character."""
        found: list[str] = []
        while self._before is not None and select.select([self._descriptor], [], [], 0.0)[0]:
            data = os.read(self._descriptor, 64)
            if not data:
                break
            while data:
                arrow = _ARROWS.get(data[:3])
                found.append(arrow or chr(data[0]))
                data = data[3:] if arrow else data[1:]
        return found

    def close(self) -> None:
        """Leave the terminal as it was."""
        if self._before is not None:
            termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)
            self._before = None
