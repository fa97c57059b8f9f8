"""The ways of running a flight."""

from __future__ import annotations

from enum import Enum

from heli_common.topics import RECORDER

COMPOSED_PROCESS = "composed"
"""Name of a process that holds several nodes."""


class Mode(str, Enum):
    """How a flight runs: paced by the clock or not, a process for each node or one for several."""

    LOCKSTEP = "lockstep"
    COMPOSED = "composed"
    REALTIME = "realtime"
    REALTIME_COMPOSED = "realtime_composed"
    INPROCESS = "inprocess"

    @property
    def paced(self) -> bool:
        """Whether the clock on the wall paces the bench, so that a command can be late."""
        return self in (Mode.REALTIME, Mode.REALTIME_COMPOSED)

    @property
    def composed(self) -> bool:
        """Whether nodes share a process."""
        return self in (Mode.COMPOSED, Mode.REALTIME_COMPOSED)

    def process_of(self, node: str) -> str:
        """Name of the process that holds a node.

        A recorder that shares the thread would hold commands up while it writes, which no clock forgives.
        """
        alone = not self.composed or (self.paced and node == RECORDER)
        return node if alone else COMPOSED_PROCESS
