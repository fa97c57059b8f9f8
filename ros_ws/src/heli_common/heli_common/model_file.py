"""The model file: linear plants at one operating point, as text that survives a round trip bit for bit.

It passes from simulation or identification to control design (spec 0.1). YAML, `format: heli_model/1`:
name, source (free mapping: where the numbers come from), operating_point, and state-space blocks
`horizontal` and `vertical`, with `full` and `drive` if they are known. All values in SI and radians.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import yaml
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.files import read_yaml, write_atomically
from heli_common.linear_model import OperatingPoint, StateSpace, short

FORMAT = "heli_model/1"
REQUIRED_BLOCKS = ("horizontal", "vertical")
OPTIONAL_BLOCKS = ("full", "drive")

Array = NDArray[np.float64]
Block = TypeVar("Block")


@dataclass(frozen=True, eq=False)
class ModelFile:
    """Linear plants of one helicopter at one operating point.

    Attributes:
        name: of the model, one word.
        source: provenance, free.
        operating_point: the trim about which the blocks are linear.
        horizontal: theta phi u v q p and, if known, a_1p b_1p; inputs B_1s A_1s.
        vertical: w r and, if known, V_i V_t; inputs theta_0 theta_t.
        full: all states, if known.
        drive: rotor speed and motor torque, if known.
        plant_hash: SHA-256 over operating point and blocks; name and source do not count.
    """

    name: str
    source: Mapping[str, Any]
    operating_point: OperatingPoint
    horizontal: StateSpace
    vertical: StateSpace
    full: StateSpace | None = None
    drive: StateSpace | None = None
    plant_hash: str = field(init=False)

    def __post_init__(self) -> None:
        content = {"operating_point": asdict(self.operating_point)} | self._blocks()
        text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
        object.__setattr__(self, "plant_hash", hashlib.sha256(text.encode()).hexdigest())

    def _blocks(self) -> dict[str, Any]:
        blocks = {key: getattr(self, key) for key in REQUIRED_BLOCKS + OPTIONAL_BLOCKS}
        return {key: block.mapping() for key, block in blocks.items() if block is not None}

    def mapping(self) -> dict[str, Any]:
        """Everything, as it stands in a file: plain numbers, texts, lists and mappings."""
        head = {"format": FORMAT, "name": self.name, "source": dict(self.source)}
        return head | {"operating_point": asdict(self.operating_point)} | self._blocks()

    def write(self, path: Path) -> None:
        """Write the file; floats are printed so that reading gives the same bits.

        Raises:
            ValueError: `source` holds something that YAML cannot.
        """
        write_atomically(path, yaml_text(self.mapping()))

    @classmethod
    def read(cls, path: Path) -> ModelFile:
        """Read a file strictly.

        Raises:
            InputError: missing or corrupt file, unknown or missing key, wrong shape, not a finite number;
                names file, key, value and what is allowed.
        """
        return cls.from_mapping(read_yaml(path), path)

    @classmethod
    def from_mapping(cls, document: Mapping[str, Any], path: Path) -> ModelFile:
        """The model that a document holds, as `mapping` gives it; `path` is named in errors.

        Raises:
            InputError: as `read`.
        """
        check_format(document, FORMAT, path)
        required = ("format", "name", "source", "operating_point", *REQUIRED_BLOCKS)
        check_keys(document, required, OPTIONAL_BLOCKS, path)
        blocks = {
            key: read_state_space(document[key], path, key)
            for key in REQUIRED_BLOCKS + OPTIONAL_BLOCKS
            if key in document
        }
        return cls(
            name=read_word(document["name"], path, "name"),
            source=read_mapping(document["source"], path, "source"),
            operating_point=read_operating_point(document["operating_point"], path, "operating_point"),
            **blocks,
        )


def check_format(document: Mapping[str, Any], expected: str, path: Path) -> None:
    """Refuse a file of another format or version."""
    if document.get("format") != expected:
        problem = f"{document.get('format')!r} is another format"
        raise InputError(problem, allowed=expected, file=path, key="format")


def check_keys(
    value: Mapping[str, Any],
    required: Sequence[str],
    optional: Sequence[str],
    path: Path,
    prefix: str = "",
) -> None:
    """Refuse unknown and missing keys of a mapping."""
    for key in value:
        if key not in (*required, *optional):
            allowed = ", ".join((*required, *optional))
            raise InputError("unknown key", allowed=allowed, file=path, key=f"{prefix}{key}")
    for key in required:
        if key not in value:
            raise InputError("is missing", allowed=", ".join(required), file=path, key=f"{prefix}{key}")


def read_mapping(value: object, path: Path, key: str) -> dict[str, Any]:
    """A mapping at `key`, or an InputError."""
    if not isinstance(value, dict):
        raise InputError(f"{short(value)} is no mapping", allowed="a mapping", file=path, key=key)
    return value


def read_word(value: object, path: Path, key: str) -> str:
    """A text that is not empty at `key`, or an InputError."""
    if not isinstance(value, str) or not value.strip():
        raise InputError(f"{short(value)} is no name", allowed="a text, not empty", file=path, key=key)
    return value


def read_state_space(value: object, path: Path, key: str) -> StateSpace:
    """The state-space block at `key`, or an InputError that names the entry."""
    block = read_mapping(value, path, key)
    check_keys(block, [field.name for field in fields(StateSpace)], (), path, f"{key}.")
    return _placed(StateSpace, block, path, key)


def read_operating_point(value: object, path: Path, key: str) -> OperatingPoint:
    """The operating point at `key`, or an InputError that names the entry."""
    block = read_mapping(value, path, key)
    check_keys(block, [field.name for field in fields(OperatingPoint)], (), path, f"{key}.")
    return _placed(OperatingPoint, block, path, key)


def yaml_text(document: Mapping[str, Any]) -> str:
    """YAML with one line per matrix row; floats come back bit for bit.

    Raises:
        ValueError: something in it is no plain number, text, list or mapping.
    """
    try:
        text: str = yaml.dump(
            _rows(document), Dumper=_Dumper, sort_keys=False, width=4096, allow_unicode=True
        )
    except yaml.representer.RepresenterError as error:
        raise ValueError(f"cannot be written as YAML: {error.args[-1]!r}") from None
    return text


class _Row(list[Any]):
    """A list that is printed on one line."""


class _Dumper(yaml.SafeDumper):
    """Prints rows on one line, everything else one entry per line."""

    def ignore_aliases(self, data: Any) -> bool:
        """No anchors: a list that occurs twice is written twice."""
        del data
        return True


_Dumper.add_representer(
    _Row, lambda dumper, row: dumper.represent_sequence("tag:yaml.org,2002:seq", row, flow_style=True)
)


def _rows(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _rows(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        nested = any(isinstance(entry, (list, tuple, Mapping)) for entry in value)
        return [_rows(entry) for entry in value] if nested else _Row(value)
    return value


def _placed(cls: type[Block], block: Mapping[str, Any], path: Path, key: str) -> Block:
    try:
        return cls(**block)
    except InputError as error:
        place = f"{key}.{error.key}"
        raise InputError(error.problem, allowed=error.allowed, file=path, key=place) from None
