"""The vary file of a campaign: what is drawn anew for every flight, and what is gone through on a grid.

```yaml
seed: 1                                         # of the campaign; default 1
controller: {choice: [lq, ncf2]}
room: {choice: [still, gusty]}
wind_m_s: {uniform: [0.0, 3.0]}                 # asked of the fan from the first phase after the take-off on
parameters:
  bench_sim:
    helicopter.mass: {normal: [1.0, 0.03], times_default: true}
    imu.gyro_noise: {log_uniform: [0.5, 4.0], times_default: true}
  position_controller:
    gain_x: {uniform: [1.5, 2.5]}
faults:                                         # as in a plan, with the probability of each
  - {kind: imu_dropout, at_s: 16.0, for_s: 0.2, probability: 0.1}
grid:                                           # every combination is flown with the same draws
  wind_m_s: [0.0, 2.0, 4.0]
  controller: [lq, ncf2]
success: {max_xy_m: 0.30}                       # beside being flown to the end without touching the stop
```

Everything may be left out. A normal number beyond what its parameter allows is set to the end of its range.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from heli_bench_sim.fault_words import read_fault
from heli_bench_sim.faults import Fault
from heli_common.errors import InputError
from heli_common.quantities import Quantity, about, check_number
from heli_control.controller_file import load_controller
from heli_flight.distributions import Choice, Distribution, read_choice, read_distribution
from heli_flight.parameter_file import NODE_PARAMETERS
from heli_flight.plan import ROOMS
from heli_flight.plan_file import integer_at, read_mapping, read_text, refuse_unknown
from heli_flight.plan_phases import WIND

CONTROLLER, ROOM, WIND_KEY = "controller", "room", "wind_m_s"
_LARGEST_SEED = 2**31 - 1
_PROBABILITY = Quantity("", "D", "of the fault", 0.0, 1.0)
_LIMIT = Quantity("m", "D", "largest distance from the reference in the plane", 0.001, 10.0)
_MOST_VALUES = 100


@dataclass(frozen=True)
class Known:
    """A parameter that may vary: its node, name, range and default."""

    node: str
    name: str
    quantity: Quantity
    default: float

    @property
    def column(self) -> str:
        """Name in results."""
        return f"{self.node}.{self.name}"


def known_parameters() -> dict[str, Known]:
    """Every parameter of every node, by `node.name`."""
    found = {}
    for node, groups in NODE_PARAMETERS.items():
        for prefix, group in groups:
            for entry in fields(group):
                known = Known(node, f"{prefix}{entry.name}", about(entry), float(getattr(group, entry.name)))
                found[known.column] = known
    return found


@dataclass(frozen=True)
class Vary:
    """A checked vary file.

    Attributes:
        seed: of the campaign.
        choices: of controller and room, by name.
        numbers: of wind and parameters, by name, in the order of the file.
        faults: with the probability of each.
        grid: values of each name gone through.
        max_xy: largest distance in the plane of a success [m].
    """

    seed: int = 1
    choices: Mapping[str, Choice] = field(default_factory=dict)
    numbers: Mapping[str, Distribution] = field(default_factory=dict)
    faults: tuple[tuple[Fault, float], ...] = ()
    grid: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    max_xy: float = math.inf

    @property
    def cells(self) -> int:
        """How many combinations the grid has; 1 without a grid."""
        return math.prod(len(values) for values in self.grid.values())

    @property
    def controllers(self) -> tuple[str, ...]:
        """Every controller that may fly beside the plan's."""
        chosen = self.choices[CONTROLLER].values if CONTROLLER in self.choices else ()
        return tuple(str(name) for name in (*chosen, *self.grid.get(CONTROLLER, ())))

    @property
    def names(self) -> tuple[str, ...]:
        """Every name that varies, the grid's first."""
        return tuple(dict.fromkeys((*self.grid, *self.choices, *self.numbers)))


