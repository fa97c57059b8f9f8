"""Which law flies, and how the next one takes over without a jump (spec 3: bumpless switching).

A law that comes in flight is settled on the command of that very sample, so the first command is the one
that would have been given anyhow. The laws before it fade out linearly over the exchange time:

    command = (1 - share) sum(weight_i old_i) + share new,   share = 0 .. 1

All of them step on and are told what was applied, so none runs away meanwhile. One more law may come before
the last exchange is over: the mixture flown until then is what fades.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from heli_common.rotations import Vector3
from heli_common.vehicle_state import VehicleState
from heli_control.flight_law import FlightLaw


class LawExchange:
    """The law that flies and those that fade out.

    Args:
        law: the first.
        step: share of a whole exchange per sample, 0 .. 1.
        limit: what the servos reach of a command.
    """

    def __init__(self, law: FlightLaw, step: float, limit: Callable[[Sequence[float]], list[float]]) -> None:
        self.law = law
        self._step = step
        self._limit = limit
        self._fading: list[tuple[FlightLaw, float]] = []  # with weights that add up to 1
        self._share = 1.0
        self._unsettled = False

    def replace(self, law: FlightLaw) -> None:
        """Let another law take over from the next sample on."""
        if self._unsettled:  # the one before has not flown yet
            self.law = law
            return
        share = self._share
        self._fading = [(old, (1.0 - share) * weight) for old, weight in self._fading]
        self._fading.append((self.law, share))
        self.law = law
        self._share, self._unsettled = 0.0, True

    def reset(self) -> None:
        """Rest at the operating point of the law that flies; nothing fades any more."""
        self.law.reset()
        self._fading = []
        self._share, self._unsettled = 1.0, False

    def step(self, state: VehicleState, velocity: Vector3, yaw_rate: float) -> list[float]:
        """Commands within what the servos reach [rad]; arguments as for `FlightLaw.step`."""
        if not self._fading:
            return self._limit(self.law.step(state, velocity, yaw_rate))
        old = [0.0] * len(self.law.trim)
        for law, weight in self._fading:
            for index, command in enumerate(law.step(state, velocity, yaw_rate)):
                old[index] += weight * command
        old = self._limit(old)
        if self._unsettled:
            self.law.settle(state, velocity, yaw_rate, old)
            self._unsettled = False
        self._share = min(1.0, self._share + self._step)
        new = self.law.step(state, velocity, yaw_rate)
        share = self._share
        return self._limit(
            [before + share * (after - before) for before, after in zip(old, new, strict=True)]
        )

    def follow(self, applied: Sequence[float]) -> None:
        """Tell every law which commands of the last step really went out [rad]."""
        self.law.follow(applied)
        if self._share >= 1.0:
            self._fading = []
        for law, _ in self._fading:
            law.follow(applied)
