"""The nodes of a flight in one table: processes, launch file and shell scripts all come from it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from heli_common import topics


@dataclass(frozen=True)
class Process:
    """One node as a process of its own.

    Attributes:
        name: node name in the table of topics.
        package: package it belongs to.
        executable: installed name, for `ros2 run PACKAGE EXECUTABLE`.
        module: for `python -m`.
        priority: SCHED_FIFO priority in a real-time flight, 0 for none.
    """

    name: str
    package: str
    priority: int

    @property
    def lockstep_priority(self) -> int:
        """SCHED_FIFO priority in lockstep, where nobody keeps time.

        Among equals nobody interrupts the one that publishes, and a burst reaches its reader as one; the
        recorder, for whom nobody waits, writes when the others do. `benchmarks/graph.py` shows the gain.
        """
        return 1 if self.name == topics.RECORDER else 2

    def lockstep_core(self, cores: Sequence[int]) -> int:
        """Which of the cores it stays on in lockstep, -1 for any.

        Of two cores each has its own nodes, which find in its cache what they left there. With more, or with
        one, all run anywhere.
        """
        return cores[_PLACES[self.name]] if len(cores) == 2 and self.name in _PLACES else -1

    def scheduling(self, paced: bool, cores: Sequence[int]) -> dict[str, int]:
        """Its parameters under real-time scheduling.

        Args:
            paced: whether the clock on the wall paces the bench.
            cores: on which it may run.
        """
        if paced:
            return {"real_time_priority": self.priority}
        return {"real_time_priority": self.lockstep_priority, "core": self.lockstep_core(cores)}

    @property
    def executable(self) -> str:
        """Installed name of the node's command."""
        return f"{self.name}_node"

    @property
    def module(self) -> str:
        """Python module of the node."""
        return f"{self.package}.nodes.{self.executable}"

    @property
    def script(self) -> str:
        """Name of its shell script, a verb where there is one."""
        return f"{_VERBS.get(self.name, self.name)}.sh"


_VERBS = {topics.RECORDER: "record"}

_PLACES = {
    topics.BENCH_SIM: 0,
    topics.NAVIGATION: 1,
    topics.SUPERVISOR: 0,
    topics.POSITION_CONTROLLER: 1,
    topics.ATTITUDE_CONTROLLER: 0,
    topics.MOTOR_CONTROLLER: 0,
}
"""First or second core of two. Who answers is not where the one that asks still has something to do; the
recorder, for whom nobody waits, runs where there is room."""


PROCESSES: tuple[Process, ...] = (
    Process(topics.BENCH_SIM, "heli_bench_sim", 40),
    Process(topics.NAVIGATION, "heli_navigation", 35),
    Process(topics.SUPERVISOR, "heli_flight", 35),
    Process(topics.POSITION_CONTROLLER, "heli_control", 35),
    Process(topics.ATTITUDE_CONTROLLER, "heli_control", 35),
    Process(topics.MOTOR_CONTROLLER, "heli_control", 35),
    Process(topics.IDENTIFICATION, "heli_identification", 35),
    Process(topics.RECORDER, "heli_flight", 10),
)
"""The bench keeps time, so it comes first; those between sample and command are equals, none of which
interrupts another that publishes; the recorder only drains buffers."""


def processes(identified: bool) -> tuple[Process, ...]:
    """Those of a flight with or without identification."""
    return tuple(process for process in PROCESSES if identified or process.name != topics.IDENTIFICATION)


NODE_NAMES = tuple(process.name for process in PROCESSES)


def environment() -> dict[str, str]:
    """Environment of the nodes: discovery stays on this machine unless the user says otherwise."""
    defaults = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "OPENBLAS_NUM_THREADS": "1"}
    return defaults | dict(os.environ)


def usable_cores() -> tuple[int, ...]:
    """Numbers of the cores that this process may run on; empty where the system does not say."""
    return tuple(sorted(os.sched_getaffinity(0))) if hasattr(os, "sched_getaffinity") else ()
