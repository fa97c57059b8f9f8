"""A flight plan: what is flown, in a YAML file of phases, checked before anything moves.

```yaml
name: hover_steps
about: one sentence
seed: 1
controller: lq              # a shipped controller or a path
phases:
  - home: {}
  - run_up: {}
  - take_off: {height: 0.0, speed: 0.15}
  - hover: {duration: 10.0}
  - step: {axis: x, amplitude: 0.30, duration: 6.0}
  - step: {axis: psi, amplitude_deg: 20.0, duration: 6.0}
  - land: {}
  - run_down: {}
```

Axes are those of the thesis: x ahead (north), y right (east), z down, psi about z. Steps are relative to the
reference before them. Heights are of the platform, above the centre of the flight space.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, radians
from pathlib import Path

import yaml

from heli_common.errors import InputError
from heli_common.quantities import Quantity, about, check_number
from heli_flight.bag_metadata import dump_yaml
from heli_flight.plan_file import integer_at, read_mapping, read_text, refuse_unknown, text_at
from heli_flight.plan_phases import (
    AXES,
    Home,
    Hover,
    Land,
    NumbersOnly,
    Phase,
    RunDown,
    RunUp,
    Step,
    TakeOff,
)
from heli_flight.plan_rules import check_order, check_work_space

__all__ = [
    "Home",
    "Hover",
    "Land",
    "Phase",
    "Plan",
    "RunDown",
    "RunUp",
    "Step",
    "TakeOff",
    "load_plan",
    "parse_plan",
    "shipped_plans",
]

PLAN_FOLDER = Path(__file__).parent / "plans"

STOP_HEIGHT = -0.45
SETTLING_TIME = 3.0
"""What taking up the load and settling add to a take-off, in an estimate of the duration [s]."""

_AMPLITUDE = Quantity("m", "D", "size of the step", -0.8, 0.8)
_AMPLITUDE_DEG = Quantity("deg", "D", "size of the step", -180.0, 180.0)
_SMALLEST = {"m": 0.02, "deg": 2.0}
_NUMBERS_ONLY: dict[str, type[NumbersOnly]] = {
    kind.key: kind for kind in (Home, RunUp, TakeOff, Hover, Land, RunDown)
}


@dataclass(frozen=True)
class Plan:
    """A checked plan.

    Attributes:
        name: of the flight, part of file names.
        about: one sentence for people.
        seed: of all random numbers.
        controller: name of a shipped controller, or a path.
        phases: in the order of flying.
    """

    name: str
    about: str
    seed: int
    controller: str
    phases: tuple[Phase, ...]

    @property
    def duration(self) -> float:
        """Estimate of the flight's duration [s]; take-off and landing take what they need."""
        total, height = 0.0, STOP_HEIGHT
        for phase in self.phases:
            if isinstance(phase, TakeOff):
                total += (phase.height - height) / phase.speed + SETTLING_TIME
                height = phase.height
            elif isinstance(phase, Land):
                total += (height - STOP_HEIGHT) / phase.speed
            else:
                total += phase.duration
                if isinstance(phase, Step) and phase.axis == "z":
                    height -= phase.amplitude
        return total

    def to_yaml(self) -> str:
        """The plan as a file that reads back to an equal plan."""
        head = {"name": self.name, "about": self.about, "seed": self.seed, "controller": self.controller}
        phases = [{phase.key: _settings(phase)} for phase in self.phases]
        lines = [yaml.safe_dump(phase, default_flow_style=None, sort_keys=False) for phase in phases]
        return dump_yaml(head) + "phases:\n" + "".join(f"  - {line}" for line in lines)


def shipped_plans() -> dict[str, Path]:
    """The plans that come with this package, by name."""
    return {path.stem: path for path in sorted(PLAN_FOLDER.glob("*.yaml"))}


def load_plan(name_or_path: str | Path) -> Plan:
    """A shipped plan by its name, or any plan by its path.

    Raises:
        InputError: no such plan, or something in it is wrong.
    """
    shipped, given = shipped_plans(), str(name_or_path)
    path = shipped.get(given, Path(given))
    if given not in shipped and not path.is_file():
        problem = "no such file" if path.suffix in (".yaml", ".yml") or path.parent != Path() else "unknown"
        raise InputError(f"plan {given!r}: {problem}", allowed=f"a path, or one of {', '.join(shipped)}")
    return parse_plan(read_text(path), str(path))


