"""Campaigns: many flights over processes or a dask cluster, kept flight by flight, the same on any of them.

What a flight is depends on the campaign and its number alone. Rows are written to a journal as they come, in
whatever order; results are made of the sorted rows. A campaign that was interrupted goes on where it was: the
journal's first line says which campaign it is of, and another one is refused.
"""

from __future__ import annotations

import hashlib
import json
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import closing, nullcontext
from multiprocessing import get_context, parent_process
from pathlib import Path
from typing import Any

from heli_common.errors import InputError
from heli_common.kernel_cache import source_hash
from heli_flight.campaign_flight import Campaign

JOURNAL = "flights.jsonl"
CHUNK = 5
"""Flights that a worker takes at once; as many are flown again at most after a kill."""

PATIENCE = "5s"
"""For which a scheduler is waited for."""

AHEAD = 3
"""Chunks per worker that wait to be flown."""

Row = dict[str, Any]
Tell = Callable[[int, int], None]
"""Called with how many flights there are and of how many."""


def fingerprint(campaign: Campaign) -> str:
    """SHA-256 over everything that decides the flights: plan, vary file, controllers, sources."""
    vary = campaign.vary
    texts = [
        campaign.plan.to_yaml(),
        repr((vary.seed, dict(vary.choices), dict(vary.numbers), vary.faults, dict(vary.grid), vary.max_xy)),
        *(f"{name}\n{file.to_yaml()}" for name, file in sorted(campaign.controllers.items())),
        campaign.motor.to_yaml(),
        source_hash(),
    ]
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()


class Journal:
    """The rows flown so far, one JSON line each, in a file that survives a kill at any moment.

    Args:
        folder: of the campaign, made if it is not there.
        campaign: whose flights they are.

    Attributes:
        rows: by number of the flight.

    Raises:
        InputError: the folder holds another campaign, or something else.
    """

    def __init__(self, folder: Path, campaign: Campaign) -> None:
        self.rows: dict[int, Row] = {}
        self._path = folder / JOURNAL
        head = json.dumps({"campaign": fingerprint(campaign)})
        if self._path.exists():
            self._read(head)
        elif folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise InputError("is not empty", allowed="a new folder, or one of a campaign", file=folder)
        else:
            folder.mkdir(parents=True, exist_ok=True)
            self._path.write_text(head + "\n")
        self._file = self._path.open("a")

    def _read(self, head: str) -> None:
        text = self._path.read_text()
        whole = text[: text.rfind("\n") + 1]  # a kill may have cut the last line
        lines = whole.splitlines()
        if not lines or lines[0] != head:
            allowed = "the same plan, vary file, controllers and version of the sources, or a new folder"
            raise InputError("holds another campaign", allowed=allowed, file=self._path)
        for line in lines[1:]:
            found: Row = json.loads(line)
            self.rows[found["flight"]] = found
        if len(whole) < len(text):
            with self._path.open("r+b") as file:
                file.truncate(len(whole.encode()))

    def add(self, rows: Sequence[Row]) -> None:
        """Keep rows; they are on their way to the disk before the next ones come."""
        for found in rows:
            self.rows[found["flight"]] = found
            self._file.write(json.dumps(found) + "\n")
        self._file.flush()

    def close(self) -> None:
        """No more rows."""
        self._file.close()


def run_campaign(
    campaign: Campaign, flights: int, folder: Path, tell: Tell, *, workers: int = 1, dask: str = ""
) -> list[Row]:
    """Fly what is not flown yet; the rows of all flights by number.

    Args:
        campaign: whose flights.
        flights: how many there shall be.
        folder: for the journal.
        tell: how far it is.
        workers: processes on this machine.
        dask: address of a scheduler that has the workers, instead; empty for none.

    Raises:
        InputError: the folder holds another campaign, or no scheduler answers.
    """
    with _cluster(dask) if dask else nullcontext() as client, closing(Journal(folder, campaign)) as journal:
        left = [number for number in range(flights) if number not in journal.rows]
        chunks = [left[at : at + CHUNK] for at in range(0, len(left), CHUNK)]
        done = flights - len(left)
        tell(done, flights)
        flown = _on_cluster(campaign, chunks, client) if dask else _on_processes(campaign, chunks, workers)
        for rows in flown:
            journal.add(rows)
            done += len(rows)
            tell(done, flights)
    return [journal.rows[number] for number in range(flights)]


# Workers ---------------------------------------------------------------------------------------------------

_own: Campaign | None = None
"""Of a worker process."""


def _begin(campaign: Campaign) -> None:
    global _own
    _own = campaign
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    threading.Thread(target=_follow_parent, daemon=True).start()


def _follow_parent() -> None:
    """End with the parent, however it ended."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _fly(numbers: Sequence[int]) -> list[Row]:
    if _own is None:
        raise RuntimeError("this worker has no campaign")
    return fly_chunk(_own, numbers)


def fly_chunk(campaign: Campaign, numbers: Sequence[int]) -> list[Row]:
    """The rows of some flights."""
    return [campaign.fly(number) for number in numbers]


def _on_processes(campaign: Campaign, chunks: Sequence[Sequence[int]], workers: int) -> Iterator[list[Row]]:
    """Rows in the order in which they are ready."""
    if not chunks:
        return
    pool = ProcessPoolExecutor(
        min(workers, len(chunks)),
        mp_context=get_context("spawn"),
        initializer=_begin,
        initargs=(campaign,),
    )
    coming = iter(chunks)
    waiting: set[Future[list[Row]]] = set()
    try:
        while True:
            while len(waiting) < AHEAD * workers and (chunk := next(coming, None)) is not None:
                waiting.add(pool.submit(_fly, chunk))
            if not waiting:
                break
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
    finally:
        pool.shutdown(cancel_futures=True)


def _cluster(address: str) -> Any:
    """A client of a dask scheduler.

    Raises:
        InputError: no scheduler answers, or one of its workers has other sources.
    """
    from distributed import Client

    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        allowed = "address of a running scheduler, for example tcp://127.0.0.1:8786"
        raise InputError(f"{address!r}: {error}", allowed=allowed, key="--dask") from None
    own = source_hash()
    for worker, other in client.run(source_hash).items():
        if other != own:
            client.close()
            problem = f"worker {worker} has other sources of these packages"
            raise InputError(problem, allowed="the same version everywhere", key="--dask")
    return client


def _on_cluster(campaign: Campaign, chunks: Sequence[Sequence[int]], client: Any) -> Iterator[list[Row]]:
    """The same by the workers of a dask scheduler, which have this package installed."""
    from distributed import as_completed

    everywhere = client.scatter(campaign, broadcast=True)
    futures = [client.submit(fly_chunk, everywhere, chunk, pure=False) for chunk in chunks]
    for future in as_completed(futures, loop=client.loop):
        yield future.result()
        future.release()
