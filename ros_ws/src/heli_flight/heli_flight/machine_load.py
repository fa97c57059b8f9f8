"""Something else to do for every core of the machine, as long as one wants to see who suffers from it."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from heli_flight.process_group import ProcessGroup
from heli_flight.process_table import environment


@contextmanager
def every_core_busy(wanted: bool = True) -> Iterator[None]:
    """Keep every core busy with a process of ordinary priority; they go with this one, however it ends.

    Args:
        wanted: False leaves the machine alone.
    """
    if not wanted:
        yield
        return
    busy = [sys.executable, "-c", "while True: pass"]
    with ProcessGroup({f"load_{core}": busy for core in range(os.cpu_count() or 1)}, environment()):
        yield
