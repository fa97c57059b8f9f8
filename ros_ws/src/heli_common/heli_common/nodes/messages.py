"""The ROS message class of each layout, and diagnostics in the standard form."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue


def message_class(ros_type: str) -> Any:
    """The class of e.g. `sensor_msgs/msg/JointState`."""
    package, _, name = ros_type.split("/")
    return getattr(import_module(f"{package}.msg"), name)


def time_message(stamp_ns: int) -> Time:
    """A stamp as builtin_interfaces/Time."""
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    return Time(sec=seconds, nanosec=nanoseconds)


LEVELS = {"ok": DiagnosticStatus.OK, "warn": DiagnosticStatus.WARN, "error": DiagnosticStatus.ERROR}


def diagnostic(
    stamp_ns: int, name: str, level: str, text: str, values: Mapping[str, object] | None = None
) -> DiagnosticArray:
    """One node's status; `level` is ok, warn or error."""
    pairs = [KeyValue(key=key, value=str(value)) for key, value in (values or {}).items()]
    status = DiagnosticStatus(level=LEVELS[level], name=name, message=text, hardware_id="", values=pairs)
    array = DiagnosticArray(status=[status])
    array.header.stamp = time_message(stamp_ns)
    return array
