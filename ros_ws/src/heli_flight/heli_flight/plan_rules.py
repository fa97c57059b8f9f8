"""What makes a list of phases a flight: order, a reference inside the work space, faults while it lasts."""

from __future__ import annotations

from math import degrees, hypot, radians

from heli_bench_sim.faults import Fault
from heli_common.errors import InputError
from heli_flight.plan_phases import AXES, MAXIMUM_HEIGHT, MINIMUM_HEIGHT, Phase, Step, TakeOff

MAXIMUM_RADIUS = 0.45
"""How far a reference may be from the vertical axis [m]; the work space ends at 0.50 m (spec 2.1)."""

MAXIMUM_HEADING = radians(120.0)
"""How far a reference may turn from the heading at take-off [rad]; the yaw stop is at 170 deg."""

_MARGIN = 1e-9
_ONCE = ("home", "run_up", "take_off", "land", "run_down")


def check_order(phases: tuple[Phase, ...], file: str | None) -> None:
    """Refuse phases that are missing, occur twice or stand out of order.

    Raises:
        InputError: names the first such phase.
    """
    keys = [phase.key for phase in phases]
    for key in _ONCE:
        if keys.count(key) != 1:
            problem = f"{key} is missing" if key not in keys else f"{key} occurs {keys.count(key)} times"
            raise InputError(problem, allowed=f"each of {', '.join(_ONCE)} once", file=file, key="phases")
    expected = ["home", "run_up", "take_off", *keys[3:-2], "land", "run_down"]
    for index, (key, wanted) in enumerate(zip(keys, expected, strict=True)):
        if key != wanted or (3 <= index < len(keys) - 2 and key in _ONCE):
            allowed = "home, run_up, take_off, then hover, step and excite, then land, run_down"
            raise InputError(f"{key} stands out of order", allowed=allowed, file=file, key=f"phases[{index}]")


def check_work_space(phases: tuple[Phase, ...], file: str | None) -> None:
    """Refuse steps that take the reference out of the work space.

    Raises:
        InputError: names the first such step.
    """
    place = dict.fromkeys(AXES, 0.0)
    for index, phase in enumerate(phases):
        if isinstance(phase, TakeOff):
            place["z"] = -phase.height
        if not isinstance(phase, Step):
            continue
        place[phase.axis] += phase.amplitude
        key = f"phases[{index}].step"
        if phase.axis == "psi":
            outside = abs(place["psi"]) > MAXIMUM_HEADING + _MARGIN
            here = f"a heading of {degrees(place['psi']):.1f} deg"
            allowed = f"a heading within {degrees(MAXIMUM_HEADING):.0f} deg"
        elif phase.axis == "z":
            height = -place["z"]
            outside = not MINIMUM_HEIGHT - _MARGIN <= height <= MAXIMUM_HEIGHT + _MARGIN
            here = f"height {height:.2f} m"
            allowed = f"a height of {MINIMUM_HEIGHT:.2f} .. {MAXIMUM_HEIGHT:.2f} m"
        else:
            radius = hypot(place["x"], place["y"])
            outside = radius > MAXIMUM_RADIUS + _MARGIN
            here, allowed = f"{radius:.2f} m from the axis", f"at most {MAXIMUM_RADIUS:.2f} m"
        if outside:
            raise InputError(f"takes the reference to {here}", allowed=allowed, file=file, key=key)


def check_faults(faults: tuple[Fault, ...], duration: float, file: str | None) -> None:
    """Refuse faults that would begin when the flight is over.

    Args:
        faults: in the order of the file.
        duration: estimate of the flight's duration [s].
        file: named in errors.

    Raises:
        InputError: names the first such fault.
    """
    for index, fault in enumerate(faults):
        start = fault.start_ns / 1e9
        if start >= duration:
            allowed = f"below {duration:.1f} s, the duration of the plan"
            key = f"faults[{index}].at_s"
            raise InputError(f"{start:g} is after the flight", allowed=allowed, file=file, key=key)
