"""Work handed to a few processes: results as they come, and nothing left behind when it is interrupted."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import get_context
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def _deaf() -> None:
    """The keyboard's interrupt reaches the parent only, which then ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def worked(work: Callable[[Job], Result], jobs: Sequence[Job], workers: int) -> Iterator[Result]:
    """Results of `work` in the order in which they become known; with one worker in this process, in order.

    Args:
        work: a function of a module, its jobs and results picklable.
        jobs: to be done.
        workers: processes, at least 1.
    """
    if workers == 1 or len(jobs) < 2:
        yield from map(work, jobs)
        return
    with get_context("spawn").Pool(min(workers, len(jobs)), initializer=_deaf) as pool:
        yield from pool.imap_unordered(work, jobs)
