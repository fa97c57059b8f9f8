"""Where a replay stands: simulated time that runs with the wall clock at a rate, can rest and be changed."""

from __future__ import annotations

from math import inf

from heli_common.errors import InputError

MINIMUM_RATE, MAXIMUM_RATE = 0.01, 100.0


class Playback:
    """Simulated time of a replay. All wall times are readings [s] of one clock that the caller reads.

    Args:
        start_ns: simulated time at which it begins [ns].
        rate: simulated seconds per second.
        paused: whether it waits for `resume`.

    Raises:
        InputError: a rate out of range.
    """

    def __init__(self, start_ns: int, rate: float = 1.0, paused: bool = False) -> None:
        self._rate = check_rate(rate)
        self._from_ns = float(start_ns)
        self._since: float | None = None
        self._paused = paused

    @property
    def paused(self) -> bool:
        """Whether time rests."""
        return self._paused

    @property
    def rate(self) -> float:
        """Simulated seconds per second."""
        return self._rate

    def begin(self, now: float) -> None:
        """Let time run from now on, unless it is paused; a second call does nothing."""
        if self._since is None:
            self._since = now

    def position_ns(self, now: float) -> float:
        """Simulated time [ns]."""
        if self._paused or self._since is None:
            return self._from_ns
        return self._from_ns + (now - self._since) * self._rate * 1e9

    def pause(self, now: float) -> None:
        """Let time rest."""
        self._from_ns = self.position_ns(now)
        self._paused = True

    def resume(self, now: float) -> None:
        """Go on from where time rests."""
        if self._paused:
            self._paused = False
            self._since = now if self._since is not None else None

    def set_rate(self, rate: float, now: float) -> None:
        """Go on faster or slower from here.

        Raises:
            InputError: the rate is out of range.
        """
        checked = check_rate(rate)
        self._from_ns = self.position_ns(now)
        self._since = now if self._since is not None else None
        self._rate = checked

    def skip_to(self, stamp_ns: int, now: float) -> None:
        """Go on from another simulated time [ns]."""
        self._from_ns = float(stamp_ns)
        self._since = now if self._since is not None else None

    def wait(self, stamp_ns: int, now: float) -> float:
        """Wall time until a stamp is due [s]; 0 or less if it is, infinite while time does not run."""
        if self._paused or self._since is None:
            return inf
        return max(0.0, stamp_ns - self.position_ns(now)) * 1e-9 / self._rate


def check_rate(rate: object) -> float:
    """A rate that is allowed.

    Raises:
        InputError: it is not.
    """
    if (
        isinstance(rate, bool)
        or not isinstance(rate, (int, float))
        or not MINIMUM_RATE <= rate <= MAXIMUM_RATE
    ):
        raise InputError(f"{rate!r} is refused", allowed=f"{MINIMUM_RATE:g} .. {MAXIMUM_RATE:g}", key="rate")
    return float(rate)
