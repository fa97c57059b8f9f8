"""Numbers of the command line and what is allowed."""

from __future__ import annotations

from heli_common.errors import InputError

MOST_WORKERS = 64
"""Processes of this machine that a command may ask for."""


def require_between(value: float, least: float, most: float, key: str) -> None:
    """Refuse a number outside its range.

    Args:
        value: as given. least: allowed. most: allowed.
        key: the option.

    Raises:
        InputError: names option, value and range.
    """
    if not least <= value <= most:
        raise InputError(f"{value}", allowed=f"{least} .. {most}", key=key)
