"""The serial link of servo commands: a cable without delay, or the wireless module (spec 2.5).

A command sent with stamp t_k can be taken once its stamp plus the dead time has come. The dead time is that
of the instant of taking, so what is taken depends on stamps alone, never on when a message happened to come.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Sequence
from dataclasses import dataclass

from heli_common.quantities import quantity


@dataclass(frozen=True)
class LinkParameters:
    """The serial link: 0 s through the cable, 0.1 s through the wireless module."""

    dead_time: float = quantity(
        0.0, "s", "T", "dead time of servo commands: cable 0, wireless module 0.1", 0.0, 1.0
    )

    @property
    def dead_time_ns(self) -> int:
        """The dead time in whole nanoseconds."""
        return round(self.dead_time * 1e9)


CABLE = LinkParameters()
WIRELESS = LinkParameters(dead_time=0.1)


class DelayLine:
    """Stamped commands on their way.

    Args:
        dead_time_ns: from a command's stamp until it can be taken [ns].
    """

    def __init__(self, dead_time_ns: int = 0) -> None:
        self._under_way: list[tuple[int, Sequence[float]]] = []
        self._taken_ns = -1
        self.set_dead_time(dead_time_ns)

    def __len__(self) -> int:
        return len(self._under_way)

    @property
    def dead_time_ns(self) -> int:
        """From a command's stamp until it can be taken [ns]."""
        return self._dead_time_ns

    @property
    def taken_ns(self) -> int:
        """Stamp of the newest command taken [ns], -1 before the first."""
        return self._taken_ns

    def set_dead_time(self, dead_time_ns: int) -> None:
        """Change the dead time [ns], also of what is already on its way.

        Raises:
            ValueError: it is negative.
        """
        if dead_time_ns < 0:
            raise ValueError(f"dead time of {dead_time_ns} ns (allowed: 0 or more)")
        self._dead_time_ns = dead_time_ns

    def send(self, stamp_ns: int, values: Sequence[float]) -> None:
        """Put a command on its way; one older than what has already been taken is superseded and dropped.

        Args:
            stamp_ns: of the command [ns]; of two with the same stamp the later sent counts.
            values: of the command.
        """
        if stamp_ns > self._taken_ns:
            insort(self._under_way, (stamp_ns, values), key=_stamp)

    def take(self, due_ns: int) -> Sequence[float] | None:
        """The newest command that has arrived and was not yet taken; older ones are superseded.

        Args:
            due_ns: stamp that a command through a link without dead time has at most [ns].

        Returns:
            Its values, or None if nothing new has arrived.
        """
        arrived = 0
        for stamp_ns, _ in self._under_way:
            if stamp_ns + self._dead_time_ns > due_ns:
                break
            arrived += 1
        if not arrived:
            return None
        self._taken_ns, values = self._under_way[arrived - 1]
        del self._under_way[:arrived]
        return values

    def clear(self) -> None:
        """Forget what is on its way."""
        self._under_way.clear()


def _stamp(command: tuple[int, Sequence[float]]) -> int:
    return command[0]
