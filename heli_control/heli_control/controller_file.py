"""The controller file: both axes of a flight controller as discrete state space, read strictly.

YAML, `format: heli_controller/2`. Inputs are deviations of the measured state from the operating point and
absolute references; outputs are deviations of the commands from the operating point. Any linear controller
fits: a static gain has no states. Every axis also says how its states follow when the command that went
out is not the one it asked for:

    asked = C x + D in,   x+ = A x + B in + E (applied - asked)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from heli_common.errors import InputError
from heli_common.files import read_yaml, write_atomically
from heli_common.linear_model import Array, OperatingPoint, StateSpace, fixed_matrix
from heli_common.model_file import (
    check_format,
    check_keys,
    read_mapping,
    read_operating_point,
    read_state_space,
    read_word,
    yaml_text,
)
from heli_common.timing import CONTROL_PERIOD
from heli_common.topics import SERVO_CHANNELS
from heli_control.shipped import find_controller, read_plant, require_plant, shipped

FORMAT = "heli_controller/2"
AXES = ("horizontal", "vertical")
MEASURED = ("theta", "phi", "u", "v", "w", "p", "q", "r")
REFERENCES = ("u_ref", "v_ref", "w_ref", "r_ref")
SIGNALS = MEASURED + REFERENCES
"""What a controller may ask for: angles [rad], velocities [m/s] and rates [rad/s] in body FRD."""


@dataclass(frozen=True, eq=False)
class ControllerAxis:
    """One axis of a flight controller.

    Attributes:
        system: x+ = A x + B in, asked = C x + D in, sampled at 100 Hz; n states, p outputs.
        anti_windup: E, shape (n, p), read-only copy: added to x+ is E (applied - asked), both in rad from
            the operating point.

    Raises:
        InputError: a wrong shape, or a number that is not finite.
    """

    system: StateSpace
    anti_windup: Array

    def __post_init__(self) -> None:
        rows, columns = len(self.system.states), len(self.system.outputs)
        matrix = fixed_matrix(self.anti_windup, rows, columns, "anti_windup")
        object.__setattr__(self, "anti_windup", matrix)

    def mapping(self) -> dict[str, Any]:
        """Names and nested lists, as they stand in a file."""
        return self.system.mapping() | {"anti_windup": self.anti_windup.tolist()}


@dataclass(frozen=True, eq=False)
class ControllerFile:
    """A flight controller and where it comes from.

    Attributes:
        name: of the controller.
        kind: how it was designed, e.g. `lq`.
        plant_name: name of the model it was designed for.
        plant_hash: hash of that model, see `ModelFile`.
        operating_point: trim that is subtracted from the state and added to the commands.
        horizontal: controller of B_1s and A_1s, sampled at 100 Hz.
        vertical: controller of theta_0 and theta_t, sampled at 100 Hz.
        provenance: weights, versions and figures of the design, free.
        sample_time_s: of both axes [s].

    Raises:
        InputError: a signal nobody has, a command that nobody or two axes give, another sample time.
    """

    name: str
    kind: str
    plant_name: str
    plant_hash: str
    operating_point: OperatingPoint
    horizontal: ControllerAxis
    vertical: ControllerAxis
    provenance: Mapping[str, Any] = field(default_factory=dict)
    sample_time_s: float = CONTROL_PERIOD

    def __post_init__(self) -> None:
        if self.sample_time_s != CONTROL_PERIOD:
            raise InputError(f"{self.sample_time_s!r}", allowed=f"{CONTROL_PERIOD}", key="sample_time_s")
        given: list[str] = []
        for axis in AXES:
            block: StateSpace = getattr(self, axis).system
            _check_names(block.inputs, SIGNALS, f"axes.{axis}.inputs")
            _check_names(block.outputs, SERVO_CHANNELS, f"axes.{axis}.outputs")
            for index, name in enumerate(block.outputs):
                if name in given:
                    key = f"axes.{axis}.outputs[{index}]"
                    raise InputError(f"{name!r} occurs twice", allowed="every command once", key=key)
                given.append(name)
        for name in SERVO_CHANNELS:
            if name not in given:
                allowed = "every command once: " + ", ".join(SERVO_CHANNELS)
                raise InputError(f"no axis gives {name!r}", allowed=allowed, key="axes")

    def mapping(self) -> dict[str, Any]:
        """Everything, as it stands in a file: plain numbers, texts, lists and mappings."""
        return {
            "format": FORMAT,
            "name": self.name,
            "kind": self.kind,
            "plant": {"name": self.plant_name, "hash": self.plant_hash},
            "sample_time_s": self.sample_time_s,
            "operating_point": asdict(self.operating_point),
            "axes": {axis: getattr(self, axis).mapping() for axis in AXES},
            "provenance": dict(self.provenance),
        }

    def to_yaml(self) -> str:
        """The text of the file.

        Raises:
            ValueError: `provenance` holds something that YAML cannot.
        """
        return yaml_text(self.mapping())

    def write(self, path: Path) -> None:
        """Write the file; reading gives the same bits."""
        write_atomically(path, self.to_yaml())

    @classmethod
    def read(cls, path: Path) -> ControllerFile:
        """Read a file strictly.

        Raises:
            InputError: missing or corrupt file, unknown or missing key, unknown or doubled signal, wrong
                shape, not a finite number, wrong sample time; names file, key, value and what is allowed.
        """
        return cls.from_mapping(read_yaml(path), path)

    @classmethod
    def from_mapping(cls, document: Mapping[str, Any], path: Path) -> ControllerFile:
        """The controller that a document holds, as `mapping` gives it; `path` is named in errors.

        Raises:
            InputError: as `read`.
        """
        check_format(document, FORMAT, path)
        required = ("format", "name", "kind", "plant", "sample_time_s", "operating_point", "axes")
        check_keys(document, required, ("provenance",), path)
        plant_name, plant_hash = read_plant(document["plant"], path)
        axes = read_mapping(document["axes"], path, "axes")
        check_keys(axes, AXES, (), path, "axes.")
        try:
            return cls(
                name=read_word(document["name"], path, "name"),
                kind=read_word(document["kind"], path, "kind"),
                plant_name=plant_name,
                plant_hash=plant_hash,
                operating_point=read_operating_point(document["operating_point"], path, "operating_point"),
                horizontal=_read_axis(axes["horizontal"], path, "axes.horizontal"),
                vertical=_read_axis(axes["vertical"], path, "axes.vertical"),
                provenance=read_mapping(document.get("provenance", {}), path, "provenance"),
                sample_time_s=document["sample_time_s"],
            )
        except InputError as error:
            raise InputError(error.problem, allowed=error.allowed, file=path, key=error.key) from None


def shipped_controllers() -> dict[str, Path]:
    """Names and files of the flight controllers that come with this package."""
    return shipped(FORMAT)


def load_controller(name_or_path: str, plant: str = "") -> ControllerFile:
    """A controller by the name of a shipped one or by the path of its file; a file goes first.

    Args:
        name_or_path: of the controller.
        plant: hash of the plant that it must be for; empty: any.

    Raises:
        InputError: neither, the file is not a controller file, or it is for another plant.
    """
    path = find_controller(name_or_path, FORMAT)
    controller = ControllerFile.read(path)
    require_plant(path, controller.plant_name, controller.plant_hash, plant)
    return controller


def _read_axis(value: object, path: Path, key: str) -> ControllerAxis:
    block = read_mapping(value, path, key)
    names = [entry.name for entry in fields(StateSpace)]
    check_keys(block, (*names, "anti_windup"), (), path, f"{key}.")
    system = read_state_space({name: block[name] for name in names}, path, key)
    try:
        return ControllerAxis(system, block["anti_windup"])
    except InputError as error:
        raise InputError(error.problem, allowed=error.allowed, key=f"{key}.{error.key}") from None


def _check_names(names: tuple[str, ...], known: tuple[str, ...], key: str) -> None:
    for index, name in enumerate(names):
        if name not in known:
            raise InputError(f"unknown signal {name!r}", allowed=", ".join(known), key=f"{key}[{index}]")
