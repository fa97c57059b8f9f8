"""The phases a flight plan is made of: what each is, its settings and their ranges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from heli_common.quantities import quantity

MINIMUM_HEIGHT, MAXIMUM_HEIGHT = -0.40, 0.30
"""Between which heights a reference may be [m]; the lower stop is at -0.45 m."""

AXES = ("x", "y", "z", "psi")


def _duration(default: float, longest: float = 60.0) -> Any:
    return quantity(default, "s", "D", "duration of the phase", 0.5, longest)


def _speed(default: float) -> Any:
    return quantity(default, "m/s", "D", "vertical speed", 0.02, 0.5)


@dataclass(frozen=True)
class Home:
    """A hand moves the helicopter so that every encoder crosses its index [s]."""

    key: ClassVar[str] = "home"
    duration: float = _duration(8.0)


@dataclass(frozen=True)
class RunUp:
    """The rotor is brought to its speed [s]."""

    key: ClassVar[str] = "run_up"
    duration: float = _duration(6.0)


@dataclass(frozen=True)
class TakeOff:
    """From the stop to a height [m] at a vertical speed [m/s]."""

    key: ClassVar[str] = "take_off"
    height: float = quantity(
        0.0, "m", "D", "of the platform above the centre of the flight space", MINIMUM_HEIGHT, MAXIMUM_HEIGHT
    )
    speed: float = _speed(0.15)


@dataclass(frozen=True)
class Hover:
    """The reference stays where it is [s]."""

    key: ClassVar[str] = "hover"
    duration: float = _duration(10.0, 3600.0)


@dataclass(frozen=True)
class Step:
    """The reference jumps along one axis, then stays [m or rad, s]."""

    key: ClassVar[str] = "step"
    axis: str
    amplitude: float
    duration: float = _duration(6.0, 600.0)


@dataclass(frozen=True)
class Land:
    """Down to the stop at a vertical speed [m/s]."""

    key: ClassVar[str] = "land"
    speed: float = _speed(0.12)


@dataclass(frozen=True)
class RunDown:
    """The rotor comes to rest [s]."""

    key: ClassVar[str] = "run_down"
    duration: float = _duration(3.0)


NumbersOnly = Home | RunUp | TakeOff | Hover | Land | RunDown
Phase = NumbersOnly | Step
