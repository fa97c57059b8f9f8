"""Where the model leaves the hover regime it was built for: flagged with quantity and bound.

Beyond these bounds the equations go on and stay finite (see `inflow`, `rotor`, `standstill`), but their
numbers are no longer the thesis's helicopter.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import helicopter, inflow
from heli_bench_sim.parameters import Constants
from heli_bench_sim.states import State

Array = NDArray[np.float64]


class Violation(NamedTuple):
    """One bound that is passed."""

    name: str
    """stall, vortex_ring, windmill or underspeed"""
    quantity: str
    """what is out of bounds, with its unit"""
    value: float
    bound: float

    def __str__(self) -> str:
        side = "below" if self.value < self.bound else "above"
        return f"{self.name.replace('_', ' ')}: {self.quantity} {self.value:.3g} is {side} {self.bound:.3g}"


NAMES = ("stall", "vortex_ring", "windmill", "underspeed")
"""Everything that `violations` can tell."""


def violations(state: Array, inputs: Array, wind_earth: Array, c: Constants) -> tuple[Violation, ...]:
    """The bounds that a state has passed; empty where the model holds.

    Args:
        state: (18 or more,) in the order of `State`.
        inputs: (5,) in the order of `Input`.
        wind_earth: (3 or more,) velocity of the air, NED [m/s].
        c: constants of the helicopter.
    """
    found = []
    omega = float(state[State.Omega])
    underspeed = omega < c.fade_speed
    if underspeed:
        found.append(Violation("underspeed", "rotor speed [rad/s]", omega, float(c.fade_speed)))
    load = helicopter.loads(state, inputs, wind_earth, c)
    ratio, angle = float(load.descent_ratio), math.degrees(load.section_angle)
    stall = math.degrees(c.stall_angle)
    if not underspeed and abs(angle) > stall:
        found.append(Violation("stall", "size of the blade's section angle [deg]", abs(angle), stall))
    descent = "descent over induced velocity [-]"
    if ratio >= inflow.WINDMILL:
        found.append(Violation("windmill", descent, ratio, inflow.WINDMILL))
    elif ratio > inflow.VORTEX_RING_START:
        found.append(Violation("vortex_ring", descent, ratio, inflow.VORTEX_RING_START))
    return tuple(found)
