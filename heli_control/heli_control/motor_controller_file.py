"""The motor controller's file: gains and drive data of the speed governor, read strictly.

YAML, `format: heli_motor/1`: name, kind, plant (name and hash, if designed for a model), sample_time_s,
every number of `MotorParameters` by its name, provenance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from heli_common.errors import InputError
from heli_common.files import read_yaml, write_atomically
from heli_common.model_file import check_format, check_keys, read_mapping, read_word, yaml_text
from heli_common.quantities import from_mapping
from heli_common.timing import CONTROL_PERIOD
from heli_control.motor_control import MotorParameters
from heli_control.shipped import find_controller, read_plant, require_plant

FORMAT = "heli_motor/1"
_NUMBERS = tuple(entry.name for entry in fields(MotorParameters))


@dataclass(frozen=True)
class MotorControllerFile:
    """A motor controller and where it comes from.

    Attributes:
        name: of the controller.
        kind: how it was designed.
        parameters: gains and drive data.
        plant_name: name of the model it was designed for, empty if none.
        plant_hash: hash of that model, empty if none.
        provenance: weights, versions and figures of the design, free.
        sample_time_s: [s].

    Raises:
        InputError: another sample time.
    """

    name: str
    kind: str
    parameters: MotorParameters
    plant_name: str = ""
    plant_hash: str = ""
    provenance: Mapping[str, Any] = field(default_factory=dict)
    sample_time_s: float = CONTROL_PERIOD

    def __post_init__(self) -> None:
        if self.sample_time_s != CONTROL_PERIOD:
            raise InputError(f"{self.sample_time_s!r}", allowed=f"{CONTROL_PERIOD}", key="sample_time_s")

    def mapping(self) -> dict[str, Any]:
        """Everything, as it stands in a file: plain numbers, texts, lists and mappings."""
        plant = {"plant": {"name": self.plant_name, "hash": self.plant_hash}} if self.plant_hash else {}
        return {
            "format": FORMAT,
            "name": self.name,
            "kind": self.kind,
            **plant,
            "sample_time_s": self.sample_time_s,
            **asdict(self.parameters),
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
    def read(cls, path: Path) -> MotorControllerFile:
        """Read a file strictly.

        Raises:
            InputError: missing or corrupt file, unknown or missing key, a number out of range, wrong sample
                time; names file, key, value and what is allowed.
        """
        document = read_yaml(path)
        check_format(document, FORMAT, path)
        required = ("format", "name", "kind", "sample_time_s", *_NUMBERS)
        check_keys(document, required, ("plant", "provenance"), path)
        plant_name, plant_hash = read_plant(document["plant"], path) if "plant" in document else ("", "")
        numbers = {key: document[key] for key in _NUMBERS}
        try:
            return cls(
                name=read_word(document["name"], path, "name"),
                kind=read_word(document["kind"], path, "kind"),
                parameters=from_mapping(MotorParameters, numbers, file=str(path)),
                plant_name=plant_name,
                plant_hash=plant_hash,
                provenance=read_mapping(document.get("provenance", {}), path, "provenance"),
                sample_time_s=document["sample_time_s"],
            )
        except InputError as error:
            raise InputError(error.problem, allowed=error.allowed, file=path, key=error.key) from None


def load_motor_controller(name_or_path: str, plant: str = "") -> MotorControllerFile:
    """A motor controller by the name of a shipped one or by the path of its file; a file goes first.

    Args:
        name_or_path: of the controller.
        plant: hash of the plant that it must be for; empty: any.

    Raises:
        InputError: neither, the file is no motor controller, or it is for another plant.
    """
    path = find_controller(name_or_path, FORMAT)
    controller = MotorControllerFile.read(path)
    require_plant(path, controller.plant_name, controller.plant_hash, plant)
    return controller
