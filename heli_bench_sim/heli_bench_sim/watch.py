"""How long the bench on the graph waits for others, in wall time."""

from __future__ import annotations

from dataclasses import dataclass

from heli_common.quantities import quantity


@dataclass(frozen=True)
class WatchParameters:
    """Patience of the bench; whoever exceeds it is named."""

    silence: float = quantity(
        0.5, "s", "D", "real time: a command stream silent for so long stops the motor", 0.05, 10.0
    )
    stall: float = quantity(10.0, "s", "D", "lockstep: a flight without progress is given up", 1.0, 600.0)
