"""Models and controllers for other tools: python-control objects, and .mat files, both ways bit for bit.

A .mat file (version 5, `load` in MATLAB and Octave, `scipy.io.loadmat`) holds what the YAML file holds. Each
linear system is a struct of its own, ready for `ss(horizontal.A, horizontal.B, horizontal.C, horizontal.D,
horizontal.dt)`:

    format name kind plant sample_time_s operating_point provenance   of a controller
    format name source operating_point                               of a model
    horizontal vertical (full drive)    A B C D dt states inputs outputs, and anti_windup of a controller

Names are cells of text, dt is 0 for a continuous system, and provenance or source is JSON text.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat, savemat

from heli_common import model_file
from heli_common.errors import InputError
from heli_common.files import read_yaml, write_atomically
from heli_common.linear_model import StateSpace, short
from heli_common.model_file import OPTIONAL_BLOCKS, REQUIRED_BLOCKS, ModelFile
from heli_control import controller_file
from heli_control.controller_file import AXES, ControllerFile
from heli_control.realisation import Array

FORMATS = (model_file.FORMAT, controller_file.FORMAT)
_FREE = {model_file.FORMAT: "source", controller_file.FORMAT: "provenance"}
_MATRICES = ("A", "B", "C", "D", "anti_windup")
_NAMES = ("states", "inputs", "outputs")
_ADDED = ("__header__", "__version__", "__globals__")


def to_control(system: StateSpace, period: float | None = None) -> Any:
    """A `control.StateSpace` with names as labels.

    Args:
        system: any.
        period: sample time [s]; None for a continuous system.
    """
    return import_module("control").StateSpace(
        system.A,
        system.B,
        system.C,
        system.D,
        0 if period is None else period,
        states=list(system.states) or None,
        inputs=list(system.inputs),
        outputs=list(system.outputs),
    )


def from_control(system: Any) -> tuple[StateSpace, float | None]:
    """The system of a `control.StateSpace`, and its sample time [s]; None if it is continuous.

    Args:
        system: with labels that are the names wanted.

    Raises:
        InputError: no state space, no sample time, names or numbers that are not allowed.
    """
    if not isinstance(system, import_module("control").StateSpace):
        raise InputError(f"{type(system).__name__} is no state space", allowed="control.StateSpace")
    dt = system.dt
    if dt is None or dt is True or not dt >= 0.0:
        raise InputError(f"{dt!r} is no sample time", allowed="0 for continuous, or seconds", key="dt")
    names = (tuple(system.state_labels), tuple(system.input_labels), tuple(system.output_labels))
    return StateSpace(*names, system.A, system.B, system.C, system.D), float(dt) or None


def control_objects(file: ModelFile | ControllerFile) -> dict[str, Any]:
    """A `control.StateSpace` per block of a model or axis of a controller, by its name."""
    if isinstance(file, ControllerFile):
        return {axis: to_control(getattr(file, axis).system, file.sample_time_s) for axis in AXES}
    blocks = {name: getattr(file, name) for name in REQUIRED_BLOCKS + OPTIONAL_BLOCKS}
    return {name: to_control(block) for name, block in blocks.items() if block is not None}


def read_file(path: Path) -> ModelFile | ControllerFile:
    """A model or controller file, whichever it is, from YAML.

    Raises:
        InputError: neither, or something is wrong in it.
    """
    return _made(read_yaml(path), path)


def write_mat(file: ModelFile | ControllerFile, path: Path) -> None:
    """Write the .mat file of a model or controller.

    Raises:
        ValueError: the free part, `source` or `provenance`, holds something that JSON cannot.
    """
    document = file.mapping()
    free = _FREE[document["format"]]
    document[free] = json.dumps(document[free])
    period = document.get("sample_time_s", 0.0)
    for name, block in (document.pop("axes", None) or _blocks(document)).items():
        document[name] = _struct(block) | {"dt": float(period)}
    stream = io.BytesIO()
    savemat(stream, document, long_field_names=True)
    # the header carries the time of writing: two files of one model shall be the same bytes
    text = f"MATLAB 5.0 MAT-file, {document['format']}".encode().ljust(116)
    write_atomically(path, text + stream.getvalue()[116:])


def read_mat(path: Path) -> ModelFile | ControllerFile:
    """The model or controller of a .mat file.

    Raises:
        InputError: no such file, another kind of file, or something is wrong or missing in it; names file,
            key, value and what is allowed.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from None
    try:
        found = loadmat(io.BytesIO(data))
    except NotImplementedError:
        raise InputError("is a .mat file of version 7.3", allowed="save with -v7", file=path) from None
    except Exception as error:  # loadmat raises whatever it stumbles over
        problem = str(error).partition("\n")[0] or type(error).__name__
        raise InputError(f"is no .mat file: {problem}", allowed="a .mat file", file=path) from None
    document = {key: _plain(value, path, key) for key, value in found.items() if key not in _ADDED}
    if document.get("format") not in FORMATS:
        problem = f"{short(document.get('format'))} is another format"
        raise InputError(problem, allowed=", ".join(FORMATS), file=path, key="format")
    free = _FREE[document["format"]]
    if free in document:
        document[free] = _json(document[free], path, free)
    period = document.get("sample_time_s", 0.0)
    blocks = {key: document.pop(key) for key in REQUIRED_BLOCKS + OPTIONAL_BLOCKS if key in document}
    for key, block in blocks.items():
        dt = block.pop("dt", None) if isinstance(block, dict) else None
        if dt != period:
            raise InputError(f"{short(dt)}", allowed=f"{period!r}", file=path, key=f"{key}.dt")
    whole = {"axes": blocks} if document["format"] == controller_file.FORMAT else blocks
    return _made(document | whole, path)


