"""Distributions of a vary file, in words: `{uniform: [a, b]}`, `{normal: [mean, deviation]}` and so on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from heli_common.errors import InputError
from heli_common.quantities import Quantity, check_number
from heli_flight.plan_file import refuse_unknown

UNIFORM, LOG_UNIFORM, NORMAL, CHOICE = "uniform", "log_uniform", "normal", "choice"
KINDS = (UNIFORM, LOG_UNIFORM, NORMAL, CHOICE)
_TIMES = "times_default"
_ALLOWED = "{uniform: [a, b]}, {log_uniform: [a, b]}, {normal: [mean, deviation]} or {choice: [...]}"
_ANY = Quantity("", "D", "number of a distribution", -1e12, 1e12)


@dataclass(frozen=True)
class Choice:
    """One of some values, all alike probable."""

    values: tuple[Any, ...]

    def draw(self, generator: np.random.Generator) -> Any:
        """One of them."""
        return self.values[int(generator.integers(len(self.values)))]


@dataclass(frozen=True)
class Distribution:
    """A random number within a range.

    Attributes:
        kind: one of `KINDS`.
        numbers: of the distribution, in its own order.
        factor: on what is drawn: 1, or the parameter's default.
        lowest: what is allowed.
        highest: the same.
    """

    kind: str
    numbers: tuple[float, ...]
    factor: float = 1.0
    lowest: float = -math.inf
    highest: float = math.inf

    def draw(self, generator: np.random.Generator) -> float:
        """A number, set to the end of the range beyond it."""
        first, *rest = self.numbers
        if self.kind == CHOICE:
            value = self.numbers[int(generator.integers(len(self.numbers)))]
        elif self.kind == UNIFORM:
            value = first + (rest[0] - first) * float(generator.random())
        elif self.kind == LOG_UNIFORM:
            value = first * math.exp(math.log(rest[0] / first) * float(generator.random()))
        else:
            value = first + rest[0] * float(generator.standard_normal())
        return min(max(self.factor * value, self.lowest), self.highest)


def read_choice(entry: object, file: str | None, key: str) -> Choice:
    """`{choice: [...]}`.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    allowed = "{choice: [one, another]}"
    if not isinstance(entry, Mapping) or set(entry) != {CHOICE}:
        raise InputError(f"{entry!r} is no choice", allowed=allowed, file=file, key=key)
    values = entry[CHOICE]
    if not isinstance(values, list) or not values:
        raise InputError(f"{values!r} is no list", allowed=allowed, file=file, key=f"{key}.{CHOICE}")
    return Choice(tuple(values))


def read_distribution(
    entry: object, about: Quantity, default: float, file: str | None, key: str
) -> Distribution:
    """The distribution that a mapping describes.

    Args:
        entry: as YAML gives it.
        about: unit and range of the number.
        default: that `times_default` multiplies.
        file: it stands in, for errors.
        key: it stands under, for errors.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    if not isinstance(entry, Mapping):
        raise InputError(f"{entry!r} is no distribution", allowed=_ALLOWED, file=file, key=key)
    refuse_unknown(entry, (*KINDS, _TIMES), file, key)
    kinds = [name for name in entry if name in KINDS]
    if len(kinds) != 1:
        raise InputError(f"{dict(entry)!r} is no distribution", allowed=_ALLOWED, file=file, key=key)
    kind, times = kinds[0], entry.get(_TIMES, False)
    if not isinstance(times, bool):
        raise InputError(f"{times!r}", allowed="true, false", file=file, key=f"{key}.{_TIMES}")
    place, values = f"{key}.{kind}", entry[kind]
    if not isinstance(values, list) or not values or (kind != CHOICE and len(values) != 2):
        wanted = "a list of numbers" if kind == CHOICE else "two numbers"
        raise InputError(f"{values!r}", allowed=wanted, file=file, key=place)
    numbers = tuple(
        check_number(value, _ANY, file=file, key=f"{place}[{index}]") for index, value in enumerate(values)
    )
    factor = default if times else 1.0
    if kind == NORMAL:
        if numbers[1] < 0.0:
            raise InputError(f"{numbers[1]!r}", allowed="0 or more", file=file, key=f"{place}[1]")
        check_number(factor * numbers[0], about, file=file, key=f"{place}[0]")
    else:
        for index, number in enumerate(numbers):
            check_number(factor * number, about, file=file, key=f"{place}[{index}]")
    if kind in (UNIFORM, LOG_UNIFORM) and numbers[1] < numbers[0]:
        raise InputError(f"{list(numbers)}", allowed="the lower number first", file=file, key=place)
    if kind == LOG_UNIFORM and numbers[0] <= 0.0:
        raise InputError(f"{numbers[0]!r}", allowed="above 0", file=file, key=f"{place}[0]")
    return Distribution(kind, numbers, factor, about.minimum, about.maximum)
