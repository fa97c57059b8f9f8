"""Flights of a reproduction, one file each: flown once, kept, found again after an interruption."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from heli_common.errors import InputError
from heli_common.files import write_atomically
from heli_common.kernel_cache import source_hash
from heli_control.controller_file import load_controller
from heli_flight.components import DEFAULTS
from heli_flight.imported_sources import imported_sources
from heli_flight.parameter_file import NodeValues, read_parameters
from heli_flight.plan import load_plan
from heli_flight.reproduction_flights import PLANS, Job, Outcome, fly_job
from heli_flight.worker_pool import Workers

FLIGHTS = "flights"
_META = "meta"
Tell = Callable[[Job, int, int], None]
"""Called after every flight with what was flown, how many are done and of how many."""


def flying_sources() -> tuple[str, ...]:
    """Of heli_flight, the files that a flight depends on: an edit of the page flies nothing again."""
    return imported_sources(Path(__file__).parent, "reproduction_flights")


def flying_hash(parameters: Path | None = None) -> str:
    """SHA-256 of everything that flights depend on but plan and controller: sources and parameters.

    Args:
        parameters: parameter file of the nodes.
    """
    more = parameters.read_bytes() if parameters else b""
    return source_hash({"heli_flight": flying_sources()}, more)


def job_hash(job: Job, flying: str) -> str:
    """SHA-256 of everything that a job's outcome depends on.

    Args:
        job: to be flown.
        flying: of `flying_hash`.
    """
    plan, controller = load_plan(PLANS[job.experiment]), load_controller(job.controller)
    parts = (flying, repr(job), plan.to_yaml(), controller.to_yaml())
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def save(path: Path, outcome: Outcome, key: str) -> None:
    """Write an outcome.

    Args:
        path: of the file.
        outcome: of a job; curves lose what single precision does not hold.
        key: hash of the job.
    """
    meta = json.dumps({"hash": key, "lost": outcome.lost, "figures": outcome.figures})
    stream = io.BytesIO()
    arrays: dict[str, Any] = {name: curve.astype(np.float32) for name, curve in outcome.curves.items()}
    arrays[_META] = np.array(meta)
    np.savez_compressed(stream, **arrays)
    write_atomically(path, stream.getvalue())


def load(path: Path, key: str) -> Outcome | None:
    """Read an outcome; None if there is none of this hash, or the file is damaged."""
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as stored:
            meta = json.loads(str(stored[_META]))
            if meta["hash"] != key:
                return None
            curves = {name: stored[name].astype(np.float64) for name in stored.files if name != _META}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return Outcome(meta["lost"], meta["figures"], curves)


def flown(
    jobs: Sequence[Job], out: Path, workers: int, tell: Tell, parameters: Path | None = None
) -> dict[Job, Outcome]:
    """Outcomes of all jobs: from their files, or flown now.

    Args:
        jobs: to be flown.
        out: folder that keeps a file for each.
        workers: processes.
        tell: how far it is.
        parameters: parameter file of the nodes.

    Raises:
        InputError: a parameter file that is none, or the folder cannot be written.
    """
    if parameters is not None:
        read_parameters(parameters)
    folder, flying = out / FLIGHTS, flying_hash(parameters)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=folder, key="--out") from None
    found: dict[Job, Outcome] = {}
    todo: list[tuple[Job, str]] = []
    for job in jobs:
        key = job_hash(job, flying)
        outcome = load(folder / f"{job.key}.npz", key)
        if outcome is None:
            todo.append((job, key))
        else:
            found[job] = outcome
    done = len(found)
    with Workers(workers) as pool:
        for job, outcome in pool.results(partial(_fly, folder, parameters), todo):
            found[job] = outcome
            done += 1
            tell(job, done, len(jobs))
    return found


def _fly(folder: Path, parameters: Path | None, task: tuple[Job, str]) -> tuple[Job, Outcome]:
    job, key = task
    values: NodeValues = read_parameters(parameters) if parameters else DEFAULTS
    outcome = fly_job(job, values)
    path = folder / f"{job.key}.npz"
    save(path, outcome, key)
    loaded = load(path, key)  # what is shown is what is kept
    if loaded is None:
        raise InputError("cannot be read back", file=path)
    return job, loaded
