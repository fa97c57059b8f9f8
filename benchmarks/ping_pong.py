"""The middleware's own floor: the same messages between the same processes, computing nothing.

Run by `benchmarks/graph.py`, one process a node: `ping_pong.py NODE --ros-args -p running:=...`;
all of them in one thread: `ping_pong.py composed --ros-args ...`. With `-p paced:=1` the samples come at
their times by the clock, whatever is answered.
"""

from __future__ import annotations

import sys
from time import perf_counter

from heli_common.nodes.runner import (  # first: it takes the signals before rclpy
    Build,
    ComponentProgram,
    Program,
    run_node,
    run_nodes,
)

# isort: split
from rclpy.node import Node

from heli_bench_sim.nodes.bench_program import RECORDER_LAG_NS
from heli_bench_sim.simulator import BenchSimulator
from heli_common.component import Message, StampJoin
from heli_common.nodes.connection import Connection
from heli_common.nodes.parameters import declare_integer
from heli_common.timing import COMMAND_LATENCY_NS, SENSOR_PERIOD_NS, is_command_tick, is_control_tick
from heli_common.topics import BENCH_SIM, RECORDER, TOPICS, data_topics
from heli_control.attitude_control import AttitudeController
from heli_control.motor_control import MotorController
from heli_control.position_control import PositionController
from heli_flight.mode import COMPOSED_PROCESS
from heli_flight.recorder import ACKNOWLEDGE_NS
from heli_flight.supervisor import Supervisor
from heli_navigation.navigator import Navigator

WARM_STEPS, STEPS = 300, 3000
REAL = {
    part.name: part
    for part in (Navigator, Supervisor, PositionController, AttitudeController, MotorController)
}


def zeros(topic: str, stamp_ns: int) -> Message:
    """A message of nothing but a stamp."""
    return Message(topic, stamp_ns, (0.0,) * len(TOPICS[topic].layout.fields))


class Echo:
    """Sends what the real component sends, when it sends it."""

    def __init__(self, name: str) -> None:
        real = REAL[name]
        self.name, self.inputs, self.outputs, self.waking = name, real.inputs, real.outputs, real.waking
        joined = [topic for topic in self.inputs if topic != "rotor"]
        self._join = StampJoin(joined)

    def receive(self, topic: str, stamp_ns: int, values: tuple[float, ...]) -> list[Message]:
        """Answer the last input of a stamp."""
        if topic == "rotor":
            return [zeros("rotor_state", stamp_ns)]
        if self._join.add(topic, stamp_ns, values) is None:
            return []
        due = self.outputs if is_control_tick(stamp_ns) else ("odometry_imu",)
        return [zeros(each, stamp_ns) for each in due if each != "rotor_state"]


class Bench:
    """Sends samples, waits for commands as in lockstep; says its time [s] when warm and when done.

    Args:
        paced: send by the clock and wait for nothing.
    """

    name = BENCH_SIM
    inputs = (*BenchSimulator.inputs, "recorder_ack")
    outputs = BenchSimulator.outputs
    waking = ("servo_command", "motor_command")
    ends = True

    def __init__(self, paced: bool) -> None:
        self.finished = False
        self._paced, self._clock_zero = paced, 0.0
        self._stamp_ns = -SENSOR_PERIOD_NS
        self._newest = dict.fromkeys(self.inputs, -1)
        self._connection: Connection | None = None

    def start(self, connection: Connection) -> None:
        """Keep the connection."""
        self._connection = connection

    def on_message(self, topic: str, data: bytes) -> None:
        """Note a command and go on as far as that allows."""
        self._newest[topic] = TOPICS[topic].layout.unpack(data)[0]
        if not self._paced:
            self._advance()

    def turn(self) -> float:
        """Begin when everybody is there; then go on by the clock, if at all."""
        if self._connection is not None and self._stamp_ns < 0 and not self._connection.absent():
            self._clock_zero = perf_counter()
            self._advance()
        if not self._paced or self._stamp_ns < 0:
            return 0.02
        self._advance()
        return max(0.0, self._due - perf_counter())

    def close(self) -> None:
        """Nothing to finish."""

    @property
    def _due(self) -> float:
        return self._clock_zero + 1e-9 * (self._stamp_ns + SENSOR_PERIOD_NS)

    def _blocked(self) -> bool:
        if self._paced:
            return perf_counter() < self._due
        due = self._stamp_ns - COMMAND_LATENCY_NS
        behind = self._stamp_ns - self._newest["recorder_ack"] > RECORDER_LAG_NS
        missing = is_command_tick(self._stamp_ns) and any(
            self._newest[topic] < due for topic in BenchSimulator.inputs
        )
        return behind or missing

    def _advance(self) -> None:
        assert self._connection is not None
        while not self.finished and not self._blocked():
            self._stamp_ns += SENSOR_PERIOD_NS
            tick = is_control_tick(self._stamp_ns)
            sent = [each for each in self.outputs if tick or TOPICS[each].period_ns == SENSOR_PERIOD_NS]
            self._connection.publish([zeros(each, self._stamp_ns) for each in sent])
            step = self._stamp_ns // (4 * SENSOR_PERIOD_NS)
            if tick and step in (WARM_STEPS, WARM_STEPS + STEPS):
                sys.stdout.write(f"{1e-9 * self._stamp_ns}\n")
                sys.stdout.flush()
                self.finished = step > WARM_STEPS


class Recorder:
    """Takes everything and acknowledges it."""

    name = RECORDER
    inputs = data_topics()
    outputs = ("recorder_ack",)
    waking: tuple[str, ...] = ()
    ends = True

    def __init__(self) -> None:
        self.finished = False
        self._newest = self._acknowledged = -1
        self._connection: Connection | None = None

    def start(self, connection: Connection) -> None:
        """Keep the connection."""
        self._connection = connection

    def on_message(self, topic: str, data: bytes) -> None:
        """Note how far the flight is."""
        if topic == "flight_state":
            self._newest = TOPICS[topic].layout.stamp(data)

    def turn(self) -> float:
        """Acknowledge what has come."""
        if self._connection is not None and self._newest - self._acknowledged >= ACKNOWLEDGE_NS:
            self._acknowledged = self._newest
            self._connection.publish([zeros("recorder_ack", self._newest)])
        return 0.02

    def close(self) -> None:
        """Nothing to finish."""


def build(name: str) -> Build:
    """How to make the program of a node."""

    def program(node: Node, _running: tuple[str, ...]) -> Program:
        if name == BENCH_SIM:
            return Bench(bool(declare_integer(node, "paced", 0, "1: by the clock", 0, 1)))
        return Recorder() if name == RECORDER else ComponentProgram(Echo(name))

    return program


def main() -> None:
    """One node of the floor, or all."""
    name, *arguments = sys.argv[1:]
    if name == COMPOSED_PROCESS:
        sys.exit(run_nodes({each: (build(each), arguments) for each in (BENCH_SIM, RECORDER, *REAL)}))
    sys.exit(run_node(name, build(name), arguments))


if __name__ == "__main__":
    main()
