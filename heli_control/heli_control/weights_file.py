"""The weights file: everything an H-infinity design is told, with the source's values as defaults.

YAML, `format: heli_weights/1`, with `kind` and a block for each axis of it: `scales`, `settings` and the
weights of the scheme (`schemes`), each a mapping from signal to weight (`weight`). A user's file holds what
differs from the shipped one of its kind.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from heli_common.errors import InputError
from heli_common.files import read_yaml
from heli_common.model_file import check_format, check_keys, read_mapping
from heli_common.quantities import Quantity, check_number
from heli_control.flight_plants import INPUTS, OUTPUTS, REFERENCES
from heli_control.schemes import COMMANDS, SCHEMES, AxisWeights, Scheme
from heli_control.schemes import OUTPUTS as ON_OUTPUTS
from heli_control.weight import Weight, read_weight

FORMAT = "heli_weights/1"

_SCALE = Quantity("SI", "D", "what counts as large for a signal", 1e-6, 1e6)


@dataclass(frozen=True)
class WeightsFile:
    """Weights of all axes of a design.

    Attributes:
        kind: of the design, a key of `SCHEMES`.
        axes: weights by the name of their axis.
    """

    kind: str
    axes: Mapping[str, AxisWeights]

    def mapping(self) -> dict[str, Any]:
        """Everything, as it stands in a file."""
        return {"format": FORMAT, "kind": self.kind} | {
            axis: _mapping(weights) for axis, weights in self.axes.items()
        }


def default_weights(kind: str) -> WeightsFile:
    """The shipped weights of a kind.

    Raises:
        InputError: no such kind.
    """
    if kind not in SCHEMES:
        raise InputError(f"unknown kind {kind!r}", allowed=", ".join(SCHEMES), key="kind")
    path = Path(str(resources.files("heli_control"))) / "weights" / f"{kind}.yaml"
    return _read(path, kind, None)


def read_weights(kind: str, path: Path | None) -> WeightsFile:
    """The shipped weights of a kind with what a user's file changes.

    Args:
        kind: a key of `SCHEMES`.
        path: of the user's file; None for none.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    default = default_weights(kind)
    return default if path is None else _read(path, kind, default)


def _read(path: Path, kind: str, default: WeightsFile | None) -> WeightsFile:
    document = read_yaml(path)
    check_format(document, FORMAT, path)
    axes = SCHEMES[kind].axes
    required = ("format", "kind") if default else ("format", "kind", *axes)
    check_keys(document, required, axes, path)
    if document["kind"] != kind:
        raise InputError(f"{document['kind']!r} is another kind", allowed=kind, file=path, key="kind")
    made = {
        axis: _axis(
            read_mapping(document.get(axis, {}), path, axis),
            SCHEMES[kind],
            axis,
            default.axes[axis] if default else None,
            path,
        )
        for axis in axes
    }
    return WeightsFile(kind, made)


def _axis(
    block: Mapping[str, Any], scheme: Scheme, axis: str, default: AxisWeights | None, path: Path
) -> AxisWeights:
    known = ("scales", "settings", *scheme.weights)
    check_keys(block, () if default else known, known, path, f"{axis}.")
    outputs, inputs = OUTPUTS[axis], INPUTS[axis]
    referenced = tuple(name for name in outputs if name in REFERENCES)

    def entries(name: str, allowed: Sequence[str], fallback: Mapping[str, Any] | None) -> dict[str, Any]:
        key = f"{axis}.{name}"
        given = read_mapping(block.get(name, {}), path, key)
        check_keys(given, () if fallback is not None else allowed, tuple(allowed), path, f"{key}.")
        return dict(given)

    def numbers(
        name: str, about: Mapping[str, Quantity], fallback: Mapping[str, float] | None
    ) -> dict[str, float]:
        given = entries(name, tuple(about), fallback)
        return {
            key: check_number(given[key], known, file=str(path), key=f"{axis}.{name}.{key}")
            if key in given
            else (fallback or {})[key]
            for key, known in about.items()
        }

    scales = numbers(
        "scales", dict.fromkeys((*outputs, *inputs), _SCALE), default.scales if default else None
    )
    settings = numbers("settings", scheme.settings, default.settings if default else None)
    weights: dict[str, dict[str, Weight]] = {}
    for name, on in scheme.weights.items():
        signals = inputs if on == COMMANDS else outputs if on == ON_OUTPUTS else referenced
        fallback = default.weights[name] if default else None
        given = entries(name, signals, fallback)
        weights[name] = {
            signal: read_weight(given[signal], str(path), f"{axis}.{name}.{signal}")
            if signal in given
            else (fallback or {})[signal]
            for signal in signals
        }
    return AxisWeights(scales, weights, settings)


def _mapping(axis: AxisWeights) -> dict[str, Any]:
    return {
        "scales": dict(axis.scales),
        "settings": dict(axis.settings),
        **{
            name: {signal: weight.mapping() for signal, weight in weights.items()}
            for name, weights in axis.weights.items()
        },
    }
