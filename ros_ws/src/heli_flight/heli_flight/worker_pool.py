"""Work handed to a few processes: results as they come, and nothing left behind when it is interrupted."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import get_context
from multiprocessing.pool import Pool
from types import TracebackType
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def _deaf() -> None:
    """The keyboard's interrupt reaches the parent only, which then ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


class Workers:
    """Processes that live as long as the `with` block; a single worker is this process itself.

    Args:
        count: processes, at least 1.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._pool: Pool | None = None

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is not None:
            self._pool.terminate()
            self._pool.join()

    def results(self, work: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """Results in the order in which they become known; of a single worker in the order of the jobs.

        Args:
            work: a function of a module, its jobs and results picklable.
            jobs: to be done.
        """
        if self._count == 1 or not jobs:
            yield from map(work, jobs)
            return
        if self._pool is None:
            self._pool = get_context("spawn").Pool(self._count, initializer=_deaf)
        yield from self._pool.imap_unordered(work, jobs)
