"""ROS parameters from the one parameter dataclass: unit, range and provenance in every description."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import TypeVar

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from heli_common.errors import InputError
from heli_common.quantities import PROVENANCE, about, from_mapping, groups_of

Parameters = TypeVar("Parameters")


def declare_parameters(node: Node, cls: type[Parameters], prefix: str = "") -> Parameters:
    """Declare every field of a parameter dataclass as a read-only ROS parameter and read its value.

    Raises:
        InputError: a value from the command line or a parameter file is no number or out of range.
    """
    values: dict[str, object] = {}
    for field in fields(cls):  # type: ignore[arg-type]
        known = about(field)
        text = f"{known.text} [{known.unit}], {PROVENANCE[known.provenance]}"
        descriptor = ParameterDescriptor(description=text, read_only=True, dynamic_typing=True)
        descriptor.additional_constraints = f"{known.minimum:g} .. {known.maximum:g}"
        name = f"{prefix}{field.name}"
        values[field.name] = node.declare_parameter(name, field.default, descriptor).value
    return from_mapping(cls, values, prefix=prefix)


def declare_groups(node: Node, cls: type[Parameters]) -> Parameters:
    """Declare a dataclass of parameter dataclasses, each under the name of its field.

    Raises:
        InputError: as `declare_parameters`.
    """
    groups = {
        field.name: declare_parameters(node, type(group), f"{field.name}.") for field, group in groups_of(cls)
    }
    return cls(**groups)


def declare_text(node: Node, name: str, default: str, text: str) -> str:
    """Declare and read a read-only string parameter.

    Raises:
        InputError: the given value is no string.
    """
    descriptor = ParameterDescriptor(description=text, read_only=True)
    try:
        return str(node.declare_parameter(name, default, descriptor).value)
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise InputError(str(error), allowed="a string", key=name) from None


def declare_integer(node: Node, name: str, default: int, text: str, minimum: int, maximum: int) -> int:
    """Declare and read a read-only integer parameter.

    Raises:
        InputError: the given value is no integer or out of range.
    """
    descriptor = ParameterDescriptor(description=text, read_only=True, dynamic_typing=True)
    value = node.declare_parameter(name, default, descriptor).value
    if isinstance(value, bool) or not isinstance(value, int) or not minimum <= value <= maximum:
        allowed = f"an integer {minimum} .. {maximum}"
        raise InputError(f"{value!r} is refused", allowed=allowed, key=name)
    return value


def declare_names(node: Node, name: str, text: str) -> tuple[str, ...]:
    """Declare and read a list of node names, given as one comma-separated string.

    Raises:
        InputError: the given value is no string.
    """
    joined = declare_text(node, name, "", text)
    return tuple(part.strip() for part in joined.split(",") if part.strip())


def declare_request(
    node: Node, name: str, default: str | float, text: str, take: Callable[[str | float], None]
) -> None:
    """Declare a parameter that may be set at any time; every value set is a request.

    Args:
        node: of the parameter.
        name: of the parameter.
        default: what it shows before the first request; its type is that of every request.
        text: for people.
        take: called with the value; refuses it with InputError, whose text the caller of the parameter
            service gets to read.
    """
    node.declare_parameter(name, default, ParameterDescriptor(description=text))

    def check(parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == name:
                try:
                    take(parameter.value)
                except InputError as error:
                    return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(check)