def read_vary(path: Path) -> Vary:
    """A vary file.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    return parse_vary(read_text(path), str(path))


def parse_vary(text: str, file: str | None = None) -> Vary:
    """A vary file from its text; `file` is named in errors.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    document = read_mapping(text, file)
    keys = ("seed", CONTROLLER, ROOM, WIND_KEY, "parameters", "faults", "grid", "success")
    refuse_unknown(document, keys, file, "")
    seed = integer_at({"seed": 1} | document, "seed", 0, _LARGEST_SEED, file)
    choices: dict[str, Choice] = {}
    numbers: dict[str, Distribution] = {}
    if CONTROLLER in document:
        choices[CONTROLLER] = read_choice(document[CONTROLLER], file, CONTROLLER)
        _check_words(CONTROLLER, choices[CONTROLLER].values, file, f"{CONTROLLER}.choice")
    if ROOM in document:
        choices[ROOM] = read_choice(document[ROOM], file, ROOM)
        _check_words(ROOM, choices[ROOM].values, file, f"{ROOM}.choice")
    if WIND_KEY in document:
        numbers[WIND_KEY] = read_distribution(document[WIND_KEY], WIND, 0.0, file, WIND_KEY)
    parameters = known_parameters()
    for node, entries in _mapping(document, "parameters", file).items():
        refuse_unknown({node: None}, NODE_PARAMETERS, file, "parameters")
        place = f"parameters.{node}"
        for name, entry in _mapping({place: entries}, place, file).items():
            known = _parameter(parameters, f"{node}.{name}", file, f"{place}.{name}")
            numbers[known.column] = read_distribution(
                entry, known.quantity, known.default, file, f"{place}.{name}"
            )
    grid = _read_grid(_mapping(document, "grid", file), parameters, file)
    for name in grid:
        if name in choices or name in numbers:
            raise InputError("is drawn, too", allowed="one of both", file=file, key=f"grid.{name}")
    success = _mapping(document, "success", file)
    refuse_unknown(success, ("max_xy_m",), file, "success")
    limit = success.get("max_xy_m", math.inf)
    if "max_xy_m" in success:
        limit = check_number(limit, _LIMIT, file=file, key="success.max_xy_m")
    return Vary(seed, choices, numbers, _read_faults(document.get("faults", []), file), grid, limit)


def _mapping(document: Mapping[str, Any], key: str, file: str | None) -> Mapping[str, Any]:
    value = document.get(key, {})
    if not isinstance(value, Mapping):
        raise InputError(f"{value!r} is no mapping", allowed="name: {...}", file=file, key=key)
    return value


def _parameter(parameters: Mapping[str, Known], name: str, file: str | None, key: str) -> Known:
    if name not in parameters:
        node = name.partition(".")[0]
        some = [known.name for known in parameters.values() if known.node == node][:4]
        allowed = f"for example {', '.join(some)}; heli parameters prints all"
        raise InputError("unknown parameter", allowed=allowed, file=file, key=key)
    return parameters[name]


def _check_words(name: str, values: tuple[Any, ...], file: str | None, key: str) -> None:
    for index, value in enumerate(values):
        place = f"{key}[{index}]"
        if not isinstance(value, str):
            raise InputError(f"{value!r} is no name", allowed="a name", file=file, key=place)
        if name == ROOM and value not in ROOMS:
            raise InputError(f"{value!r} is no room", allowed=", ".join(ROOMS), file=file, key=place)
        if name == CONTROLLER:
            try:
                load_controller(value)
            except InputError as error:
                raise InputError(error.problem, allowed=error.allowed, file=file, key=place) from None


def _read_grid(
    entries: Mapping[str, Any], parameters: Mapping[str, Known], file: str | None
) -> dict[str, tuple[Any, ...]]:
    grid: dict[str, tuple[Any, ...]] = {}
    for name, values in entries.items():
        key = f"grid.{name}"
        if not isinstance(values, list) or not 1 <= len(values) <= _MOST_VALUES:
            allowed = f"a list of 1 .. {_MOST_VALUES} values"
            raise InputError(f"{values!r} is no list of values", allowed=allowed, file=file, key=key)
        if name in (CONTROLLER, ROOM):
            _check_words(name, tuple(values), file, key)
            grid[name] = tuple(values)
            continue
        quantity = WIND if name == WIND_KEY else _parameter(parameters, name, file, key).quantity
        grid[name] = tuple(
            check_number(value, quantity, file=file, key=f"{key}[{index}]")
            for index, value in enumerate(values)
        )
    return grid


def _read_faults(entries: object, file: str | None) -> tuple[tuple[Fault, float], ...]:
    if not isinstance(entries, list):
        allowed = "- {kind: imu_dropout, at_s: 16.0, for_s: 0.2, probability: 0.1}"
        raise InputError(f"{entries!r} is no list of faults", allowed=allowed, file=file, key="faults")
    found = []
    for index, entry in enumerate(entries):
        key = f"faults[{index}]"
        settings = dict(entry) if isinstance(entry, Mapping) else entry
        share = settings.pop("probability", 1.0) if isinstance(settings, dict) else 1.0
        probability = check_number(share, _PROBABILITY, file=file, key=f"{key}.probability")
        found.append((read_fault(settings, file=file, key=key), probability))
    return tuple(found)
