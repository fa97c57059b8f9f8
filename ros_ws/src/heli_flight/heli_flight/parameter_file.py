"""The parameter file of the whole graph: every number of every node with unit, range, meaning and origin."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.watch import WatchParameters
from heli_common import topics
from heli_common.errors import InputError
from heli_common.files import read_yaml
from heli_common.quantities import PROVENANCE, about, from_mapping, groups_of
from heli_common.rig_geometry import RigGeometry
from heli_control.attitude_control import AttitudeParameters
from heli_control.position_control import PositionParameters
from heli_flight.stages import FlightLimits
from heli_identification.excitation_guard import GuardParameters
from heli_identification.running_estimate import EstimateParameters
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.imu_attitude_parameters import ImuAttitudeParameters
from heli_navigation.navigator import NavigationParameters

Parameters = TypeVar("Parameters")

NODE_PARAMETERS: dict[str, list[tuple[str, Any]]] = {
    topics.BENCH_SIM: [
        *((f"{field.name}.", group) for field, group in groups_of(BenchParameters)),
        ("watch.", WatchParameters()),
    ],
    topics.NAVIGATION: [
        ("", NavigationParameters()),
        ("rig.", RigGeometry()),
        ("filter.", FilterParameters()),
        ("imu_attitude.", ImuAttitudeParameters()),
    ],
    topics.SUPERVISOR: [("", FlightLimits())],
    topics.POSITION_CONTROLLER: [("", PositionParameters())],
    topics.ATTITUDE_CONTROLLER: [("", AttitudeParameters())],
    topics.IDENTIFICATION: [("guard.", GuardParameters()), ("estimate.", EstimateParameters())],
}
"""Prefix and parameter dataclasses of each node, as the node declares them."""

HEAD = """\
# Every parameter of every node with its default. Written by `heli parameters`; a test keeps it true.
# Use: NODE.sh --ros-args --params-file FILE, or copy what you change into a file of your own.
# Origin: T {T}; R {R}; D {D}.
"""


def parameter_file() -> str:
    """The file as text, ready for `--params-file`."""
    lines = [HEAD.format(**PROVENANCE)]
    for node, groups in NODE_PARAMETERS.items():
        lines.append(f"/**/{node}:\n  ros__parameters:\n")
        for prefix, group in groups:
            for field in fields(group):
                known = about(field)
                value = float(getattr(group, field.name))
                remark = f"[{known.unit}] {known.provenance}: {known.text}"
                allowed = f"{known.minimum:g} .. {known.maximum:g}"
                lines.append(f"    {prefix}{field.name}: {yaml_number(value)}  # {remark} ({allowed})\n")
    return "".join(lines)


class NodeValues:
    """What a parameter file changes, per node; everything else keeps its default.

    Args:
        values: full parameter names and numbers of each node.
        file: they came from, for errors.
    """

    def __init__(self, values: Mapping[str, Mapping[str, object]] | None = None, file: str = "") -> None:
        self._values = values or {}
        self._file = file or None

    def changed(self, node: str, values: Mapping[str, object]) -> NodeValues:
        """The same with some parameters of a node set to other values.

        Args:
            node: whose they are.
            values: full parameter names and numbers.
        """
        own = {**self._values.get(node, {}), **values}
        return NodeValues({**self._values, node: own}, self._file or "")

    def build(self, node: str, cls: type[Parameters], prefix: str = "") -> Parameters:
        """The parameter dataclass of a node, as the node itself builds it.

        Raises:
            InputError: a value is no number or out of range.
        """
        own = {
            name.removeprefix(prefix): value
            for name, value in self._values.get(node, {}).items()
            if name.startswith(prefix) and (prefix or "." not in name)
        }
        return from_mapping(cls, own, file=self._file, prefix=prefix)

    def build_groups(self, node: str, cls: type[Parameters]) -> Parameters:
        """A dataclass of parameter dataclasses, each under the name of its field."""
        groups = {
            field.name: self.build(node, type(group), f"{field.name}.") for field, group in groups_of(cls)
        }
        return cls(**groups)


def read_parameters(path: Path) -> NodeValues:
    """A ROS 2 parameter file for the nodes of a flight, checked before any of them starts.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    document = read_yaml(path)
    values: dict[str, dict[str, object]] = {}
    for key, entry in document.items():
        node = str(key).rpartition("/")[2]
        if node not in NODE_PARAMETERS:
            allowed = ", ".join(NODE_PARAMETERS)
            raise InputError("unknown node", allowed=allowed, file=path, key=str(key))
        given = entry.get("ros__parameters") if isinstance(entry, dict) else None
        if not isinstance(given, dict):
            raise InputError("holds no parameters", allowed="ros__parameters: {...}", file=path, key=str(key))
        known = {
            f"{prefix}{field.name}" for prefix, group in NODE_PARAMETERS[node] for field in fields(group)
        }
        flat = _flat(given)
        for name in flat:
            if name not in known:
                close = difflib.get_close_matches(name, known, 3) or sorted(known)[:3]
                allowed = f"for example {', '.join(close)}"
                raise InputError("unknown parameter", allowed=allowed, file=path, key=f"{key}.{name}")
        values.setdefault(node, {}).update(flat)
    checked = NodeValues(values, str(path))
    for node, groups in NODE_PARAMETERS.items():
        for prefix, group in groups:
            checked.build(node, type(group), prefix)
    return checked


def _flat(values: Mapping[str, object], prefix: str = "") -> dict[str, object]:
    """Nested groups as dotted names, the way ROS 2 reads them."""
    flat: dict[str, object] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{prefix}{name}.")
        else:
            flat[f"{prefix}{name}"] = value
    return flat


def yaml_number(value: float) -> str:
    """A number that YAML reads back as the same float: never an integer, never a bare exponent."""
    text = repr(value)
    mantissa, sign, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return mantissa + sign + exponent
