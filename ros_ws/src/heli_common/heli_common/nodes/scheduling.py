"""Real-time scheduling of a process and its middleware threads, where the system permits it (spec 7.3)."""

from __future__ import annotations

import gc
import os
from pathlib import Path


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
        for task in Path("/proc/self/task").iterdir():
            os.sched_setscheduler(int(task.name), os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError) as error:
        return f"SCHED_FIFO is not permitted ({error})"
    return ""
