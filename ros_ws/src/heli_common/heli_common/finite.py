"""A number that is not finite never gets past the message it came in."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

from heli_common.topics import TOPICS


def require_finite(topic: str, values: Sequence[float]) -> None:
    """Refuse a message that holds a number that is not finite.

    Args:
        topic: it came on.
        values: its numbers, in the order of the topic's layout.

    Raises:
        ValueError: names topic, field and value.
    """
    if isfinite(sum(values)):
        return
    fields = TOPICS[topic].layout.fields if topic in TOPICS else ()
    for field, value in zip(fields, values, strict=False):
        if not isfinite(value):
            raise ValueError(f"{topic}: {field} is {value}")
