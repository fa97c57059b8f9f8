"""What the servos reach: the limits of a command, by the rule of the swash plate (spec 2.5).

Three servos at 0, 120 and 240 deg from the nose hold the swash plate and share their travel between
collective and cyclic:

    shaft_i = lever (theta_0 - neutral + B_1s cos psi_i + A_1s sin psi_i),   |shaft_i| <= shaft limit

A command outside is limited as the bench limits it: the collective is clipped and kept, because it carries
the weight; the cyclic is then shortened, direction kept, until the servo worst off stands at its end.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, radians, sin

from heli_common.errors import InputError
from heli_common.topics import SERVO_CHANNELS

_SERVOS = tuple((cos(radians(azimuth)), sin(radians(azimuth))) for azimuth in (0.0, 120.0, 240.0))
_ROUNDING = 1e-12


def limit_command(
    command: list[float], lowest: Sequence[float], highest: Sequence[float], neutral: float, reach: float
) -> None:
    """Bring a command to what the servos reach, in place, by the rule of this module; compiled code may call it.

    Args:
        command: B_1s, A_1s, theta_0, theta_t [rad], overwritten.
        lowest: of each [rad].
        highest: of each [rad].
        neutral: collective of zero shaft angles [rad].
        reach: blade angle that takes a servo from neutral to its end [rad].
    """
    for index in range(4):
        command[index] = min(max(command[index], lowest[index]), highest[index])
    back, right, used = command[0], command[1], command[2] - neutral
    share = 1.0
    for along, across in _SERVOS:
        cyclic = back * along + right * across
        room = reach - used if cyclic > 0.0 else reach + used
        if abs(cyclic) > room:
            share = min(share, room / abs(cyclic))
    command[0], command[1] = share * back, share * right


class CommandLimits:
    """Limits of B_1s, A_1s, theta_0 and theta_t.

    Args:
        lowest: of each command [rad].
        highest: of each command [rad].
        collective_neutral: collective of zero shaft angles [rad].
        reach: shaft limit per lever, the blade angle that takes a servo from neutral to its end [rad].

    Attributes:
        lowest: of each command, the collective within reach [rad].
        highest: the same.
        neutral: collective of zero shaft angles [rad].
        reach: as given.
    """

    def __init__(
        self, lowest: Sequence[float], highest: Sequence[float], collective_neutral: float, reach: float
    ) -> None:
        _, _, low, tail_low = lowest
        _, _, high, tail_high = highest
        bottom, top = max(low, collective_neutral - reach), min(high, collective_neutral + reach)
        self.lowest = (lowest[0], lowest[1], bottom, tail_low)
        self.highest = (highest[0], highest[1], top, tail_high)
        self.neutral, self.reach = collective_neutral, reach

    def within(self, command: Sequence[float]) -> list[float]:
        """The command nearest to this one that the servos reach, by the rule of this module [rad].

        Args:
            command: B_1s, A_1s, theta_0, theta_t [rad].
        """
        kept = list(command)
        limit_command(kept, self.lowest, self.highest, self.neutral, self.reach)
        return kept

    def require(self, command: Sequence[float], key: str) -> None:
        """Refuse a command that the servos do not reach.

        Args:
            command: B_1s, A_1s, theta_0, theta_t [rad].
            key: named in the error, before the command's name.

        Raises:
            InputError: names the first command out of its range.
        """
        for name, value, low, high in zip(SERVO_CHANNELS, command, self.lowest, self.highest, strict=True):
            if not low <= value <= high:
                raise InputError(f"{value!r}", allowed=f"{low:.4g} .. {high:.4g} rad", key=f"{key}.{name}")
        reached = self.within(command)
        for name, value, kept in zip(SERVO_CHANNELS, command, reached, strict=True):
            if abs(value - kept) > _ROUNDING:
                allowed = f"{kept:.4g} rad beside this collective"
                raise InputError(f"{value!r}", allowed=allowed, key=f"{key}.{name}")
