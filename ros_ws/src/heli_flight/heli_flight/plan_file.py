"""Strict reading of a YAML file a person has written: duplicate and unknown keys are errors."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from heli_common.errors import InputError


class _DuplicateKeyError(yaml.YAMLError):
    """A key stands twice in one mapping."""


class _StrictLoader(yaml.SafeLoader):
    """A SafeLoader that does not let the second of two equal keys win silently."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[object] = set()
        for key_node, _ in node.value:
            key = key_node.value if isinstance(key_node, yaml.ScalarNode) else id(key_node)
            if key in seen:
                raise _DuplicateKeyError(f"line {key_node.start_mark.line + 1}: key {key!r} stands twice")
            seen.add(key)
        return super().construct_mapping(node, deep)


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        InputError: it cannot be read, or is no text.
    """
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from None
    except UnicodeDecodeError:
        raise InputError("is no text", allowed="UTF-8", file=path) from None


def read_mapping(text: str, file: str | None = None) -> dict[str, Any]:
    """A YAML document whose top level is a mapping.

    Raises:
        InputError: no YAML, an empty document, a key that stands twice, or no mapping.
    """
    try:
        document = yaml.load(text, _StrictLoader)
    except _DuplicateKeyError as error:
        raise InputError(str(error), allowed="each key once", file=file) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f"line {mark.line + 1}: " if mark else ""
        problem = " ".join(str(getattr(error, "problem", error)).split())
        raise InputError(f"{line}is not valid YAML: {problem}", file=file) from None
    if document is None:
        raise InputError("is empty", file=file)
    if not isinstance(document, dict):
        raise InputError(f"holds {type(document).__name__}, not a mapping", file=file)
    return document


def refuse_unknown(
    document: Mapping[str, object], known: Iterable[str], file: str | None, place: str
) -> None:
    """Refuse a mapping with keys that mean nothing.

    Raises:
        InputError: names the first such key.
    """
    names = list(known)
    for key in document:
        if key not in names:
            where = f"{place}.{key}" if place else str(key)
            raise InputError("unknown key", allowed=", ".join(names), file=file, key=where)


def text_at(document: Mapping[str, object], key: str, file: str | None, place: str = "") -> str:
    """The text that must stand under a key.

    Raises:
        InputError: it is missing, empty, or no text.
    """
    value = document.get(key)
    if not isinstance(value, str) or not value.strip():
        allowed = "a text that is not empty"
        raise InputError(f"{value!r} is no text", allowed=allowed, file=file, key=f"{place}{key}")
    return value


def controller_at(document: Mapping[str, object], file: str | None, place: str = "") -> str:
    """The controller that must stand under `controller`; a comma would part two of them for their node.

    Raises:
        InputError: it is missing, empty, no text, or holds a comma.
    """
    name = text_at(document, "controller", file, place)
    if "," in name:
        raise InputError(
            f"{name!r} holds a comma", allowed="one controller", file=file, key=f"{place}controller"
        )
    return name


def integer_at(document: Mapping[str, object], key: str, minimum: int, maximum: int, file: str | None) -> int:
    """The integer that must stand under a key.

    Raises:
        InputError: it is missing, no integer, or out of range.
    """
    value = document.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not minimum <= value <= maximum:
        allowed = f"an integer {minimum} .. {maximum}"
        raise InputError(f"{value!r} is not allowed", allowed=allowed, file=file, key=key)
    return value
