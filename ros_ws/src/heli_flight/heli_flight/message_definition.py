"""What a bag must say of a message type, so that others can read it without having it."""

from __future__ import annotations

import functools
from typing import Any

from rosbags.typesys import Stores, get_typestore


@functools.cache
def message_definition(ros_type: str) -> tuple[str, str]:
    """Text of a message definition with all it contains, and its RIHS01 hash.

    Raises:
        ValueError: no such type in a plain Jazzy installation.
    """
    store = _typestore()
    if ros_type not in store.types:
        raise ValueError(f"type {ros_type!r} is not known in ROS 2 Jazzy")
    return str(store.generate_msgdef(ros_type, ros_version=2)[0]), str(store.hash_rihs01(ros_type))


@functools.cache
def _typestore() -> Any:
    return get_typestore(Stores.ROS2_JAZZY)
