"""Is a flight the same whatever way it runs, however often, whatever else the machine does? (spec 6.2)"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from heli_common.errors import EXIT_BAD_INPUT, EXIT_FLOWN, EXIT_INTERRUPTED, EXIT_SAFETY_STOP, InputError
from heli_flight.bag_reader import read_bag
from heli_flight.flight_hash import Difference, bag_hash, first_difference
from heli_flight.flying import fly
from heli_flight.machine_load import every_core_busy
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.progress import Progress

REPRODUCIBLE = tuple(mode for mode in Mode if not mode.paced)
"""Ways of running in which a plan and a seed give the same bytes."""


@dataclass(frozen=True)
class Run:
    """One of the flights that are compared.

    Attributes:
        mode: way of running.
        number: from 1, per way.
        loaded: whether every core had something else to do.
    """

    mode: Mode
    number: int
    loaded: bool

    def __str__(self) -> str:
        return f"{self.mode.value} {self.number}{' under load' if self.loaded else ''}"


@dataclass(frozen=True)
class Flown:
    """A flight that was flown for comparison.

    Attributes:
        run: which one.
        simulated_seconds: its length.
        wall_seconds: how long it took, start of the processes included.
        sha256: of its messages.
        reason: why it was stopped, empty if it was flown to its end.
        bag: folder.
    """

    run: Run
    simulated_seconds: float
    wall_seconds: float
    sha256: str
    reason: str
    bag: Path


def runs(modes: Sequence[Mode], times: int, load: bool) -> list[Run]:
    """The flights to compare: each way so many times, and once more under load.

    Args:
        modes: ways of running.
        times: undisturbed flights of each.
        load: whether each is flown once more with every core busy.
    """
    numbers = range(1, times + 1 + load)
    return [Run(mode, number, number > times) for number in numbers for mode in modes]


def fly_run(
    order: FlightOrder, run: Run, folder: Path, tell: Callable[[Progress], None], warn: Callable[[str], None]
) -> Flown:
    """Fly one of the flights.

    Args:
        order: what all of them fly.
        run: which one.
        folder: for its bag.
        tell: called with every line of progress.
        warn: called with what a person should know.

    Raises:
        KeyboardInterrupt: while flying.
        InputError: a node refused what it was given.
        RuntimeError: it ended otherwise than flown or stopped.
    """
    bag = folder / str(run).replace(" ", "_")
    # under real-time scheduling the load would hardly be felt
    order = replace(order, mode=run.mode, bag=bag, real_time_scheduling=not run.loaded)
    with every_core_busy(run.loaded):
        end = fly(order, tell, warn)
    if end.exit_code == EXIT_INTERRUPTED:
        raise KeyboardInterrupt
    if end.exit_code == EXIT_BAD_INPUT:
        raise InputError(end.reason)
    if end.exit_code not in (EXIT_FLOWN, EXIT_SAFETY_STOP) or not (bag / "metadata.yaml").is_file():
        raise RuntimeError(f"{run}: {end.reason or 'left no bag'}")
    return Flown(run, end.simulated_seconds, end.wall_seconds, bag_hash(read_bag(bag)), end.reason, bag)


def differences(flown: Sequence[Flown]) -> list[tuple[Flown, Difference | None]]:
    """Flights that are not the first one, and the first message in which each differs."""
    first = flown[0]
    others = [each for each in flown[1:] if each.sha256 != first.sha256]
    return [(each, first_difference(read_bag(first.bag), read_bag(each.bag))) for each in others]
