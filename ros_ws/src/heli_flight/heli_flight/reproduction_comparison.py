"""One printed figure or claim beside ours, and when it counts as reproduced (spec 5)."""

from __future__ import annotations

from dataclasses import dataclass

from heli_flight.reproduction_reasons import REASONS

TOLERANCE = 0.30
"""Relative difference to print that counts as reproduced (spec 5)."""


@dataclass(frozen=True)
class Compared:
    """One printed figure or claim.

    Attributes:
        experiment: F1 .. F8. what: in words.
        published: as printed.
        ours: as flown, mean and interval.
        ratio: ours over published; None where that says nothing.
        holds: whether it is reproduced; None if nothing was flown that decides it.
        why: why not, empty if it is.
    """

    experiment: str
    what: str
    published: str
    ours: str
    ratio: float | None
    holds: bool | None
    why: str = ""


def judged(
    experiment: str,
    key: str,
    what: str,
    published: str,
    ours: str,
    holds: bool | None,
    ratio: float | None = None,
) -> Compared:
    """The comparison with the reason why it is not reproduced, if it is not.

    Args:
        experiment: F1 .. F8. key: of the reason. what, published, ours, holds, ratio: see `Compared`.
    """
    why = "" if holds else REASONS.get(f"{experiment} {key}", "")
    return Compared(experiment, what, published, ours, ratio, holds, why)


def close(ratio: float) -> bool:
    """Whether ours over published counts as reproduced."""
    return abs(ratio - 1.0) <= TOLERANCE
