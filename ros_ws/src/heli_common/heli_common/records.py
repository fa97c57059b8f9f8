"""Constants of compiled code as one numpy record: same names, one pointer instead of a hundred arguments.

A call from Python into compiled code unpacks every field of a named tuple; of a record it takes the address,
and quickest of all if the record comes in an array of one. Attribute access is the same for tuples and
records, in Python and in compiled code, nested records included.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

Constants = TypeVar("Constants", bound=NamedTuple)

_LAYOUTS: dict[tuple[object, ...], np.dtype[Any]] = {}


def packed(constants: Constants) -> Constants:
    """A record with the fields of a named tuple of floats and of such named tuples.

    Args:
        constants: the named tuple.

    Returns:
        a `numpy.record` that stands in for it wherever fields are read by name.
    """
    record = np.array([_values(constants)], dtype=_layout(constants))[0]
    return cast(Constants, record)


def boxed(constants: Constants) -> Sequence[Constants]:
    """Packed constants in an array of one, for compiled code that is called very often.

    Args:
        constants: from `packed`.
    """
    return cast(Sequence[Constants], np.array([constants], dtype=_layout(constants)))


def as_dict(constants: Constants) -> dict[str, Any]:
    """The fields of constants, packed or not, by name."""
    names = constants.dtype.names if isinstance(constants, np.record) else constants._fields
    return {name: getattr(constants, name) for name in names or ()}


def _layout(constants: Any) -> np.dtype[Any]:
    """One dtype object per kind of constants: compiled code recognises it by its identity."""
    if isinstance(constants, np.record):
        return constants.dtype
    fields = [
        (name, _layout(value) if isinstance(value, (tuple, np.record)) else np.dtype(np.float64))
        for name, value in zip(constants._fields, constants, strict=True)
    ]
    key = (type(constants), *(id(layout) for _, layout in fields))
    if key not in _LAYOUTS:
        _LAYOUTS[key] = np.dtype((np.record, fields))
    return _LAYOUTS[key]


def _values(constants: Any) -> tuple[Any, ...]:
    return tuple(
        _values(value)
        if isinstance(value, tuple)
        else value.item()
        if isinstance(value, np.record)
        else value
        for value in constants
    )
