"""Several processes as one: started together, listened to, and gone together."""

from __future__ import annotations

import contextlib
import ctypes
import os
import selectors
import signal
import subprocess
from collections.abc import Mapping, Sequence
from time import monotonic
from types import TracebackType
from typing import NamedTuple

STOP_SECONDS = 2.0
_PR_SET_PDEATHSIG = 1


class Line(NamedTuple):
    """A line that a process wrote."""

    process: str
    is_error: bool
    text: str


def _die_with_parent() -> None:
    """In the child: ask for SIGTERM when the parent is gone, however it went (Linux)."""
    with contextlib.suppress(OSError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


class ProcessGroup:
    """Starts commands in sessions of their own, so that a Ctrl-C reaches them only through `stop`.

    Args:
        commands: argument list per process name, started in this order.
        environment: of every process.
    """

    def __init__(self, commands: Mapping[str, Sequence[str]], environment: Mapping[str, str]) -> None:
        self._selector = selectors.DefaultSelector()
        self._partial: dict[tuple[str, bool], bytes] = {}
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        try:
            for name, command in commands.items():
                self._start(name, command, environment)
        except BaseException:
            self.stop()
            raise

    def _start(self, name: str, command: Sequence[str], environment: Mapping[str, str]) -> None:
        process = subprocess.Popen(
            list(command),
            env=dict(environment),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=_die_with_parent,
        )
        self._processes[name] = process
        for stream, is_error in ((process.stdout, False), (process.stderr, True)):
            if stream is not None:
                os.set_blocking(stream.fileno(), False)
                self._selector.register(stream, selectors.EVENT_READ, (name, is_error))

    def __enter__(self) -> ProcessGroup:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()

    def read(self, seconds: float) -> list[Line]:
        """Lines written until now; waits at most so long for the first."""
        lines: list[Line] = []
        for key, _ in self._selector.select(seconds):
            name, is_error = key.data
            data = os.read(key.fd, 65536)
            if not data:
                self._selector.unregister(key.fileobj)
            *complete, rest = (self._partial.get(key.data, b"") + data).split(b"\n")
            if not data and rest:
                complete, rest = [*complete, rest], b""
            self._partial[key.data] = rest
            lines += [Line(name, is_error, text.decode(errors="replace")) for text in complete]
        return lines

    def exited(self) -> dict[str, int]:
        """Exit code of each process that has ended; negative for a signal."""
        codes = {name: process.poll() for name, process in self._processes.items()}
        return {name: code for name, code in codes.items() if code is not None}

    def process_ids(self) -> dict[str, int]:
        """Process id of each process."""
        return {name: process.pid for name, process in self._processes.items()}

    def stop(self) -> list[Line]:
        """Interrupt all, wait, kill what is left; returns their last lines."""
        for process in self._processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        lines: list[Line] = []
        deadline = monotonic() + STOP_SECONDS
        while len(self.exited()) < len(self._processes) and monotonic() < deadline:
            lines += self.read(0.02)
        for process in self._processes.values():
            if process.poll() is None:
                process.kill()
            process.wait()
        while self._selector.get_map():
            more = self.read(0.0)
            if not more and not self._selector.select(0.0):
                break
            lines += more
        self._close()
        return lines

    def _close(self) -> None:
        for process in self._processes.values():
            for stream in (process.stdout, process.stderr):
                if stream is not None:
                    with contextlib.suppress(KeyError, ValueError):
                        self._selector.unregister(stream)
                    stream.close()
        self._processes.clear()
