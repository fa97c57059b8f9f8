"""One program on its ROS node: wiring, messages, failure."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TypeVar

from rclpy.node import Node

from heli_common.errors import EXIT_BAD_INPUT, EXIT_FLOWN, EXIT_SAFETY_STOP, InputError, SafetyStop
from heli_common.nodes.connection import Connection
from heli_common.nodes.program import Program

WIRING_SECONDS = 0.01

FAILURES = (InputError, SafetyStop, TimeoutError, ValueError, ArithmeticError, OSError)
"""What may go wrong in a program and ends it with one line; anything else is a mistake in the program."""

Result = TypeVar("Result")


class NodeRun:
    """A program and its connection; what goes wrong in it becomes one line and an exit code.

    Args:
        node: of the program.
        program: to be run.
        running: the nodes of its graph.

    Attributes:
        code: exit code so far.
        failure: why the program stopped, empty while it runs.
        started: whether the node has said that it is ready, and acts.
    """

    def __init__(self, node: Node, program: Program, running: tuple[str, ...]) -> None:
        self.node, self.program = node, program
        self.code, self.failure, self.started = EXIT_FLOWN, "", False
        topics = (program.inputs, program.outputs, program.waking)
        self.connection = Connection(node, program.name, running, *topics)
        self.inbox = self.connection.inbox

    def wired(self) -> bool:
        """Whether the graph is wired as far as this node needs it."""
        return self._guarded(self.connection.wired, False)

    def start(self) -> bool:
        """Whether the node has said that it is ready, and acts; it does both as soon as it is wired."""
        if not self.started and self._guarded(self.connection.open, False):
            self.started = True
            self._guarded(lambda: self.program.start(self.connection), None)
        return self.started

    def turn(self) -> float:
        """Let the program act between messages; returns for how long it may wait [s]."""
        return self._guarded(self.program.turn, WIRING_SECONDS)

    def take(self) -> int:
        """Hand over every message that has arrived; returns how many."""
        return self._guarded(lambda: self.connection.take(self.program.on_message), 0)

    def fail(self, error: Exception) -> None:
        """The program stops, for one of `FAILURES`."""
        self.failure = str(error)
        self.code = EXIT_BAD_INPUT if isinstance(error, InputError) else EXIT_SAFETY_STOP

    def tell_failure(self) -> None:
        """Say on standard error and on `diagnostics` why the program stopped."""
        if self.failure:
            sys.stderr.write(f"{self.program.name}: {self.failure}\n")
            self.connection.diagnose(0, "error", self.failure)
        self.connection.flush()

    def close(self) -> None:
        """Let the program finish its files and give the node back."""
        try:
            self.program.close()
        except OSError as error:
            sys.stderr.write(f"{self.program.name}: {error}\n")
            self.code = EXIT_SAFETY_STOP
        self.inbox.close()

    def _guarded(self, act: Callable[[], Result], otherwise: Result) -> Result:
        if self.failure:
            return otherwise
        try:
            return act()
        except FAILURES as error:
            self.fail(error)
        return otherwise