def _made(document: Mapping[str, Any], path: Path) -> ModelFile | ControllerFile:
    if document.get("format") == controller_file.FORMAT:
        return ControllerFile.from_mapping(document, path)
    if document.get("format") == model_file.FORMAT:
        return ModelFile.from_mapping(document, path)
    problem = f"{short(document.get('format'))} is another format"
    raise InputError(problem, allowed=", ".join(FORMATS), file=path, key="format")


def _blocks(document: Mapping[str, Any]) -> dict[str, Any]:
    return {key: document[key] for key in REQUIRED_BLOCKS + OPTIONAL_BLOCKS if key in document}


def _struct(block: Mapping[str, Any]) -> dict[str, Any]:
    """Matrices with their true shape, also without rows, and names as a cell."""
    n, m, p = (len(block[key]) for key in _NAMES)
    shapes = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "anti_windup": (n, p)}
    struct: dict[str, Any] = {}
    for key, value in block.items():
        if key in _NAMES:
            cell = np.empty((1, len(value)), dtype=object)
            cell[0, :] = value
            struct[key] = cell
        else:
            struct[key] = np.array(value, dtype=np.float64).reshape(shapes[key])
    return struct


def _plain(value: Any, path: Path, key: str) -> Any:
    """Structs as mappings, cells as lists, text, numbers, and matrices as nested lists."""
    last = key.rpartition(".")[2]
    if isinstance(value, np.ndarray) and value.dtype.names is not None:
        if value.size != 1:
            raise InputError(f"{value.size} structs", allowed="one struct", file=path, key=key)
        record = value.reshape(-1)[0]
        return {name: _plain(record[name], path, f"{key}.{name}") for name in value.dtype.names}
    if isinstance(value, np.ndarray) and value.dtype.kind == "U":
        return str(value[0]) if value.size == 1 else ""
    if last in _NAMES and isinstance(value, np.ndarray) and value.size == 0:
        return []
    if isinstance(value, np.ndarray) and value.dtype.kind == "O":
        return [_plain(entry, path, f"{key}[{index}]") for index, entry in enumerate(value.reshape(-1))]
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and value.ndim == 2:
        if last in _MATRICES:
            matrix: Array = value.astype(np.float64)
            return matrix.tolist()
        if value.size == 1:
            return float(value[0, 0])
    allowed = "struct, cell, text, number or real matrix"
    kind = f"{value.dtype} of {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
    raise InputError(f"{kind} cannot be used", allowed=allowed, file=path, key=key)


def _json(value: Any, path: Path, key: str) -> Any:
    try:
        return json.loads(value)
    except (TypeError, ValueError):
        raise InputError(f"{short(value)} is no JSON", allowed="JSON text", file=path, key=key) from None
