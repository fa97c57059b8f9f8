"""The rotor's own air, coming back from floor and ceiling, moves the helicopter around (spec 2.7).

Four independent Gauss-Markov gusts of one correlation time: air velocity north, east and down, and a yaw
moment. Their strengths are standard deviations in hover. They grow with the induced velocity of the main
rotor: no flow through the rotor, no recirculation. They start from zero, so that a flight begins in still
air; the variance comes up as 1 - exp(-2 t / correlation time).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_common.quantities import quantity

Array = NDArray[np.float64]


class RoomState(IntEnum):
    """The gusts, each over its own strength."""

    north = 0
    east = 1
    down = 2
    yaw = 3


ROOM_STATE_SIZE = len(RoomState)

ROOM_NORMALS = ROOM_STATE_SIZE
"""Standard normal numbers per step, one for each gust."""


@dataclass(frozen=True)
class RoomAirParameters:
    """Strength and pace of the recirculation.

    The strengths were found by `heli calibrate gusts`: with them LQ hovers as in the LQ row of the source's
    Table 5.2, the only row that was used (docs/reproduction.md).
    """

    active: float = quantity(0.0, "-", "D", "switch: 0 still room, 1 the rotor's air comes back", 0.0, 1.0)
    correlation_time: float = quantity(1.5, "s", "D", "correlation time of every gust", 0.01, 60.0)
    strength_x: float = quantity(
        2.0, "m/s", "D", "standard deviation in hover, north, by heli calibrate gusts", 0.0, 10.0
    )
    strength_y: float = quantity(
        1.8, "m/s", "D", "standard deviation in hover, east, by heli calibrate gusts", 0.0, 10.0
    )
    strength_z: float = quantity(
        0.41, "m/s", "D", "standard deviation in hover, down, by heli calibrate gusts", 0.0, 10.0
    )
    strength_yaw: float = quantity(
        1.1, "N m", "D", "standard deviation in hover, yaw moment, by heli calibrate gusts", 0.0, 10.0
    )


GUSTY_ROOM = RoomAirParameters(active=1.0)


class RoomConstants(NamedTuple):
    """What the compiled room needs; strengths per induced velocity, every field a float, SI."""

    correlation_time: float
    north: float
    """standard deviation per induced velocity [-]"""
    east: float
    down: float
    yaw: float
    """standard deviation per induced velocity [N s]"""


def room_constants(parameters: RoomAirParameters, hover_inflow: float) -> RoomConstants:
    """Constants of the compiled room.

    Args:
        parameters: of the room's air.
        hover_inflow: induced velocity of the main rotor in hover [m/s].

    Raises:
        ValueError: the induced velocity in hover is not positive, or the switch is neither 0 nor 1.
    """
    if parameters.active not in (0.0, 1.0):
        raise ValueError(f"room switch active is {parameters.active!r} (allowed: 0 or 1)")
    if not 0.0 < hover_inflow < math.inf:
        raise ValueError(f"hover_inflow {hover_inflow!r} m/s must be positive and finite")
    return RoomConstants(
        correlation_time=parameters.correlation_time,
        north=parameters.active * parameters.strength_x / hover_inflow,
        east=parameters.active * parameters.strength_y / hover_inflow,
        down=parameters.active * parameters.strength_z / hover_inflow,
        yaw=parameters.active * parameters.strength_yaw / hover_inflow,
    )


@compiled
def room_advance(state: Array, normals: Array, period: float, c: RoomConstants) -> None:
    """Advance the gusts by one step, in place; exact for any length of it.

    Args:
        state: (4,) in the order of `RoomState`, overwritten.
        normals: (4,) standard normal numbers, independent from step to step.
        period: length of the step [s].
        c: constants of the room.
    """
    steps = period / c.correlation_time
    kept, noise = math.exp(-steps), math.sqrt(-math.expm1(-2.0 * steps))
    for gust in range(ROOM_STATE_SIZE):
        state[gust] = kept * state[gust] + noise * normals[gust]


@compiled
def room_gust(state: Array, v_i: float, c: RoomConstants, out: Array) -> None:
    """Write what the room's air does to the helicopter into `out`.

    Args:
        state: (4,) of the room.
        v_i: induced velocity of the main rotor [m/s]; upward flow counts as none.
        c: constants of the room.
        out: (4,) receives the air's velocity north, east, down [m/s] and the yaw moment on the helicopter
            about the vertical, positive nose right [N m].
    """
    flow = max(v_i, 0.0)
    out[RoomState.north] = c.north * flow * state[RoomState.north]
    out[RoomState.east] = c.east * flow * state[RoomState.east]
    out[RoomState.down] = c.down * flow * state[RoomState.down]
    out[RoomState.yaw] = c.yaw * flow * state[RoomState.yaw]
