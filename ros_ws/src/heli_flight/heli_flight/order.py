"""What is to be flown, how, and what the bag shall say about it."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from heli_control.controller_file import ControllerFile
from heli_control.motor_controller_file import MotorControllerFile, load_motor_controller
from heli_flight.mode import Mode
from heli_flight.plan import Plan
from heli_flight.process_table import processes

RECORDED_VERSIONS = ("heli_flight", "ros-jazzy-rclpy", "numpy", "scipy", "numba", "mcap", "rosbags")


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
        real_time_scheduling: whether a flight on the graph asks for SCHED_FIFO.
        later: controllers that phases of the plan change to, in its order.
        later_names: their names or paths.
        motor: the motor controller as read from its file; the shipped one without.
        motor_name: name of a shipped motor controller or path of its file, for its node.
        plant: hash of the plant that controllers must be for, empty for any.
        replaced: programs that take the place of nodes on the graph, by node name.
        with_identification: whether the identification flies along though the plan excites nothing.
        storage: way of storing the bag, see `bag.STORAGES`.
        namespace: of every node and topic on the graph, without the leading slash; empty for none.
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
    later: tuple[ControllerFile, ...] = ()
    later_names: tuple[str, ...] = ()
    motor: MotorControllerFile | None = None
    motor_name: str = "motor"
    plant: str = ""
    replaced: Mapping[str, Path] = field(default_factory=dict)
    with_identification: bool = False
    storage: str = "mcap"
    namespace: str = ""

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
        files = (self.controller, *self.later)
        return {
            "plan": self.plan.to_yaml(),
            "mode": self.mode.value,
            "seed": str(self.seed),
            "controller": ", ".join(file.name for file in files),
            "controllers": json.dumps([_origin(file) for file in files]),
            "controller_file": "---\n".join(file.to_yaml() for file in files),
            "motor_file": (self.motor or load_motor_controller(self.motor_name)).to_yaml(),
            "parameters": self.parameters.read_text() if self.parameters else "defaults",
            "versions": json.dumps(
                {name: _version(name) for name in RECORDED_VERSIONS} | {"python": platform.python_version()}
            ),
        }


def _origin(controller: ControllerFile) -> dict[str, str]:
    """Name of a controller, hash of its file's text, hash of the plant it was designed for."""
    digest = hashlib.sha256(controller.to_yaml().encode()).hexdigest()
    return {"name": controller.name, "sha256": digest, "plant_hash": controller.plant_hash}


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
