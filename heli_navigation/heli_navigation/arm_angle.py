"""One arm's angle at a position of the platform, and its derivative: the arms one by one (spec 2.1).

The forearm from elbow to platform, s = p - c(alpha), keeps its length, so s . dp = s . (dc / d alpha) d alpha
and the angle's derivative by the position is s / (s . dc / d alpha): a row of the inverse of the arms'
Jacobian. It needs no other arm, so an encoder that fails takes nothing else away.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_common.rig_geometry import ARM_AZIMUTH
from heli_navigation.filter_memory import Work
from heli_navigation.filter_parameters import FilterConstants

Array = NDArray[np.float64]

_SINE = tuple(math.sin(azimuth) for azimuth in ARM_AZIMUTH)
_COSINE = tuple(math.cos(azimuth) for azimuth in ARM_AZIMUTH)
_SLOPE = int(Work.slope)

OUT_OF_REACH = 100.0
"""What stands for the angle of an arm that does not reach the platform [rad]."""


@compiled
def arm_angle(arm: int, north: float, east: float, down: float, c: FilterConstants, work: Array) -> float:
    """Angle from the horizontal, outward, up positive [rad]; `OUT_OF_REACH` if the arm does not reach.

    Args:
        arm: 0, 1, 2.
        north: of the platform, NED from the flight-space centre [m].
        east: the same.
        down: the same.
        c: constants of the filter.
        work: scratch in the order of `Work`; slope, the derivative by the position [rad/m], is written.
    """
    sine, cosine = _SINE[arm], _COSINE[arm]
    height = c.centre_height - down
    outward = north * cosine + east * sine - c.inward
    aside = east * cosine - north * sine
    excess = outward * outward + aside * aside + height * height + c.upper_arm**2 - c.forearm**2
    needed = 0.5 * excess / c.upper_arm
    square = outward * outward + height * height - needed * needed
    if not square > 0.0:
        return OUT_OF_REACH
    tangent = (needed - outward) / (height + math.sqrt(square))  # of half the angle, of the outer elbow
    scale = 1.0 / (1.0 + tangent * tangent)
    cos_angle, sin_angle = (1.0 - tangent * tangent) * scale, 2.0 * tangent * scale
    # the forearm in the arm's own axes: outward, aside, up
    s_out = outward - c.upper_arm * cos_angle
    s_up = height - c.upper_arm * sin_angle
    lever = c.upper_arm * (s_up * cos_angle - s_out * sin_angle)
    work[_SLOPE] = (s_out * cosine - aside * sine) / lever
    work[_SLOPE + 1] = (s_out * sine + aside * cosine) / lever
    work[_SLOPE + 2] = -s_up / lever
    return 2.0 * math.atan(tangent)
