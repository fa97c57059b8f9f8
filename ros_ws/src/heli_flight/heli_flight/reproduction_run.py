"""Which flights a reproduction consists of, complete or quick."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from typing import Any

from heli_flight.published_flights import CONTROLLERS
from heli_flight.reproduction_flights import PLANS, Job


@dataclass(frozen=True)
class Extent:
    """How much is flown.

    Attributes:
        seeds: of each experiment, from 1.
        resolution_deg: of the search for the noise level.
        identified: controllers that fly F5.
    """

    seeds: dict[str, int]
    resolution_deg: float
    identified: tuple[str, ...] = CONTROLLERS


_ONE = dict.fromkeys(PLANS, 1)
COMPLETE = Extent(_ONE | {"F1": 3, "F2": 20, "F3": 3, "F4": 3, "F4b": 3}, 0.1)
QUICK = Extent(_ONE | {"F2": 3}, 0.25, ("lq",))

_LONGEST_FIRST = ("F5", "F4", "F4b", "F3", "F2", "F8", "F7", "F1", "F4n")
"""So that no worker sits on a long flight at the end."""
_DRAWN = ("F1", "F2", "F3", "F4n", "F7", "F8")


def jobs(extent: Extent, controllers: Sequence[str] = CONTROLLERS) -> list[Job]:
    """Every flight and search, the longest first.

    Args:
        extent: how much. controllers: shipped names or paths.
    """
    found = []
    for experiment in _LONGEST_FIRST:
        flown = [name for name in controllers if experiment != "F5" or name in extent.identified]
        for seed in range(1, extent.seeds[experiment] + 1):
            drawn = seed == 1 and experiment in _DRAWN
            found += [Job(experiment, name, seed, drawn, radians(extent.resolution_deg)) for name in flown]
    return found


def job_mapping(job: Job) -> dict[str, Any]:
    """A job in plain values."""
    return dataclasses.asdict(job)
