"""The phases a flight plan is made of: what each is, its settings and their ranges, the wind in each."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

from heli_common.quantities import Quantity, quantity
from heli_identification.excitation import Excitation

MINIMUM_HEIGHT, MAXIMUM_HEIGHT = -0.40, 0.30
"""Between which heights a reference may be [m]; the lower stop is at -0.45 m."""

AXES = ("x", "y", "z", "psi")

STRONGEST_WIND = 8.0
"""Largest speed that can be asked of the fan [m/s] (spec 2.7)."""

WIND = Quantity("m/s", "D", "speed asked of the fan", 0.0, STRONGEST_WIND)


def _duration(default: float, longest: float = 60.0) -> Any:
    return quantity(default, "s", "D", "duration of the phase", 0.5, longest)


def _speed(default: float) -> Any:
    return quantity(default, "m/s", "D", "vertical speed", 0.02, 0.5)


def _wind(text: str) -> Any:
    about = Quantity("m/s", "D", text, 0.0, STRONGEST_WIND)
    return field(default=None, metadata={"quantity": about})


@dataclass(frozen=True, kw_only=True)
class _Windy:
    """What every phase may say of the fan; it blows on as before where nothing is said."""

    key: ClassVar[str]
    wind: float | None = _wind("speed asked of the fan from the start of the phase on")


@dataclass(frozen=True, kw_only=True)
class _Timed(_Windy):
    """A phase of a given duration, over which the fan's speed may change steadily."""

    wind_to: float | None = _wind("speed asked of the fan at the end, reached steadily")


@dataclass(frozen=True)
class Home(_Timed):
    """A hand moves the helicopter so that every encoder crosses its index [s]."""

    key: ClassVar[str] = "home"
    duration: float = _duration(8.0)


@dataclass(frozen=True)
class RunUp(_Timed):
    """The rotor is brought to its speed [s]."""

    key: ClassVar[str] = "run_up"
    duration: float = _duration(6.0)


@dataclass(frozen=True)
class TakeOff(_Windy):
    """From the stop to a height [m] at a vertical speed [m/s]."""

    key: ClassVar[str] = "take_off"
    height: float = quantity(
        0.0, "m", "D", "of the platform above the centre of the flight space", MINIMUM_HEIGHT, MAXIMUM_HEIGHT
    )
    speed: float = _speed(0.15)


@dataclass(frozen=True)
class Hover(_Timed):
    """The reference stays where it is [s]."""

    key: ClassVar[str] = "hover"
    duration: float = _duration(10.0, 3600.0)


@dataclass(frozen=True)
class Step(_Timed):
    """The reference jumps along one axis, then stays [m or rad, s]."""

    key: ClassVar[str] = "step"
    axis: str
    amplitude: float
    duration: float = _duration(6.0, 600.0)


@dataclass(frozen=True)
class Land(_Windy):
    """Down to the stop at a vertical speed [m/s]."""

    key: ClassVar[str] = "land"
    speed: float = _speed(0.12)


@dataclass(frozen=True)
class RunDown(_Timed):
    """The rotor comes to rest [s]."""

    key: ClassVar[str] = "run_down"
    duration: float = _duration(3.0)


@dataclass(frozen=True)
class Excite(_Timed):
    """The reference stays where it is while an excitation acts."""

    key: ClassVar[str] = "excite"
    excitation: Excitation

    @property
    def duration(self) -> float:
        """Duration of the excitation [s]."""
        return self.excitation.duration


NumbersOnly = Home | RunUp | TakeOff | Hover | Land | RunDown
Phase = NumbersOnly | Step | Excite


def commands_wind(phase: Phase) -> bool:
    """Whether a phase asks for any wind; one that does not leaves the fan as it is."""
    return phase.wind is not None or (not isinstance(phase, TakeOff | Land) and phase.wind_to is not None)


def wind_command(phase: Phase, time: float, before: float) -> float:
    """Speed that a phase asks of the fan [m/s].

    Args:
        phase: being flown.
        time: since it began [s]; anything after its duration, infinity included, gives what it leaves behind.
        before: speed asked for when it began [m/s].
    """
    start = before if phase.wind is None else phase.wind
    if isinstance(phase, TakeOff | Land) or phase.wind_to is None:
        return start
    if time >= phase.duration:
        return phase.wind_to
    return start + time / phase.duration * (phase.wind_to - start)
