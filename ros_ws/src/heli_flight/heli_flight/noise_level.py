"""F4: how much noise on the longitudinal cyclic each controller bears for 5 s (source sec. 5.3.3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians

import numpy as np

from heli_common.errors import InputError
from heli_flight.components import DEFAULTS
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Excite, Plan
from heli_flight.unrecorded_flight import FlownFlight, fly_excited, lost
from heli_identification.excitation import CHANNELS, Excitation, samples

CHANNEL = "B_1s"
HIGHEST = radians(10.0)
"""Where the search begins [rad]; the swash plate itself reaches +-6.3 deg of cyclic in hover."""
RESOLUTION = radians(0.1)


@dataclass(frozen=True)
class NoiseLevel:
    """What one controller bears of one draw of noise.

    Attributes:
        borne: largest standard deviation flown and not lost [rad]; 0 if none was.
        lost: smallest one lost [rad]; None if none was.
        reason: why that one was lost.
    """

    borne: float
    lost: float | None
    reason: str

    @property
    def level(self) -> float:
        """Between both; what was borne if none was lost [rad]."""
        return self.borne if self.lost is None else 0.5 * (self.borne + self.lost)


def deviation(excitation: Excitation) -> float:
    """Standard deviation of an excitation on CHANNEL over its duration [rad]."""
    return float(np.std(samples(excitation)[:, CHANNELS.index(CHANNEL)]))


def with_noise(plan: Plan, sigma: float, seed: int) -> Plan:
    """The plan with its noise so strong, drawn from a seed.

    Args:
        plan: with one excitation, on CHANNEL.
        sigma: standard deviation [rad], positive.
        seed: of the noise.

    Raises:
        InputError: the plan does not excite CHANNEL once.
    """
    if [one.channels for one in plan.excitations] != [(CHANNEL,)]:
        raise InputError(
            f"{plan.name} is no plan for noise", allowed=f"one excite phase on {CHANNEL}", key="phases"
        )
    phases = []
    for phase in plan.phases:
        if isinstance(phase, Excite):
            drawn = replace(phase.excitation, seed=seed)
            strong = replace(drawn, amplitude=drawn.amplitude * sigma / deviation(drawn))
            phase = replace(phase, excitation=strong)
        phases.append(phase)
    return replace(plan, phases=tuple(phases))


def fly_noise(
    plan: Plan, controller: str, sigma: float, seed: int, values: NodeValues = DEFAULTS
) -> FlownFlight:
    """Fly noise of a standard deviation [rad] until the plan or the supervisor ends it.

    The seed is that of bench and noise. On the graph the identification's guard would end the noise earlier,
    unless told not to by ros_ws/config/wide_guard.yaml.
    """
    return fly_excited(with_noise(plan, sigma, seed), controller, seed, values)


def noise_level(
    why_lost: Callable[[float], str], highest: float = HIGHEST, resolution: float = RESOLUTION
) -> NoiseLevel:
    """The level between being borne and being lost, by bisection.

    Args:
        why_lost: flies a standard deviation [rad]; empty if it is borne.
        highest: where the search begins [rad].
        resolution: where it ends [rad].
    """
    reason = why_lost(highest)
    if not reason:
        return NoiseLevel(highest, None, "")
    borne, lost_at = 0.0, highest
    while lost_at - borne > resolution * (1.0 + 1e-9):
        middle = 0.5 * (borne + lost_at)
        found = why_lost(middle)
        if found:
            lost_at, reason = middle, found
        else:
            borne = middle
    return NoiseLevel(borne, lost_at, reason)


def flown_noise_level(
    plan: Plan, controller: str, seed: int, values: NodeValues = DEFAULTS, resolution: float = RESOLUTION
) -> NoiseLevel:
    """The level of one controller and one draw of noise, flown."""
    return noise_level(
        lambda sigma: lost(fly_noise(plan, controller, sigma, seed, values)), resolution=resolution
    )
