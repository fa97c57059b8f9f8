"""All chance of the bench from one seed: one independent stream per component.

A component's stream depends on the seed and on its name alone, so adding a component or drawing more in one
of them changes nothing in the others (spec 2.7).
"""

from __future__ import annotations

import hashlib

import numpy as np

_NAME_BYTES = 16
"""Bytes of a name's hash that go into the seed: four words of 32 bits."""


def generator(seed: int, component: str) -> np.random.Generator:
    """The random numbers of one component.

    Args:
        seed: of the whole bench, 0 or more.
        component: its name; another name or another seed gives an independent stream.

    Raises:
        ValueError: the seed is negative.
    """
    if seed < 0:
        raise ValueError(f"seed {seed!r} is negative (allowed: whole numbers from 0)")
    # not hash(): that differs from one process to the next
    name = hashlib.sha256(component.encode()).digest()[:_NAME_BYTES]
    words = tuple(int.from_bytes(name[k : k + 4], "little") for k in range(0, _NAME_BYTES, 4))
    # PCG64 by name: what numpy takes by default may change
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=words)))
