"""Levers of the rotor head: gains that depend on collective, and slack; both off by default (spec 1.5).

Source sec. 2.3.2 takes the gains of its eq. 2.44 and 2.45 as constants and adds that they "depend on the
collective angle" and that "the levers have a certain slackness". Table 2.1 gives what was measured: k_p2r 0.5
to 0.8, k_s2r 0.3 to 0.7, k_s2p 0.9 to 1.5, without saying how they depend on it. Here (design choice)

    k(theta_0) = k + slope (theta_0 - theta_k)

with k the constant gain of the model, which thereby holds at the collective theta_k of hover. A slope of size
0.86, 1.15 and 1.72 per radian runs through the measured range over the whole collective, -4 to +16 deg.

Slack is a smooth dead zone without memory (design choice; the real one has hysteresis). A blade turns through
its cyclic pitch B cos + A sin once a turn, and the play h to either side eats from the size of that swing,
never from its direction:

    (B, A) -> (1 - h / sqrt(B^2 + A^2 + h^2)) (B, A)

The loss goes to h for large swings; at zero the slope is zero. The collective keeps its levers loaded on one
side and has no slack.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from heli_common.compiled import equation
from heli_common.quantities import quantity

if TYPE_CHECKING:  # the helicopter's constants hold those of this module
    from heli_bench_sim.parameters import HelicopterParameters


@dataclass(frozen=True)
class LeverParameters:
    """What the constant gains leave out; all zero by default, which is the source's own model."""

    gain_slope_bar_to_blade: float = quantity(
        0.0, "1/rad", "D", "slope of k_p2r against collective; 0.86 spans Table 2.1", -2.2, 2.2
    )
    gain_slope_plate_to_blade: float = quantity(
        0.0, "1/rad", "D", "slope of k_s2r against collective; 1.15 spans Table 2.1", -1.4, 1.4
    )
    gain_slope_plate_to_bar: float = quantity(
        0.0, "1/rad", "D", "slope of k_s2p against collective; 1.72 spans Table 2.1", -5.8, 5.8
    )
    gain_collective: float = quantity(
        math.radians(9.689), "rad", "R", "theta_k: collective at which the gains are k (hover)", -0.1, 0.3
    )
    slack: float = quantity(
        0.0, "rad", "D", "h: play of the blade-pitch levers to either side, at the blade", 0.0, 0.05
    )


class LeverConstants(NamedTuple):
    """What the compiled levers need; every field a float."""

    bar_to_blade: float
    plate_to_blade: float
    plate_to_bar: float
    slope_bar_to_blade: float
    slope_plate_to_blade: float
    slope_plate_to_bar: float
    collective: float
    """where the slopes start from [rad]"""
    slack: float


def lever_constants(parameters: LeverParameters, helicopter: HelicopterParameters) -> LeverConstants:
    """Constants of the compiled levers.

    Args:
        parameters: slopes and slack.
        helicopter: whose constant gains hold at the collective of hover.
    """
    return LeverConstants(
        bar_to_blade=helicopter.bar_to_blade,
        plate_to_blade=helicopter.plate_to_blade,
        plate_to_bar=helicopter.plate_to_bar,
        slope_bar_to_blade=parameters.gain_slope_bar_to_blade,
        slope_plate_to_blade=parameters.gain_slope_plate_to_blade,
        slope_plate_to_bar=parameters.gain_slope_plate_to_bar,
        collective=parameters.gain_collective,
        slack=parameters.slack,
    )


@equation
def lever_gains(theta_0: float, k: LeverConstants) -> tuple[float, float, float]:
    """Gains bar to blade, plate to blade and plate to bar, (k_p2r, k_s2r, k_s2p) [-].

    Args:
        theta_0: collective [rad].
        k: constants of the levers.
    """
    beyond = theta_0 - k.collective
    return (
        k.bar_to_blade + k.slope_bar_to_blade * beyond,
        k.plate_to_blade + k.slope_plate_to_blade * beyond,
        k.plate_to_bar + k.slope_plate_to_bar * beyond,
    )


@equation
def share_through(square: float, slack: float) -> float:
    """Share of a swing that gets through the slack, 0 .. 1; 1 without slack.

    Args:
        square: of the swing's amplitude [rad^2].
        slack: play to either side [rad], 0 or more.
    """
    if slack <= 0.0:
        return 1.0
    return 1.0 - slack / math.sqrt(square + slack * slack)


@equation
def after_slack(angle: float, slack: float) -> float:
    """What one lever passes on of an angle [rad].

    Args:
        angle: of the lever's driven side [rad].
        slack: play to either side [rad], 0 or more.
    """
    return angle * share_through(angle * angle, slack)


@equation
def cyclic_after_slack(back: float, right: float, slack: float) -> tuple[float, float]:
    """What the blade-pitch levers pass on of a cyclic pitch [rad]: smaller, in the same direction.

    Args:
        back: cyclic pitch that tilts the disc back [rad].
        right: cyclic pitch that tilts it right [rad].
        slack: play to either side [rad], 0 or more.
    """
    share = share_through(back * back + right * right, slack)
    return share * back, share * right
