"""What is to be flown, how, and what the bag shall say about it."""

from __future__ import annotations

import json
import platform
from dataclasses import dataclass
from enum import Enum
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from heli_control.controller_file import ControllerFile
from heli_flight.plan import Plan
from heli_flight.process_table import processes

RECORDED_VERSIONS = ("heli_flight", "ros-jazzy-rclpy", "numpy", "scipy", "numba", "mcap", "rosbags")


class Mode(str, Enum):
    """The three ways of running a flight."""

    LOCKSTEP = "lockstep"
    REALTIME = "realtime"
    INPROCESS = "inprocess"


@dataclass(frozen=True)
class FlightOrder:
    """One flight.

    Attributes:
        plan: what to fly.
        plan_name: name of a shipped plan or path of a plan file, for the supervisor node.
        mode: way of running.
        seed: of every random number.
        controller: the attitude controller as read from its file.
        controller_name: name of a shipped controller or path of a controller file, for its node.
        bag: folder to record into.
        parameters: ROS 2 parameter file for the nodes, None for defaults.
        real_time_scheduling: whether a real-time flight asks for SCHED_FIFO.
        with_identification: whether the identification flies along though the plan excites nothing.
    """

    plan: Plan
    plan_name: str
    mode: Mode
    seed: int
    controller: ControllerFile
    controller_name: str
    bag: Path
    parameters: Path | None = None
    real_time_scheduling: bool = True
    with_identification: bool = False

    @property
    def identified(self) -> bool:
        """Whether the identification flies along."""
        return self.with_identification or bool(self.plan.excitations)

    @property
    def running(self) -> tuple[str, ...]:
        """Names of the nodes of the flight."""
        return tuple(process.name for process in processes(self.identified))

    def notes(self) -> dict[str, str]:
        """What the bag carries beside its messages."""
        return {
            "plan": self.plan.to_yaml(),
            "mode": self.mode.value,
            "seed": str(self.seed),
            "controller": self.controller.name,
            "controller_file": self.controller.to_yaml(),
            "parameters": self.parameters.read_text() if self.parameters else "defaults",
            "versions": json.dumps(
                {name: _version(name) for name in RECORDED_VERSIONS} | {"python": platform.python_version()}
            ),
        }


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "from the system"


@dataclass(frozen=True)
class FlightEnd:
    """How a flight ended.

    Attributes:
        exit_code: 0 flown, 2 bad input, 3 safety stop, 130 interrupted.
        reason: one line, empty if all went well.
        simulated_seconds: length of the flight.
        wall_seconds: how long it took.
    """

    exit_code: int
    reason: str
    simulated_seconds: float
    wall_seconds: float
