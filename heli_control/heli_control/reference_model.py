"""The response that is expected of a position axis: second order, critically damped.

    r'' = omega^2 (r_ref - r) - 2 omega r'

An integral part that takes in r - y instead of r_ref - y does not wind up while the helicopter is on its way
as expected; what it takes in is disturbance and trim alone. A ramp is followed with r' as feed-forward.
"""

from __future__ import annotations

from math import exp

from heli_common.timing import CONTROL_PERIOD


def respond(
    value: float, rate: float, reference: float, frequency: float, decay: float
) -> tuple[float, float]:
    """Value and rate one control period later; compiled code may call it.

    With d = r - r_ref the solution is (d + (r' + omega d) t) e^(-omega t), and its derivative.

    Args:
        value: expected position [m or rad].
        rate: its derivative.
        reference: held over the period [m or rad].
        frequency: omega [rad/s].
        decay: e^(-omega T).
    """
    distance = value - reference
    slope = rate + frequency * distance
    late = distance + slope * CONTROL_PERIOD
    return reference + late * decay, (slope - frequency * late) * decay


class ReferenceModel:
    """One axis, discretised exactly for a reference that is held over a control period.

    Args:
        frequency: omega [rad/s].

    Attributes:
        value: expected position [m or rad].
        rate: its derivative [m/s or rad/s].
        frequency: as given.
        decay: e^(-omega T).
    """

    def __init__(self, frequency: float) -> None:
        self.value = 0.0
        self.rate = 0.0
        self.frequency = frequency
        self.decay = exp(-frequency * CONTROL_PERIOD)

    def reset(self, value: float) -> None:
        """At rest at a value."""
        self.value, self.rate = value, 0.0

    def step(self, reference: float) -> None:
        """Go on by one control period towards a reference."""
        self.value, self.rate = respond(self.value, self.rate, reference, self.frequency, self.decay)
