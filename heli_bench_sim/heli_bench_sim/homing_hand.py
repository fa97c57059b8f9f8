"""The scripted hand that homes the bench: it moves every encoder over its index pulse (spec 2.2).

With the rotor off it takes hold of the helicopter where it stands, carries it to the axis of the rig and up
until every arm has turned by more than 8 deg, swings yaw, pitch and roll by +-8 deg one after the other, sets
it down in the middle of the stop, heading north, and lets go. A spring and a damper pull towards the path, so
nothing is forced; the weight is carried by a steady lift.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from heli_common.compiled import compiled
from heli_common.quantities import quantity


@dataclass(frozen=True)
class HandParameters:
    """Path and firmness of the hand."""

    height: float = quantity(0.36, "m", "D", "lift above the rest position", 0.05, 0.8)
    swing: float = quantity(math.radians(8.5), "rad", "D", "swing of each gimbal axis", 0.05, 0.4)
    grip_time: float = quantity(0.3, "s", "D", "taking hold and letting go", 0.05, 5.0)
    lift_time: float = quantity(1.6, "s", "D", "going up and coming down, each", 0.2, 20.0)
    swing_time: float = quantity(1.1, "s", "D", "one axis, there and back", 0.2, 20.0)
    stiffness: float = quantity(2000.0, "N/m", "D", "pull towards the path", 10.0, 1e5)
    damping: float = quantity(240.0, "N s/m", "D", "damping along the path", 0.0, 1e4)
    turn_stiffness: float = quantity(80.0, "N m/rad", "D", "pull towards the angle", 1.0, 1e4)
    turn_damping: float = quantity(10.0, "N m s/rad", "D", "damping about each axis", 0.0, 1e3)


class HandConstants(NamedTuple):
    """What the compiled hand needs; every field a float, SI."""

    top: float
    bottom: float
    swing: float
    grip_time: float
    lift_time: float
    swing_time: float
    stiffness: float
    damping: float
    turn_stiffness: float
    turn_damping: float
    weight: float


def hand_constants(parameters: HandParameters, rest_depth: float, weight: float) -> HandConstants:
    """Constants of a hand over a stop at the given NED z [m], carrying the given weight [N].

    Args:
        parameters: of the hand.
        rest_depth: NED z at rest [m].
        weight: of what it carries [N].
    """
    return HandConstants(
        top=rest_depth - parameters.height,
        bottom=rest_depth,
        swing=parameters.swing,
        grip_time=parameters.grip_time,
        lift_time=parameters.lift_time,
        swing_time=parameters.swing_time,
        stiffness=parameters.stiffness,
        damping=parameters.damping,
        turn_stiffness=parameters.turn_stiffness,
        turn_damping=parameters.turn_damping,
        weight=weight,
    )


@compiled
def duration(h: HandConstants) -> float:
    """Length of the whole script [s]."""
    return 2.0 * h.grip_time + 2.0 * h.lift_time + 3.0 * h.swing_time


@compiled
def step_path(time: float, length: float) -> tuple[float, float]:
    """Share of a move done and its rate [1/s]: fifth order, at rest at both ends.

    Args:
        time: since the move began [s].
        length: of the move [s].
    """
    if time <= 0.0:
        return 0.0, 0.0
    if time >= length:
        return 1.0, 0.0
    share = time / length
    rest = 1.0 - share
    return (
        share * share * share * (share * (6.0 * share - 15.0) + 10.0),
        30.0 * share * share * rest * rest / length,
    )


@compiled
def grip(time: float, h: HandConstants) -> float:
    """How firmly the hand holds, 0 .. 1, at a time since homing began [s].

    Args:
        time: since homing began [s].
        h: constants of the hand.
    """
    taken = step_path(time, h.grip_time)[0]
    released = step_path(time - duration(h) + h.grip_time, h.grip_time)[0]
    return taken * (1.0 - released)


@compiled
def carried(time: float, h: HandConstants) -> tuple[float, float]:
    """Share of the way from where it stood to the top of the lift, and its rate [1/s].

    Args:
        time: since homing began [s].
        h: constants of the hand.
    """
    return step_path(time - h.grip_time, h.lift_time)


@compiled
def lowered(time: float, h: HandConstants) -> tuple[float, float]:
    """Share of the way back down to the stop, and its rate [1/s].

    Args:
        time: since homing began [s].
        h: constants of the hand.
    """
    return step_path(time - h.grip_time - h.lift_time - 3.0 * h.swing_time, h.lift_time)


@compiled
def swing(time: float, axis: int, h: HandConstants) -> tuple[float, float]:
    """Angle [rad] and rate [rad/s] of the swing of one axis: 0 yaw, 1 pitch, 2 roll.

    Args:
        time: since homing began [s].
        axis: of the gimbal, 0 yaw, 1 pitch, 2 roll.
        h: constants of the hand.
    """
    begin = h.grip_time + h.lift_time + axis * h.swing_time
    share, rate = step_path(time - begin, h.swing_time)
    turn = 2.0 * math.pi
    return h.swing * math.sin(turn * share), h.swing * turn * math.cos(turn * share) * rate


@compiled
def pull(
    time: float, position: float, velocity: float, start: float, top: float, bottom: float, h: HandConstants
) -> float:
    """Force along one earth axis [N], the lift of the weight not included.

    Args:
        time: since homing began [s].
        position: of the platform along the axis [m].
        velocity: along the axis [m/s].
        start: position when homing began [m].
        top: position at the top of the lift [m].
        bottom: position at which it is set down [m].
        h: constants of the hand.
    """
    up, up_rate = carried(time, h)
    down, down_rate = lowered(time, h)
    path = start + (top - start) * up + (bottom - top) * down
    path_rate = (top - start) * up_rate + (bottom - top) * down_rate
    return grip(time, h) * (h.stiffness * (path - position) + h.damping * (path_rate - velocity))


@compiled
def turn(time: float, axis: int, angle: float, rate: float, start: float, h: HandConstants) -> float:
    """Torque about one gimbal axis [N m]: 0 yaw, 1 pitch, 2 roll.

    Args:
        time: since homing began [s].
        axis: of the gimbal.
        angle: of the axis [rad].
        rate: of the axis [rad/s].
        start: angle when homing began [rad].
        h: constants of the hand.
    """
    up, up_rate = carried(time, h)
    swung, swung_rate = swing(time, axis, h)
    path = start * (1.0 - up) + swung
    path_rate = swung_rate - start * up_rate
    return grip(time, h) * (h.turn_stiffness * (path - angle) + h.turn_damping * (path_rate - rate))


@compiled
def lift(time: float, h: HandConstants) -> float:
    """Force upwards that carries the weight [N].

    Args:
        time: since homing began [s].
        h: constants of the hand.
    """
    return grip(time, h) * h.weight
