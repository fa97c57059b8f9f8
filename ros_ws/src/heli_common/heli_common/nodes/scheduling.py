"""Real-time scheduling of a process and its middleware threads, where the system permits it (spec 7.3)."""

from __future__ import annotations

import gc
import os
import struct
from pathlib import Path

LATENCY_REQUEST = Path("/dev/cpu_dma_latency")
"""Linux holds every core to the wake-up time [us] that is written here for as long as the file stays open."""


def become_real_time(priority: int) -> str:
    """Put every thread of this process under SCHED_FIFO and keep the collector off what is already there.

    To be called when all threads of the middleware exist. Not being permitted is no error.

    Returns:
        an empty string, or, where a priority was asked for, why ordinary scheduling stays.
    """
    gc.collect()
    gc.freeze()
    if priority <= 0:
        return ""
    try:
        for thread in _threads():
            os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError) as error:
        return f"SCHED_FIFO is not permitted ({error})"
    return ""


def stay_on(core: int) -> str:
    """Keep every thread of this process on one core of the machine, from now on.

    To be called when all threads of the middleware exist. Not being permitted is no error.

    Args:
        core: its number, negative for any.

    Returns:
        an empty string, or, where a core was asked for, why the process runs on any.
    """
    if core < 0:
        return ""
    try:
        for thread in _threads():
            os.sched_setaffinity(thread, {core})
    except (OSError, AttributeError) as error:
        return f"core {core} is not to be had ({error})"
    return ""


def _threads() -> list[int]:
    """Numbers of the threads of this process."""
    return [int(task.name) for task in Path("/proc/self/task").iterdir()]


class Awake:
    """Keeps all cores out of sleep from which they wake up late, while it exists.

    Only for a process under real-time scheduling, and only where the system permits it. Not being permitted
    is no error.

    Attributes:
        held: whether the cores are kept awake.
    """

    def __init__(self) -> None:
        self._file: int | None = None
        if os.sched_getscheduler(0) != os.SCHED_FIFO:
            return
        try:
            self._file = os.open(LATENCY_REQUEST, os.O_WRONLY)
            os.write(self._file, struct.pack("=i", 0))
        except OSError:
            self.end()

    @property
    def held(self) -> bool:
        """Whether the cores are kept awake."""
        return self._file is not None

    def end(self) -> None:
        """Let them sleep again."""
        if self._file is not None:
            os.close(self._file)
            self._file = None
