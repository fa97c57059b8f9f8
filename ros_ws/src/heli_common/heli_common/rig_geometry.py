"""The Delta rig's geometry: what both the simulated bench and navigation must know (spec 2.1, 2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from heli_common.quantities import quantity

COUNTS_PER_REVOLUTION = 2000
"""Six incremental optical encoders of 0.18 deg (T)."""

RADIAN_PER_COUNT = 2.0 * math.pi / COUNTS_PER_REVOLUTION

QUANTISATION_VARIANCE = RADIAN_PER_COUNT**2 / 12.0
"""Of an encoder angle: uniformly distributed within one count [rad^2]."""

ARM_AZIMUTH = (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
"""Azimuth of the three arms [rad], from north (the nose at psi = 0), clockwise seen from above (D)."""

ENCODER_NAMES = ("arm_1", "arm_2", "arm_3", "yaw", "pitch", "roll")


@dataclass(frozen=True)
class RigGeometry:
    """Delta arm on the floor; the platform never rotates, its point is the centre of gravity."""

    base_radius: float = quantity(0.30, "m", "D", "circle of the base pivots", 0.0, 5.0)
    upper_arm: float = quantity(0.75, "m", "D", "length of an upper arm", 0.01, 5.0)
    forearm: float = quantity(0.90, "m", "D", "length of a parallelogram forearm", 0.01, 5.0)
    platform_radius: float = quantity(0.06, "m", "D", "circle of the platform joints", 0.0, 5.0)
    centre_height: float = quantity(0.90, "m", "D", "flight-space centre above the base plane", 0.0, 5.0)
    work_radius: float = quantity(0.50, "m", "D", "radius of the cylinder of the work space", 0.01, 5.0)
    work_bottom: float = quantity(0.45, "m", "D", "lowest height of the work space above the base", 0.0, 5.0)
    work_top: float = quantity(1.25, "m", "D", "highest height of the work space above the base", 0.0, 5.0)

    @property
    def rest_depth(self) -> float:
        """NED z [m] of the platform on the lower stop, below the flight-space centre."""
        return self.centre_height - self.work_bottom

    @property
    def fold_height(self) -> float:
        """Height [m] on the axis where platform and elbows are level: below it the arms fold over."""
        cosine = (self.forearm - self.base_radius + self.platform_radius) / self.upper_arm
        return self.upper_arm * math.sqrt(max(0.0, 1.0 - cosine**2))
