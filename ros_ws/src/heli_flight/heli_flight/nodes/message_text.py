"""Messages as YAML and from YAML, by their own description of their fields."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from typing import Any

import yaml

from heli_common.errors import InputError
from heli_common.nodes.messages import message_class

LONGEST = 128
"""Longer strings and arrays end in dots."""


def message_yaml(message: Any) -> str:
    """A message as a YAML document, fields in their order."""
    return yaml.dump(_plain(message), sort_keys=False, allow_unicode=True, width=sys.maxsize)


def field_text(message: Any, field: str) -> str:
    """One part of a message: YAML if it has fields of its own, else its value.

    Args:
        message: the message.
        field: dotted names, each perhaps with an index, e.g. `status[0].message`.

    Raises:
        InputError: the message has no such part.
    """
    part = message
    for word in field.split("."):
        found = re.fullmatch(r"(\w+)((?:\[\d+\])*)", word)
        name, indices = found.groups() if found else (word, "")
        names = _fields(part)
        if name not in names:
            raise InputError(
                f"no field {name!r} in {type(part).__name__}", allowed=", ".join(names), key=field
            )
        part = getattr(part, name)
        for index in re.findall(r"\d+", indices):
            try:
                part = part[int(index)]
            except (IndexError, TypeError):
                raise InputError(f"no element {index} in {name!r}", key=field) from None
    return message_yaml(part) if _fields(part) else f"{part}\n"


def fill(message: Any, values: object, place: str = "") -> None:
    """Set the given fields of a message; the others stay as they are.

    Args:
        message: to be changed.
        values: by field name, nested as the message is.
        place: dotted name of the message within the whole, for errors.

    Raises:
        InputError: no such field, or a value of another kind.
    """
    fields = _fields(message)
    if not isinstance(values, Mapping):
        raise InputError(f"{values!r}", allowed=f"a mapping of {', '.join(fields) or 'nothing'}", key=place)
    for name, value in values.items():
        key = f"{place}.{name}" if place else str(name)
        if name not in fields:
            raise InputError("no such field", allowed=", ".join(fields) or "none", key=key)
        kind = fields[name]
        if _fields(getattr(message, name)):
            fill(getattr(message, name), value, key)
            continue
        setattr(message, name, _value(kind, value, key))


def _value(kind: str, value: object, key: str) -> object:
    """A value as the field of this kind takes it: whole numbers for floats, elements that are messages."""
    element = re.fullmatch(r"(?:sequence<([\w/]+)(?:, (\d+))?>|([\w/]+)\[(\d+)\])", kind)
    if element:
        inner, most, exactly = element[1] or element[3], element[2], element[4]
        if not isinstance(value, list) or len(value) > int(most or len(value)):
            raise InputError(f"{value!r}", allowed=kind, key=key)
        if exactly and len(value) != int(exactly):
            raise InputError(f"{len(value)} elements", allowed=kind, key=key)
        return [_value(inner, each, f"{key}[{index}]") for index, each in enumerate(value)]
    if "/" in kind:
        package, name = kind.split("/")[0], kind.split("/")[-1]
        message = message_class(f"{package}/msg/{name}")()
        fill(message, value, key)
        return message
    return _plain_value(kind, value, key)


def _plain_value(kind: str, value: object, key: str) -> object:
    """The generated setters check nothing, and what they let pass ends the process when it is serialized."""
    integer = re.fullmatch(r"(u?)int(\d+)", kind)
    whole = isinstance(value, int) and not isinstance(value, bool)
    if kind in ("float", "double") and (whole or isinstance(value, float)):
        return float(value)  # type: ignore[arg-type]
    if integer and whole:
        bits = int(integer[2])
        low, high = (0, 2**bits) if integer[1] else (-(2 ** (bits - 1)), 2 ** (bits - 1))
        if low <= value < high:  # type: ignore[operator]
            return value
    if kind == "octet" and whole and 0 <= value < 256:  # type: ignore[operator]
        return bytes([value])  # type: ignore[list-item]
    if (kind == "boolean" and isinstance(value, bool)) or ("string" in kind and isinstance(value, str)):
        return value
    raise InputError(f"{value!r}", allowed=kind, key=key)


def _fields(value: Any) -> Mapping[str, str]:
    """Names and kinds of a message's fields; empty for anything else."""
    describe = getattr(value, "get_fields_and_field_types", None)
    return describe() if describe else {}


def _plain(value: Any) -> object:
    fields = _fields(value)
    if fields:
        return {name: _plain(getattr(value, name)) for name in fields}
    if isinstance(value, bytes):
        value = value.decode("latin-1")
    if isinstance(value, str):
        return value if len(value) <= LONGEST else f"{value[:LONGEST]}..."
    if isinstance(value, bool | int | float):
        return value
    if hasattr(value, "get_fields_and_field_types"):
        return {}
    if hasattr(value, "tolist"):
        value = value.tolist()
    shown = [_plain(each) for each in value[:LONGEST]]
    return shown if len(value) <= LONGEST else [*shown, "..."]
