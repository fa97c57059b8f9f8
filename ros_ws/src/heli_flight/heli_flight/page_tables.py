"""Tables as they stand on a page (macro `data` of `tables.html`): cells with marks, and numbers as words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

NOTHING = "–"
UNLIMITED = "∞"
GOOD, BAD, SOFT, TEXT = "good", "bad", "soft", "text"


class Cell(NamedTuple):
    """What stands in a table, and how it is marked: `good`, `bad`, `soft`, `text` or not at all."""

    text: str
    mark: str = ""


@dataclass(frozen=True)
class Table:
    """A table as it stands on the page.

    Attributes:
        title: above it. note: below the title.
        header: names of the columns.
        rows: cells in their order.
    """

    title: str
    note: str
    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


def number(value: float | None, digits: int = 2, missing: str = NOTHING) -> str:
    """A number with a fixed number of digits behind the point."""
    return missing if value is None else f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def significant(value: float | None, digits: int = 3) -> str:
    """A number with a few significant digits; powers of ten only where they are needed."""
    if value is None:
        return NOTHING
    mantissa, mark, power = f"{value:.{digits}g}".partition("e")
    return (f"{mantissa}e{int(power)}" if mark else mantissa).replace("-", "−")
