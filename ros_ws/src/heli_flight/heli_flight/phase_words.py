"""Phases in words: the one mapping each is in a plan file, read and written.

Keys are the names of the settings; the wind's carry their unit, and a step about psi is given in degrees.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from math import degrees, radians
from typing import Any

from heli_common.errors import InputError
from heli_common.quantities import Quantity, about, check_number
from heli_flight.plan_file import controller_at, refuse_unknown
from heli_flight.plan_phases import (
    AXES,
    Excite,
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
from heli_identification.excitation_words import excitation_mapping, read_excitation

_AMPLITUDE = Quantity("m", "D", "size of the step", -0.8, 0.8)
_AMPLITUDE_DEG = Quantity("deg", "D", "size of the step", -180.0, 180.0)
_SMALLEST = {"m": 0.02, "deg": 2.0}
_NUMBERS_ONLY: dict[str, type[NumbersOnly]] = {
    kind.key: kind for kind in (Home, RunUp, TakeOff, Hover, Land, RunDown)
}
_CONTROLLER = "controller"
_WIND_KEYS = {"wind": "wind_m_s", "wind_to": "wind_to_m_s"}


def read_phase(entry: object, file: str | None, place: str) -> Phase:
    """The phase that an entry of a plan describes.

    Args:
        entry: as YAML gives it.
        file: it stands in, for errors.
        place: key it stands under, for errors.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    known = ", ".join((*_NUMBERS_ONLY, Step.key, Excite.key))
    if not isinstance(entry, Mapping) or len(entry) != 1:
        raise InputError(f"{entry!r} is no phase", allowed=f"one of {known}", file=file, key=place)
    ((kind, settings),) = entry.items()
    if kind not in (*_NUMBERS_ONLY, Step.key, Excite.key):
        raise InputError(f"unknown phase {kind!r}", allowed=known, file=file, key=place)
    key = f"{place}.{kind}"
    settings = {} if settings is None else settings
    if not isinstance(settings, Mapping):
        raise InputError(f"{settings!r} is no mapping", allowed="{duration: 5.0}", file=file, key=key)
    if kind == Step.key:
        return _read_step(settings, file, key)
    if kind == Excite.key:
        return _read_excite(settings, file, key)
    cls = _NUMBERS_ONLY[kind]
    quantities = _quantities(cls)
    refuse_unknown(settings, (*quantities, _CONTROLLER), file, key)
    return cls(**_numbers(settings, quantities, file, key), controller=_controller(settings, file, key))


def phase_mapping(phase: Phase) -> dict[str, object]:
    """A phase as the entry of a plan; `read_phase` gives an equal one back.

    Args:
        phase: of any kind.
    """
    settings = dataclasses.asdict(phase)
    controller = settings.pop(_CONTROLLER)
    if isinstance(phase, Excite):
        settings = excitation_mapping(phase.excitation) | {k: settings[k] for k in _WIND_KEYS}
    wind = {key: settings.pop(name) for name, key in _WIND_KEYS.items() if name in settings}
    if isinstance(phase, Step) and phase.axis == "psi":
        exact = degrees(phase.amplitude)
        short = round(exact, 9)
        amplitude = short if radians(short) == phase.amplitude else exact
        settings = {"axis": "psi", "amplitude_deg": amplitude, "duration": phase.duration}
    settings |= {key: speed for key, speed in wind.items() if speed is not None}
    return {phase.key: settings | ({_CONTROLLER: controller} if controller is not None else {})}


def _quantities(cls: type[Phase]) -> dict[str, tuple[str, Quantity]]:
    """Field and quantity of each number of a phase by its key in a file, those of the wind at the end."""
    fields = [field for field in dataclasses.fields(cls) if "quantity" in field.metadata]
    fields.sort(key=lambda field: field.name in _WIND_KEYS)
    return {_WIND_KEYS.get(field.name, field.name): (field.name, about(field)) for field in fields}


def _numbers(
    settings: Mapping[str, object],
    quantities: Mapping[str, tuple[str, Quantity]],
    file: str | None,
    key: str,
) -> dict[str, Any]:
    """The numbers given, by field."""
    return {
        field: check_number(settings[name], known, file=file, key=f"{key}.{name}")
        for name, (field, known) in quantities.items()
        if name in settings
    }


def _read_excite(settings: Mapping[str, object], file: str | None, key: str) -> Excite:
    wind = {name: field for name, field in _quantities(Excite).items() if name in settings}
    own = {name: value for name, value in settings.items() if name not in (*wind, _CONTROLLER)}
    numbers = _numbers(settings, wind, file, key)
    excitation = read_excitation(own, file=file, key=key)
    return Excite(excitation, **numbers, controller=_controller(settings, file, key))


def _read_step(settings: Mapping[str, object], file: str | None, key: str) -> Step:
    axis = settings.get("axis")
    if axis not in AXES:
        raise InputError(f"{axis!r} is no axis", allowed=", ".join(AXES), file=file, key=f"{key}.axis")
    name, size = ("amplitude_deg", _AMPLITUDE_DEG) if axis == "psi" else ("amplitude", _AMPLITUDE)
    quantities = _quantities(Step)
    refuse_unknown(settings, ("axis", name, *quantities, _CONTROLLER), file, key)
    amplitude = check_number(settings.get(name), size, file=file, key=f"{key}.{name}")
    smallest = _SMALLEST[size.unit]
    if abs(amplitude) < smallest:
        allowed = f"at least {smallest:g} {size.unit} in size"
        raise InputError(f"{amplitude!r} is too small", allowed=allowed, file=file, key=f"{key}.{name}")
    amplitude = radians(amplitude) if axis == "psi" else amplitude
    numbers = _numbers(settings, quantities, file, key)
    return Step(str(axis), amplitude, **numbers, controller=_controller(settings, file, key))


def _controller(settings: Mapping[str, object], file: str | None, key: str) -> str | None:
    """The controller named, if any."""
    return controller_at(settings, file, f"{key}.") if _CONTROLLER in settings else None
