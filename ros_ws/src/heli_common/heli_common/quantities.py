"""Parameters with unit, source and range: one frozen dataclass serves maths, files and ROS parameters."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import Field, dataclass, fields
from typing import Any, TypeVar

from heli_common.errors import InputError

PROVENANCE = {
    "T": "printed in the thesis",
    "R": "rebuilt so that the thesis's own tables come out",
    "D": "design choice where the thesis is silent or lost",
}

Parameters = TypeVar("Parameters")


@dataclass(frozen=True)
class Quantity:
    """What is known of one parameter beside its value."""

    unit: str
    provenance: str
    text: str
    minimum: float = -math.inf
    maximum: float = math.inf

    def __post_init__(self) -> None:
        if self.provenance not in PROVENANCE:
            raise ValueError(f"provenance {self.provenance!r} is none of {sorted(PROVENANCE)}")


def quantity(
    default: float,
    unit: str,
    provenance: str,
    text: str,
    minimum: float = -math.inf,
    maximum: float = math.inf,
) -> Any:
    """A dataclass field holding a number with its unit, provenance (T, R or D), meaning and range."""
    about = Quantity(unit, provenance, text, minimum, maximum)
    return dataclasses.field(default=default, metadata={"quantity": about})


def about(field: Field[Any]) -> Quantity:
    """The unit, provenance, meaning and range of a field made by `quantity`."""
    known: Quantity = field.metadata["quantity"]
    return known


def groups_of(cls: type[Any]) -> list[tuple[Field[Any], Any]]:
    """The fields of a dataclass made of parameter dataclasses, each with its default group."""
    default = cls()
    return [(field, getattr(default, field.name)) for field in fields(cls)]


def from_mapping(
    cls: type[Parameters], values: Mapping[str, object], *, file: str | None = None, prefix: str = ""
) -> Parameters:
    """Build a parameter dataclass from plain numbers; unknown keys and values out of range are refused.

    Raises:
        InputError: names the file, the key, the value and what is allowed.
    """
    known = {field.name: field for field in fields(cls)}  # type: ignore[arg-type]
    checked: dict[str, float] = {}
    for name, value in values.items():
        key = f"{prefix}{name}"
        if name not in known:
            raise InputError("unknown parameter", allowed=", ".join(known), file=file, key=key)
        checked[name] = check_number(value, about(known[name]), file=file, key=key)
    return cls(**checked)


def check_number(value: object, about: Quantity, *, file: str | None = None, key: str = "") -> float:
    """A finite number inside the range of its quantity, or an InputError that says what is wrong."""
    allowed = f"{about.minimum:g} .. {about.maximum:g} {about.unit}".strip()
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{value!r} is not a number", allowed=allowed, file=file, key=key)
    # the comparison first: it also holds for integers too large for a float
    if not about.minimum <= value <= about.maximum or not math.isfinite(value):
        raise InputError(f"{value!r} is out of range", allowed=allowed, file=file, key=key)
    return float(value)


def degrees_of(angle: float) -> float:
    """The degrees that were read as this angle [rad], to the last bit."""
    exact = math.degrees(angle)
    near = (round(exact, 9), exact, math.nextafter(exact, math.inf), math.nextafter(exact, -math.inf))
    return next((found for found in near if math.radians(found) == angle), exact)
