"""Parameters of live nodes: listed, described, read and set, in the words of ros2cli."""

from __future__ import annotations

import argparse
import sys

from heli_flight.nodes.live_graph import LiveGraph  # first: it takes the signals before rclpy does

# isort: split
from rcl_interfaces.msg import Parameter, ParameterDescriptor, ParameterType
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import get_parameter_value, parameter_value_to_python

from heli_common.errors import InputError

_WORDS = {
    ParameterType.PARAMETER_NOT_SET: "not set",
    ParameterType.PARAMETER_BOOL: "boolean",
    ParameterType.PARAMETER_INTEGER: "integer",
    ParameterType.PARAMETER_DOUBLE: "double",
    ParameterType.PARAMETER_STRING: "string",
    ParameterType.PARAMETER_BYTE_ARRAY: "byte array",
    ParameterType.PARAMETER_BOOL_ARRAY: "boolean array",
    ParameterType.PARAMETER_INTEGER_ARRAY: "integer array",
    ParameterType.PARAMETER_DOUBLE_ARRAY: "double array",
    ParameterType.PARAMETER_STRING_ARRAY: "string array",
}


def show_names(graph: LiveGraph, options: argparse.Namespace) -> None:
    """Names of the parameters of one node or of all."""
    if options.node:
        lines = _names(graph, _node(graph, options.node))
    else:
        graph.settle()
        lines = []
        for node in graph.nodes():
            if f"{node}/list_parameters" in graph.services():
                lines += [f"{node}:", *_names(graph, node)]
    _say(*lines)


def describe(graph: LiveGraph, options: argparse.Namespace) -> None:
    """Type, text with unit, and limits of parameters.

    Raises:
        InputError: no such node or parameter.
    """
    node = _node(graph, options.node)
    request = DescribeParameters.Request(names=options.parameters)
    found = graph.ask(DescribeParameters, f"{node}/describe_parameters", request).descriptors
    known = {each.name: each for each in found if each.type != ParameterType.PARAMETER_NOT_SET}
    for name in options.parameters:
        if name not in known:
            raise _not_set(node, name)
        _say(*_description(known[name]))


def show_value(graph: LiveGraph, options: argparse.Namespace) -> None:
    """Value of a parameter.

    Raises:
        InputError: no such node or parameter.
    """
    node = _node(graph, options.node)
    request = GetParameters.Request(names=[options.parameter])
    values = graph.ask(GetParameters, f"{node}/get_parameters", request).values
    if not values or values[0].type == ParameterType.PARAMETER_NOT_SET:
        raise _not_set(node, options.parameter)
    word = _WORDS[values[0].type].removesuffix(" array").capitalize()
    be = "values are" if "array" in _WORDS[values[0].type] else "value is"
    _say(f"{word} {be}: {parameter_value_to_python(values[0])}")


def set_value(graph: LiveGraph, options: argparse.Namespace) -> None:
    """Set a parameter.

    Raises:
        InputError: no such node, or it refuses, with its reason.
    """
    node = _node(graph, options.node)
    parameter = Parameter(name=options.parameter, value=get_parameter_value(options.value))
    request = SetParameters.Request(parameters=[parameter])
    (result,) = graph.ask(SetParameters, f"{node}/set_parameters", request).results
    reason = f": {result.reason}" if result.reason else ""
    if not result.successful:
        raise InputError(f"Setting parameter failed{reason}")
    _say(f"Set parameter successful{reason}")


def _node(graph: LiveGraph, name: str) -> str:
    return graph.require(name, graph.nodes, "Node not found:")


def _names(graph: LiveGraph, node: str) -> list[str]:
    found = graph.ask(ListParameters, f"{node}/list_parameters", ListParameters.Request())
    return [f"  {name}" for name in sorted(found.result.names)]


def _not_set(node: str, name: str) -> InputError:
    return InputError(f"Parameter not set: '{name}'", allowed=f"those of heli param list {node}")


def _description(descriptor: ParameterDescriptor) -> list[str]:
    lines = [f"Parameter name: {descriptor.name}", f"  Type: {_WORDS[descriptor.type]}"]
    if descriptor.description:
        lines.append(f"  Description: {descriptor.description}")
    lines.append("  Constraints:")
    if descriptor.read_only:
        lines.append("    Read only: true")
    for limits in [*descriptor.floating_point_range, *descriptor.integer_range][:1]:
        lines += [f"    Min value: {limits.from_value}", f"    Max value: {limits.to_value}"]
        lines += [f"    Step: {limits.step}"] if limits.step else []
    if descriptor.additional_constraints:
        lines.append(f"    Additional constraints: {descriptor.additional_constraints}")
    return lines


def _say(*lines: str) -> None:
    for line in lines:
        sys.stdout.write(f"{line}\n")
    sys.stdout.flush()
