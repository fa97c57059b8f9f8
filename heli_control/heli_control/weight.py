"""Weights of H-infinity design in words: a number, or the coefficients of a proper stable transfer function.

In a file a weight is `3.0` or `{numerator: [1, 40, 400], denominator: [0.01, 2, 100]}`, highest power of s
first. Weights are not seen by the controller's measurements, so each must be stable by itself (A1).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from heli_common.errors import InputError
from heli_common.linear_model import short
from heli_control.realisation import Complex, Realisation, diagonal, rational

_ALLOWED = "a number, or {numerator: [...], denominator: [...]} with the highest power of s first"


@dataclass(frozen=True)
class Weight:
    """A transfer function from one signal to its weighted self.

    Attributes:
        numerator, denominator: coefficients, highest power of s first.
    """

    numerator: tuple[float, ...]
    denominator: tuple[float, ...] = (1.0,)

    @property
    def system(self) -> Realisation:
        """As state space with one input and one output."""
        return rational(self.numerator, self.denominator)

    def mapping(self) -> float | dict[str, list[float]]:
        """As it stands in a file."""
        if len(self.denominator) == 1:
            return self.numerator[-1] / self.denominator[0]
        return {"numerator": list(self.numerator), "denominator": list(self.denominator)}

    def at(self, s: Complex) -> Complex:
        """Its value at complex frequencies [rad/s]."""
        return np.asarray(
            np.polyval(self.numerator, s) / np.polyval(self.denominator, s), dtype=np.complex128
        )


def read_weight(value: object, file: str | None, key: str) -> Weight:
    """The weight that an entry of a file describes.

    Raises:
        InputError: no number and no transfer function, not proper, not stable.
    """
    if isinstance(value, Mapping):
        for name in value:
            if name not in ("numerator", "denominator"):
                allowed = "numerator, denominator"
                raise InputError("unknown key", allowed=allowed, file=file, key=f"{key}.{name}")
        weight = Weight(
            _coefficients(value.get("numerator"), file, f"{key}.numerator"),
            _coefficients(value.get("denominator"), file, f"{key}.denominator"),
        )
        _check(weight, file, key)
        return weight
    return Weight((_number(value, file, key, _ALLOWED),))


def stacked(weights: Sequence[Weight]) -> Realisation:
    """One weight for each of several signals, side by side."""
    return diagonal(*(weight.system for weight in weights))


def _check(weight: Weight, file: str | None, key: str) -> None:
    if weight.denominator[0] == 0.0:
        raise InputError("begins with 0", allowed="not zero", file=file, key=f"{key}.denominator[0]")
    if len(np.trim_zeros(weight.numerator, "f")) > len(weight.denominator):
        problem = f"of order {len(weight.numerator) - 1} over {len(weight.denominator) - 1} is not proper"
        raise InputError(problem, allowed="a numerator of no higher order", file=file, key=key)
    for pole in np.roots(weight.denominator):
        if not pole.real < 0.0:
            allowed = "poles with a negative real part"
            raise InputError(f"has a pole at {pole:.4g}", allowed=allowed, file=file, key=key)


def _coefficients(value: object, file: str | None, key: str) -> tuple[float, ...]:
    allowed = "a list of 1 to 9 numbers"
    if not isinstance(value, list) or not 1 <= len(value) <= 9:
        raise InputError(f"{short(value)} is no list", allowed=allowed, file=file, key=key)
    return tuple(_number(entry, file, f"{key}[{index}]", "a number") for index, entry in enumerate(value))


def _number(value: Any, file: str | None, key: str, allowed: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"{short(value)} is no weight", allowed=allowed, file=file, key=key)
    return float(value)
