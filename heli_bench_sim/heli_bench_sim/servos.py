"""Four servos: pulse, mixing over the swash plate both ways, limits, motion (spec 2.5).

Three servos hold the swash plate at azimuths 0, 120 and 240 deg, one turns the tail. A shaft turns +-60 deg
for pulses of 1.5 +- 0.5 ms. All three swash-plate servos share collective and cyclic, so a command may lie
outside what they reach. Rule: the collective is clipped to its range and kept, because it carries the
weight; the cyclic is then shortened, direction kept, until the servo worst off stands at its end. The tail
is clipped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled, equation
from heli_common.quantities import quantity

Array = NDArray[np.float64]

SERVOS = 4
"""Three at the swash plate, then the tail."""

SERVO_AZIMUTH = (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
"""Azimuth of the swash-plate servos from the nose [rad] (D)."""

_COSINE = (1.0, -0.5, -0.5)
_SINE = (0.0, 0.5 * math.sqrt(3.0), -0.5 * math.sqrt(3.0))

COMMAND_NAMES = ("B_1s", "A_1s", "theta_0", "theta_t")


@dataclass(frozen=True)
class ServoParameters:
    """Servos and levers."""

    shaft_limit: float = quantity(math.radians(60.0), "rad", "D", "shaft angle at the end pulse", 0.1, 3.0)
    neutral_pulse: float = quantity(1.5e-3, "s", "D", "pulse of shaft angle zero", 1e-4, 1e-2)
    pulse_range: float = quantity(0.5e-3, "s", "D", "pulse from neutral to the end", 1e-5, 1e-2)
    pulse_step: float = quantity(1e-6, "s", "D", "resolution of the pulse", 1e-9, 1e-4)
    plate_lever: float = quantity(6.0, "-", "D", "shaft angle per blade angle, swash plate", 0.1, 100.0)
    tail_lever: float = quantity(4.0, "-", "D", "shaft angle per blade angle, tail", 0.1, 100.0)
    collective_neutral: float = quantity(
        math.radians(6.0), "rad", "D", "collective of zero shafts", -0.5, 0.5
    )
    tail_neutral: float = quantity(math.radians(10.0), "rad", "D", "tail collective of zero shaft", -0.5, 0.5)
    bandwidth: float = quantity(2.0 * math.pi * 25.0, "rad/s", "T", "natural frequency", 1.0, 1e3)
    damping: float = quantity(0.7, "-", "D", "damping ratio", 0.1, 5.0)
    rate_limit: float = quantity(math.radians(500.0), "rad/s", "D", "fastest shaft rate", 0.1, 100.0)


class ServoConstants(NamedTuple):
    """What the compiled servo needs; every field a float, angles of shafts [rad]."""

    plate_lever: float
    tail_lever: float
    collective_neutral: float
    tail_neutral: float
    bandwidth: float
    damping: float
    rate_limit: float
    shaft_limit: float
    pulse_range: float
    pulse_step: float


def servo_constants(parameters: ServoParameters) -> ServoConstants:
    """The part of the parameters that the equations of motion need.

    Args:
        parameters: servos and levers.
    """
    return ServoConstants(
        plate_lever=parameters.plate_lever,
        tail_lever=parameters.tail_lever,
        collective_neutral=parameters.collective_neutral,
        tail_neutral=parameters.tail_neutral,
        bandwidth=parameters.bandwidth,
        damping=parameters.damping,
        rate_limit=parameters.rate_limit,
        shaft_limit=parameters.shaft_limit,
        pulse_range=parameters.pulse_range,
        pulse_step=parameters.pulse_step,
    )


@compiled
def mix(b_1s: float, a_1s: float, theta_0: float, theta_t: float, s: ServoConstants, out: Array) -> None:
    """Write the four shaft angles [rad] that give these blade angles [rad] into `out` (4,).

    Args:
        b_1s: longitudinal cyclic [rad].
        a_1s: lateral cyclic [rad].
        theta_0: collective [rad].
        theta_t: tail collective [rad].
        s: constants of the servos.
        out: (4,) receives the shaft angles [rad].
    """
    for servo in range(SERVOS - 1):
        cyclic = b_1s * _COSINE[servo] + a_1s * _SINE[servo]
        out[servo] = s.plate_lever * (theta_0 - s.collective_neutral + cyclic)
    out[SERVOS - 1] = s.tail_lever * (theta_t - s.tail_neutral)


@equation
def unmix(shafts: Array, first: int, s: ServoConstants) -> tuple[float, float, float, float]:
    """Blade angles B_1s, A_1s, theta_0, theta_t [rad] of four shaft angles [rad].

    Args:
        shafts: holds the four shaft angles [rad].
        first: index of the first of them.
        s: constants of the servos.
    """
    one, two, three = shafts[first], shafts[first + 1], shafts[first + 2]
    back = one * _COSINE[0] + two * _COSINE[1] + three * _COSINE[2]
    right = one * _SINE[0] + two * _SINE[1] + three * _SINE[2]
    return (
        back * 2.0 / 3.0 / s.plate_lever,
        right * 2.0 / 3.0 / s.plate_lever,
        (one + two + three) / 3.0 / s.plate_lever + s.collective_neutral,
        shafts[first + 3] / s.tail_lever + s.tail_neutral,
    )


@equation
def shaft_acceleration(angle: float, rate: float, command: float, s: ServoConstants) -> float:
    """Acceleration of one shaft [rad/s^2]: second order, the rate asked for limited.

    Written as a rate loop inside a position loop. Within the limit it is the plain second-order servo,
    omega^2 (command - angle) - 2 zeta omega rate; the limit then bounds the rate without a jump in force.

    Args:
        angle: of the shaft [rad].
        rate: of the shaft [rad/s].
        command: where it shall go [rad].
        s: constants of the servos.
    """
    rate_gain = 2.0 * s.damping * s.bandwidth
    asked = s.bandwidth / (2.0 * s.damping) * (command - angle)
    return rate_gain * (min(max(asked, -s.rate_limit), s.rate_limit) - rate)


@compiled
def reach_shafts(
    b_1s: float, a_1s: float, theta_0: float, theta_t: float, s: ServoConstants, out: Array
) -> bool:
    """Mix, limit by the rule of this module, and quantise to whole pulse steps.

    Args:
        b_1s: longitudinal cyclic [rad].
        a_1s: lateral cyclic [rad].
        theta_0: collective [rad].
        theta_t: tail collective [rad].
        s: constants of the servos.
        out: (4,) receives the shaft angles [rad].

    Returns:
        whether the limits changed the command.
    """
    end, tail = s.shaft_limit, SERVOS - 1
    mix(b_1s, a_1s, theta_0, theta_t, s, out)
    level = s.plate_lever * (theta_0 - s.collective_neutral)
    kept = min(max(level, -end), end)
    share = 1.0
    for servo in range(tail):
        cyclic = out[servo] - level
        room = end - kept if cyclic > 0.0 else end + kept
        if abs(cyclic) > room:
            share = min(share, room / abs(cyclic))
    saturated = share < 1.0 or kept != level
    for servo in range(tail):
        out[servo] = kept + share * (out[servo] - level)
    held = min(max(out[tail], -end), end)
    saturated = saturated or held != out[tail]
    out[tail] = held
    for servo in range(SERVOS):
        steps = np.rint(out[servo] / end * s.pulse_range / s.pulse_step)
        out[servo] = steps * (s.pulse_step / s.pulse_range * end)
    return saturated


def require_finite_command(command: Sequence[float]) -> None:
    """Refuse a servo command that is no number.

    Args:
        command: B_1s, A_1s, theta_0, theta_t [rad].

    Raises:
        ValueError: a value that is not finite, by name.
    """
    for name, value in zip(COMMAND_NAMES, command, strict=True):
        if not math.isfinite(value):
            raise ValueError(f"servo command {name} is {value!r}, not a finite angle")
