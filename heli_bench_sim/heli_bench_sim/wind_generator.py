"""The wind generator: an axial fan in front of the helicopter and the turbulence of its jet (spec 2.7, D).

The fan stands north of the flight space, where the nose points at psi = 0, and blows south along the north
axis through the flight-space centre. Its speed follows the command with a first-order lag. The mean speed
falls off from the axis like a Gaussian curve; the jet keeps its width over the small flight space.

Turbulence is a frozen field that the jet carries past the helicopter, of Dryden's form (MIL-F-8785C) with
one length L for all three components, which makes it isotropic. With spatial frequency W [rad/m], one-sided:

    along the jet   sigma^2 (2 L / pi) / (1 + (L W)^2)
    across it       sigma^2 (L / pi) (1 + 3 (L W)^2) / (1 + (L W)^2)^2

Being frozen, it changes with the distance the air has travelled, not with time (the helicopter's own speed
through it is small and not counted). So the filters step in
h = distance / L, the distance being the exact integral of the lagging speed: their bandwidth is V / L at any
moment, their variance never depends on V, and with the fan at rest h = 0 and nothing moves. The filters start
from zero: the field fades in over the first lengths of air. One field serves the whole cross-section, its
strength being the intensity times the local mean speed.
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

FIRST_SHARE = math.sqrt(1.5)
"""Share of the first filter state in the gust across the jet: sqrt(3) / sqrt(2)."""

SECOND_SHARE = (1.0 - math.sqrt(3.0)) / math.sqrt(2.0)
"""Share of the second: together (1 + sqrt(3) s) / (1 + s)^2 with unit variance, s per length of air."""


class WindState(IntEnum):
    """What the fan and its jet carry from step to step."""

    speed = 0
    """mean speed on the axis [m/s]"""
    along = 1
    """gust along the jet over its standard deviation"""
    east_first = 2
    """first-order state of the gust to the east"""
    east_second = 3
    """what follows it, one more lag behind"""
    down_first = 4
    """the same of the gust downwards"""
    down_second = 5


WIND_STATE_SIZE = len(WindState)

WIND_NORMALS = 3
"""Standard normal numbers per step: along the jet, east, down."""


@dataclass(frozen=True)
class WindParameters:
    """The fan and its jet."""

    largest_speed: float = quantity(8.0, "m/s", "D", "largest speed that can be commanded", 0.0, 30.0)
    lag: float = quantity(1.5, "s", "D", "time constant of the fan", 0.01, 60.0)
    half_width: float = quantity(
        0.6, "m", "D", "radius at which the mean speed is half that of the axis", 0.05, 10.0
    )
    intensity: float = quantity(0.10, "-", "D", "standard deviation of a gust per local mean speed", 0.0, 0.5)
    length: float = quantity(1.0, "m", "D", "L: Dryden length of the turbulence", 0.01, 100.0)


DEFAULT_WIND = WindParameters()


class WindConstants(NamedTuple):
    """What the compiled jet needs; every field a float, SI."""

    largest_speed: float
    lag: float
    jet_decay: float
    """ln 2 / half_width^2 [1/m^2]"""
    intensity: float
    length: float


def wind_constants(parameters: WindParameters) -> WindConstants:
    """Constants of the compiled jet.

    Args:
        parameters: of the fan and its jet.
    """
    return WindConstants(
        largest_speed=parameters.largest_speed,
        lag=parameters.lag,
        jet_decay=math.log(2.0) / parameters.half_width**2,
        intensity=parameters.intensity,
        length=parameters.length,
    )


def check_wind_command(speed: float, parameters: WindParameters = DEFAULT_WIND) -> float:
    """The commanded speed, unchanged, if the fan can be set to it.

    Args:
        speed: wanted on the axis [m/s].
        parameters: of the fan.

    Raises:
        ValueError: the speed is no number or out of range.
    """
    if not 0.0 <= speed <= parameters.largest_speed:
        raise ValueError(
            f"wind speed {speed!r} m/s is out of range (allowed: 0 .. {parameters.largest_speed:g} m/s)"
        )
    return float(speed)


@compiled
def wind_advance(state: Array, command: float, normals: Array, period: float, c: WindConstants) -> None:
    """Advance the fan and the filters of its turbulence by one step, in place.

    The lag and the gust along the jet are exact for any step. So is the first state of each gust across it.
    Of the second state's noise the part that goes with the first's is kept and the rest, of variance
    h^3 / 6 a step, is left out: one number per gust then suffices, and the variance comes out low by about
    h^2 / 45 of itself, 9e-6 at 8 m/s and 2.5 ms.

    Args:
        state: (6,) in the order of `WindState`, overwritten.
        command: speed on the axis [m/s], clipped to 0 .. largest_speed, held over the step.
        normals: (3,) standard normal numbers, independent from step to step.
        period: length of the step [s], positive.
        c: constants of the jet.
    """
    asked = min(command, c.largest_speed) if command > 0.0 else 0.0
    gap = state[WindState.speed] - asked
    closed = -math.expm1(-period / c.lag)
    h = (asked * period + gap * c.lag * closed) / c.length
    state[WindState.speed] = asked + gap * (1.0 - closed)
    if h <= 0.0:
        return
    kept, fresh = math.exp(-h), -math.expm1(-2.0 * h)
    noise = math.sqrt(fresh)
    passed = 0.5 * (fresh - 2.0 * h * kept * kept) / noise
    state[WindState.along] = kept * state[WindState.along] + noise * normals[0]
    for across in range(2):
        first, number = WindState.east_first + 2 * across, normals[1 + across]
        before = state[first]
        state[first] = kept * before + noise * number
        state[first + 1] = kept * (state[first + 1] + h * before) + passed * number


@compiled
def wind_at(x: float, y: float, z: float, state: Array, c: WindConstants, out: Array) -> None:  # noqa: ARG001
    """Write the velocity of the jet's air at a place, NED [m/s], into `out`.

    Args:
        x: north of the flight-space centre [m]; without effect, the jet keeps its width.
        y: east [m].
        z: down [m].
        state: (6,) of the jet.
        c: constants of the jet.
        out: (3,) receives the velocity; (-V, 0, 0) on the axis of a jet without turbulence.
    """
    mean = state[WindState.speed] * math.exp(-c.jet_decay * (y * y + z * z))
    gust = c.intensity * mean
    out[0] = -(mean + gust * state[WindState.along])
    out[1] = gust * (FIRST_SHARE * state[WindState.east_first] + SECOND_SHARE * state[WindState.east_second])
    out[2] = gust * (FIRST_SHARE * state[WindState.down_first] + SECOND_SHARE * state[WindState.down_second])
