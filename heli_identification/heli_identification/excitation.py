"""An excitation: which signal, on which channels, how large and how long; and its samples.

Channels B_1s, A_1s, theta_0 and theta_t are added to the servo command; u, v, w and r (ahead, right, down,
yaw rate) to the velocity reference; motor to the control voltage. The samples are a pure function of the
excitation and of their number.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.random import default_rng
from numpy.typing import NDArray

from heli_common.timing import CONTROL_PERIOD
from heli_common.topics import SERVO_CHANNELS
from heli_identification import excitation_signals as signals

COMMAND_CHANNELS = SERVO_CHANNELS
REFERENCE_CHANNELS = ("u", "v", "w", "r")
MOTOR_CHANNEL = "motor"
CHANNELS = (*COMMAND_CHANNELS, *REFERENCE_CHANNELS, MOTOR_CHANNEL)

HELD = (*signals.PATTERNS, "ramps")
"""Signals with a hold time."""

BANDED = ("chirp", "prbs", "noise", "multisine")
"""Signals with a band."""

TOGETHER = ("prbs", "noise", "multisine")
"""Signals for several channels at once: the others would do the same on each and could not be told apart."""

SIGNALS = (*HELD, *BANDED)


@dataclass(frozen=True, kw_only=True)
class Excitation:
    """One excitation; `excitation_words` reads and checks it.

    Attributes:
        signal: one of `SIGNALS`.
        channels: of `CHANNELS`, each once.
        amplitude: peak [rad], [m/s], [rad/s] or [V], as the channels have it.
        duration: with fading in and out [s].
        band: lowest and highest angular frequency [rad/s], of the signals in `BANDED`.
        hold: of the signals in `HELD` [s].
        fade: time of fading in, and of fading out [s].
        seed: of the random signals; each channel draws from a stream of its own.
    """

    signal: str
    channels: tuple[str, ...]
    amplitude: float
    duration: float
    band: tuple[float, float] | None = None
    hold: float | None = None
    fade: float = 1.0
    seed: int = 1

    @property
    def count(self) -> int:
        """Samples of the control grid."""
        return round(self.duration / CONTROL_PERIOD)


@lru_cache(maxsize=32)
def samples(excitation: Excitation) -> NDArray[np.float64]:
    """Every sample of an excitation, never larger than its amplitude; read-only.

    Returns:
        (count, 9) in the order of `CHANNELS` [rad], [m/s], [rad/s] and [V].
    """
    table = np.zeros((excitation.count, len(CHANNELS)))
    window = excitation.amplitude * signals.fade(excitation.count, round(excitation.fade / CONTROL_PERIOD))
    for place, channel in enumerate(excitation.channels):
        table[:, CHANNELS.index(channel)] = window * _unit(excitation, place)
    table.setflags(write=False)
    return table


def _unit(excitation: Excitation, place: int) -> NDArray[np.float64]:
    """The signal of one channel with peak 1, without fading."""
    count = excitation.count
    if excitation.hold is not None:
        hold = max(1, round(excitation.hold / CONTROL_PERIOD))
        if excitation.signal == "ramps":
            return signals.ramps(count, hold)
        return signals.pattern(signals.PATTERNS[excitation.signal], count, hold)
    if excitation.band is None:
        raise ValueError(f"{excitation.signal} has neither band nor hold")
    if excitation.signal == "chirp":
        return signals.chirp(count, excitation.band)
    if excitation.signal == "multisine":
        rng = default_rng(excitation.seed)
        return signals.multisine(count, excitation.band, rng, place, len(excitation.channels))
    rng = default_rng([excitation.seed, place])
    if excitation.signal == "prbs":
        return signals.prbs(count, excitation.band, rng)
    return signals.noise(count, excitation.band, rng)
