"""A flight on the ROS 2 graph: a process for every node, or one for all; a parent watches and ends them."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

from heli_common import topics
from heli_common.errors import EXIT_BAD_INPUT, EXIT_FLOWN, EXIT_INTERRUPTED, EXIT_SAFETY_STOP
from heli_common.flight_state import FlightState
from heli_common.kernel_cache import is_warm
from heli_flight.mode import COMPOSED_PROCESS, Mode
from heli_flight.node_settings import FlightSettings
from heli_flight.order import FlightEnd, FlightOrder
from heli_flight.process_group import Line, ProcessGroup
from heli_flight.process_table import NODE_NAMES, Process, environment, processes
from heli_flight.progress import Progress, parse

READ_SECONDS = 0.1


def fly_graph(order: FlightOrder, tell: Callable[[Progress], None], warn: Callable[[str], None]) -> FlightEnd:
    """Fly an order on the graph to its end; its bag is left by the recorder.

    Args:
        order: what to fly.
        tell: called with every line of progress.
        warn: called with what a person should know: warnings of the nodes, or that kernels are compiled.
    """
    if not is_warm():
        from heli_flight.warm_up import warm_up  # loads all that compiles, which a graph needs no more

        warn("compiling kernels, once after each change of the sources")
        warm_up()
    started = perf_counter()
    with tempfile.TemporaryDirectory(prefix="heli_") as folder:
        notes = Path(folder) / "notes.json"
        notes.write_text(json.dumps(order.notes()))
        with ProcessGroup(_commands(order, notes), environment()) as group:
            watch = _Watch(group, tell, warn, order.mode)
            try:
                watch.until_over()
            except KeyboardInterrupt:
                watch.code, watch.reason = EXIT_INTERRUPTED, "interrupted"
            watch.take(group.stop())
    return FlightEnd(watch.code, watch.reason, watch.progress.time, perf_counter() - started)


def _commands(order: FlightOrder, notes: Path) -> dict[str, list[str]]:
    """Command lines of the processes of a flight, by the name of the process."""
    nodes = processes(order.identified)
    commands = {
        each.name: command(each, order, notes)
        for each in nodes
        if order.mode.process_of(each.name) == each.name
    }
    shared = {each.name: ros_arguments(each, order, notes) for each in nodes if each.name not in commands}
    if shared:
        file = notes.with_name("composed.json")
        file.write_text(json.dumps(shared))
        module = "heli_flight.nodes.composed_node"
        commands[COMPOSED_PROCESS] = [sys.executable, "-m", module, str(file)]
    return commands


def command(process: Process, order: FlightOrder, notes: Path) -> list[str]:
    """Command line of a node for a flight."""
    program = order.replaced.get(process.name)
    called = ("-m", process.module) if program is None else (str(program),)
    return [sys.executable, *called, *ros_arguments(process, order, notes)]


def ros_arguments(process: Process, order: FlightOrder, notes: Path) -> list[str]:
    """What a node of a flight is told."""
    words = ["--ros-args"]
    if order.namespace:
        words += ["-r", f"__ns:=/{order.namespace}"]
    if order.parameters is not None:
        words += ["--params-file", str(order.parameters)]
    for key, value in FlightSettings.of_order(order, str(notes)).of(process, order.running).items():
        words += ["-p", f"{key}:={json.dumps(value)}"]
    return words


class _Watch:
    """Reads what the nodes say and decides when the flight is over and how it ended."""

    def __init__(
        self,
        group: ProcessGroup,
        tell: Callable[[Progress], None],
        warn: Callable[[str], None],
        mode: Mode,
    ) -> None:
        self._group, self._tell, self._warn = group, tell, warn
        self._ending = {mode.process_of(node) for node in (topics.BENCH_SIM, topics.RECORDER)}
        self._spared: set[str] = set(topics.OPTIONAL_NODES) if mode is Mode.REALTIME else set()
        self._told: set[str] = set()
        self._warned: set[str] = set()
        self._last_error: dict[str, str] = {}
        self.progress = Progress(0.0, FlightState.IDLE, 0, 0)
        self.code, self.reason = EXIT_FLOWN, ""

    def until_over(self) -> None:
        """Until those that end by themselves have ended, or any node has failed."""
        while True:
            self.take(self._group.read(READ_SECONDS))
            exited = self._spare(self._group.exited())
            failed = {name: code for name, code in exited.items() if code != 0}
            if failed or exited.keys() - self._ending:
                self.take(self._group.stop())
                self._fail(failed or exited)
                return
            if self._ending <= exited.keys():
                if self.progress.state is FlightState.FAULT:
                    self.code, self.reason = EXIT_SAFETY_STOP, self.progress.reason
                return

    def _spare(self, exited: dict[str, int]) -> dict[str, int]:
        """Those exited without whom the flight cannot go on; of the others people are told once."""
        for name in sorted(self._spared & exited.keys()):
            if exited[name] == EXIT_BAD_INPUT:
                continue
            if name not in self._told:
                self._told.add(name)
                last = self._last_error.get(name, _how(name, exited[name]))
                self._warn(f"warning: {last}; the flight goes on without it")
            exited = {other: code for other, code in exited.items() if other != name}
        return exited

    def take(self, lines: list[Line]) -> None:
        """Sort lines into progress, warnings and the last words of a node."""
        for line in lines:
            progress = None if line.is_error else parse(line.text)
            if progress is not None:
                self.progress = progress
                self._tell(progress)
            elif line.is_error and (warning := line.text.partition(": warning: ")[2]):
                if warning not in self._warned:  # what holds for all nodes is said by the first
                    self._warned.add(warning)
                    self._warn(line.text)
            elif line.is_error and line.text.strip():
                self._last_error[line.process] = line.text.strip()

    def _fail(self, exited: dict[str, int]) -> None:
        order = [name for name in (*NODE_NAMES, COMPOSED_PROCESS) if name in exited]
        bad_input = [name for name in order if exited[name] == EXIT_BAD_INPUT]
        name = (bad_input or order)[0]
        self.reason = self._last_error.get(name, _how(name, exited[name]))
        self.code = EXIT_BAD_INPUT if bad_input else EXIT_SAFETY_STOP


def _how(name: str, code: int) -> str:
    return f"{name}: killed by signal {-code}" if code < 0 else f"{name}: ended with exit code {code}"
