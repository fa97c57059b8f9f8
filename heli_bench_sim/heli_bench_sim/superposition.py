"""Servo command and excitation through the serial link; the servos are asked for the sum (spec 6.4)."""

from __future__ import annotations

from collections.abc import Sequence

from heli_bench_sim.link import DelayLine
from heli_common.topics import SERVO_CHANNELS

STALE_NS = 50_000_000
"""An excitation this much older than what is due has been lost: it counts as zero (D)."""

Command = tuple[float, float, float, float]

_COUNT = len(SERVO_CHANNELS)
_NOTHING = (0.0,) * _COUNT


class Superposition:
    """Takes both streams in and gives what a pulse frame latches.

    In lockstep and in process command and excitation of one frame have one stamp. In real time the newest of
    each counts, and frames go on without an excitation that stays away.

    Args:
        excited: whether there is an excitation at all; without one, frames pass through untouched.
    """

    def __init__(self, excited: bool = False) -> None:
        self._excited = excited
        self._servo, self._excitation = DelayLine(), DelayLine()
        self._asked: Sequence[float] | None = None
        self._added: Sequence[float] = _NOTHING

    def send_command(self, stamp_ns: int, values: Sequence[float]) -> None:
        """Put a servo command on its way: four angles [rad] in front."""
        self._servo.send(stamp_ns, values)

    def send_excitation(self, stamp_ns: int, values: Sequence[float]) -> None:
        """Put an excitation on its way: four angles [rad] in front."""
        self._excitation.send(stamp_ns, values)

    def take(self, due_ns: int, dead_time_ns: int) -> Command | None:
        """What this frame asks of the servos [rad], or None if it repeats the last one.

        Args:
            due_ns: stamp that a command through a link without dead time has at most [ns].
            dead_time_ns: of the link at this instant [ns].
        """
        self._servo.set_dead_time(dead_time_ns)
        self._excitation.set_dead_time(dead_time_ns)
        servo = self._servo.take(due_ns)
        if not self._excited:
            return None if servo is None else (servo[0], servo[1], servo[2], servo[3])
        self._asked = self._asked if servo is None else servo
        excitation = self._excitation.take(due_ns)
        if excitation is not None:
            self._added = excitation
        elif due_ns - dead_time_ns - self._excitation.taken_ns > STALE_NS:
            self._added = _NOTHING
        if self._asked is None:
            return None
        b_1s, a_1s, theta_0, theta_t = (self._asked[place] + self._added[place] for place in range(_COUNT))
        return b_1s, a_1s, theta_0, theta_t
