"""Runs one program as a ROS 2 node: main loop, signals, readiness, failure and exit code (spec 7.2, 7.4).

The main loop never waits without a timeout, which the events executor of this rclpy does not survive, and
ends on a flag that its own signal handlers set, so that a node can drain what it holds.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Protocol

from heli_common.nodes.signals import STOP

STOP.install()

import rclpy  # noqa: E402  (signal handlers first: rclpy's own would tear the context down)
from rclpy.exceptions import ROSInterruptException  # noqa: E402
from rclpy.executors import ExternalShutdownException  # noqa: E402
from rclpy.experimental import EventsExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.signals import SignalHandlerOptions  # noqa: E402
from rclpy.task import Future  # noqa: E402

from heli_common.component import Component, Message  # noqa: E402
from heli_common.errors import (  # noqa: E402
    EXIT_BAD_INPUT,
    EXIT_FLOWN,
    EXIT_SAFETY_STOP,
    InputError,
    SafetyStop,
)
from heli_common.nodes.connection import Connection  # noqa: E402
from heli_common.nodes.parameters import declare_integer, declare_names  # noqa: E402
from heli_common.nodes.scheduling import become_real_time  # noqa: E402
from heli_common.topics import TOPICS  # noqa: E402

MIDDLEWARE = Path(__file__).with_name("fastdds.xml")
"""Settings of the middleware, unless the environment names others."""

TURN_SECONDS = 0.1
WIRING_SECONDS = 0.01


class Program(Protocol):
    """What a node does between start and end; all calls come from one thread."""

    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def start(self, connection: Connection) -> None:
        """The graph is wired: the program may publish from now on."""
        ...

    def on_message(self, topic: str, data: bytes) -> None:
        """A serialized message of an input topic."""
        ...

    def turn(self) -> float:
        """Called between two turns of the executor; returns for how long the next may last [s]."""
        ...

    def close(self) -> None:
        """The node ends, for whatever reason: finish files."""
        ...

    @property
    def finished(self) -> bool:
        """Whether the node has nothing more to do."""
        ...


class ComponentProgram:
    """A component on the graph: unpack, receive, publish."""

    def __init__(self, component: Component) -> None:
        self.component = component
        self.name, self.inputs, self.outputs = component.name, component.inputs, component.outputs
        self.finished = False
        self._unpack = {topic: TOPICS[topic].layout.unpack for topic in component.inputs}
        self.connection: Connection | None = None

    def start(self, connection: Connection) -> None:
        """Keep the connection for publishing."""
        self.connection = connection

    def on_message(self, topic: str, data: bytes) -> None:
        """Hand the numbers to the component and publish what it gives back."""
        stamp_ns, values = self._unpack[topic](data)
        self.publish(self.component.receive(topic, stamp_ns, values))

    def publish(self, messages: list[Message]) -> None:
        """Send messages of the component."""
        if messages and self.connection is not None:
            self.connection.publish(messages)

    def turn(self) -> float:
        """Nothing to do between messages."""
        return TURN_SECONDS

    def close(self) -> None:
        """Nothing to finish."""


class _Guard:
    """Turns what goes wrong inside a callback into one line and an exit code."""

    def __init__(self) -> None:
        self.failure = ""
        self.code = EXIT_FLOWN

    def call(self, function: Callable[..., object], *arguments: object) -> object:
        if self.failure:
            return None
        try:
            return function(*arguments)
        except InputError as error:
            self.failure, self.code = str(error), EXIT_BAD_INPUT
        except (SafetyStop, TimeoutError, ValueError, ArithmeticError, OSError) as error:
            self.failure, self.code = str(error), EXIT_SAFETY_STOP
        return None


Build = Callable[[Node, tuple[str, ...]], Program]


def run_node(name: str, build: Build, arguments: list[str] | None = None) -> int:
    """Run a node to its end.

    Args:
        name: node name, as in the table of topics.
        build: gets the node and the names of the nodes of its graph, declares parameters and makes the
            program; may raise InputError.
        arguments: ROS arguments, by default those of the command line.

    Returns:
        exit code: 0 done or asked to stop, 2 bad input, 3 safety stop.
    """
    words = sys.argv if arguments is None else [name, *arguments]
    quiet = ["--ros-args", "--disable-stdout-logs", "--disable-external-lib-logs"]
    os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(MIDDLEWARE))
    try:
        rclpy.init(args=[*words, *quiet], signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy has a class of its own for each kind of wrong argument
        sys.stderr.write(f"{name}: {str(error).splitlines()[0]}\n")
        return EXIT_BAD_INPUT
    node = None
    code = EXIT_FLOWN
    try:
        node = rclpy.create_node(name)
        priority = declare_integer(node, "real_time_priority", 0, "SCHED_FIFO priority, 0 for none", 0, 90)
        text = "nodes of this graph, comma-separated: publishers wait for those among them that listen"
        running = declare_names(node, "running", text)
        code = _run(node, build(node, running), running, priority)
    except (InputError, rclpy.exceptions.ParameterException) as error:
        sys.stderr.write(f"{name}: {error}\n")
        code = EXIT_BAD_INPUT
    except (KeyboardInterrupt, ExternalShutdownException, ROSInterruptException):
        pass
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return code


def _schedule(name: str, priority: int) -> None:
    refused = become_real_time(priority)
    if refused:
        sys.stderr.write(f"{name}: warning: {refused}; ordinary scheduling\n")


def _close(program: Program, guard: _Guard) -> None:
    try:
        program.close()
    except OSError as error:
        sys.stderr.write(f"{program.name}: {error}\n")
        guard.code = EXIT_SAFETY_STOP


def _run(node: Node, program: Program, running: tuple[str, ...], priority: int) -> int:
    guard = _Guard()
    on_message = partial(guard.call, program.on_message)
    connection = Connection(node, program.name, running, program.inputs, program.outputs, on_message)
    executor = EventsExecutor()
    executor.add_node(node)
    never = Future()
    started = False
    try:
        while not STOP and not guard.failure and not program.finished:
            timeout = WIRING_SECONDS
            if started:
                timeout = guard.call(program.turn) or WIRING_SECONDS  # type: ignore[assignment]
            elif guard.call(connection.open):
                started = True
                _schedule(program.name, priority)
                guard.call(program.start, connection)
            executor.spin_until_future_complete(never, timeout_sec=timeout)
        if guard.failure:
            sys.stderr.write(f"{program.name}: {guard.failure}\n")
            connection.diagnose(0, "error", guard.failure)
        connection.flush()
    finally:
        _close(program, guard)
        executor.shutdown()
    return guard.code