def parse_plan(text: str, file: str | None = None) -> Plan:
    """A plan from the text of its file.

    Args:
        text: YAML.
        file: named in errors.

    Raises:
        InputError: names the file, the key, the value and what is allowed.
    """
    document = read_mapping(text, file)
    refuse_unknown(document, [field.name for field in dataclasses.fields(Plan)], file, "")
    name = text_at(document, "name", file)
    if not re.fullmatch(r"[A-Za-z0-9_-]{1,60}", name):
        allowed = "up to 60 letters, digits, _ and -"
        raise InputError(f"{name!r} is no name", allowed=allowed, file=file, key="name")
    seed = integer_at(document, "seed", 0, 2**32 - 1, file)
    about_it, controller = text_at(document, "about", file), text_at(document, "controller", file)
    entries = document.get("phases")
    if not isinstance(entries, list) or not entries:
        raise InputError(f"{entries!r} is no list of phases", allowed="- home: {}", file=file, key="phases")
    phases = tuple(_phase(entry, file, f"phases[{index}]") for index, entry in enumerate(entries))
    check_order(phases, file)
    check_work_space(phases, file)
    return Plan(name, about_it, seed, controller, phases)


def _phase(entry: object, file: str | None, place: str) -> Phase:
    known = ", ".join((*_NUMBERS_ONLY, Step.key))
    if not isinstance(entry, Mapping) or len(entry) != 1:
        raise InputError(f"{entry!r} is no phase", allowed=f"one of {known}", file=file, key=place)
    ((kind, settings),) = entry.items()
    if kind not in (*_NUMBERS_ONLY, Step.key):
        raise InputError(f"unknown phase {kind!r}", allowed=known, file=file, key=place)
    key = f"{place}.{kind}"
    settings = {} if settings is None else settings
    if not isinstance(settings, Mapping):
        raise InputError(f"{settings!r} is no mapping", allowed="{duration: 5.0}", file=file, key=key)
    if kind == Step.key:
        return _step(settings, file, key)
    cls = _NUMBERS_ONLY[kind]
    fields = {field.name: field for field in dataclasses.fields(cls)}
    refuse_unknown(settings, fields, file, key)
    numbers = {
        name: check_number(value, about(fields[name]), file=file, key=f"{key}.{name}")
        for name, value in settings.items()
    }
    return cls(**numbers)


def _step(settings: Mapping[str, object], file: str | None, key: str) -> Step:
    axis = settings.get("axis")
    if axis not in AXES:
        raise InputError(f"{axis!r} is no axis", allowed=", ".join(AXES), file=file, key=f"{key}.axis")
    name, size = ("amplitude_deg", _AMPLITUDE_DEG) if axis == "psi" else ("amplitude", _AMPLITUDE)
    refuse_unknown(settings, ("axis", name, "duration"), file, key)
    amplitude = check_number(settings.get(name), size, file=file, key=f"{key}.{name}")
    smallest = _SMALLEST[size.unit]
    if abs(amplitude) < smallest:
        allowed = f"at least {smallest:g} {size.unit} in size"
        raise InputError(f"{amplitude!r} is too small", allowed=allowed, file=file, key=f"{key}.{name}")
    limits = about(Step.__dataclass_fields__["duration"])
    given = settings.get("duration", Step.duration)
    duration = check_number(given, limits, file=file, key=f"{key}.duration")
    return Step(str(axis), radians(amplitude) if axis == "psi" else amplitude, duration)


def _settings(phase: Phase) -> dict[str, object]:
    """A phase as the mapping in its file."""
    settings: dict[str, object] = dataclasses.asdict(phase)
    if isinstance(phase, Step) and phase.axis == "psi":
        exact = degrees(phase.amplitude)
        short = round(exact, 9)
        amplitude = short if radians(short) == phase.amplitude else exact
        return {"axis": "psi", "amplitude_deg": amplitude, "duration": phase.duration}
    return settings
