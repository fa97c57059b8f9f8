"""Runs programs as ROS 2 nodes: main loop, signals, readiness, failure and exit code (spec 7.2, 7.4).

A node has a process of its own, or several share one (composed). Data messages are taken by hand (`Inbox`);
the executor serves what is not urgent: parameters, services, diagnostics. The loop never waits without a
timeout and ends on a flag that its own signal handlers set, so that a node can drain what it holds.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import monotonic

from heli_common.nodes.signals import STOP

STOP.install()

import rclpy  # noqa: E402  (signal handlers first: rclpy's own would tear the context down)
from rclpy.exceptions import ROSInterruptException  # noqa: E402
from rclpy.executors import ExternalShutdownException  # noqa: E402
from rclpy.experimental import EventsExecutor  # noqa: E402
from rclpy.impl.implementation_singleton import rclpy_implementation  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.signals import SignalHandlerOptions  # noqa: E402
from rclpy.task import Future  # noqa: E402

from heli_common.errors import EXIT_BAD_INPUT, EXIT_FLOWN, InputError  # noqa: E402
from heli_common.nodes.intra_process import IntraProcess  # noqa: E402
from heli_common.nodes.node_run import WIRING_SECONDS, NodeRun  # noqa: E402
from heli_common.nodes.parameters import declare_integer, declare_names  # noqa: E402
from heli_common.nodes.program import ComponentProgram, Program  # noqa: E402
from heli_common.nodes.scheduling import become_real_time, stay_on  # noqa: E402

__all__ = ["Build", "ComponentProgram", "Program", "run_node", "run_nodes"]

MIDDLEWARE = Path(__file__).with_name("fastdds.xml")
"""Settings of the middleware, unless the environment names others."""

WAIT_SECONDS = 0.02
"""Longest wait for data: parameters and services are looked after as often as that."""

FREE_SECONDS = 0.0005
"""Parameters and services take less; before an instant that is nearer they wait, if not for long."""

MOST_CORES = 8191
"""Highest number that Linux gives to a core."""

QUIET = ("--ros-args", "--disable-stdout-logs", "--disable-external-lib-logs")

Build = Callable[[Node, tuple[str, ...]], Program]
"""Gets the node and the names of the nodes of its graph, declares parameters and makes the program."""


def run_node(name: str, build: Build, arguments: list[str] | None = None) -> int:
    """Run a node to its end.

    Args:
        name: node name, as in the table of topics.
        build: of the program; may raise InputError.
        arguments: ROS arguments, by default those of the command line.

    Returns:
        exit code: 0 done or asked to stop, 2 bad input, 3 safety stop.
    """
    words = sys.argv if arguments is None else [name, *arguments]
    return _run(words, {name: (build, None)})


def run_nodes(builds: Mapping[str, tuple[Build, Sequence[str]]]) -> int:
    """Run several nodes in this process, one after the other in one thread, to the end of all.

    They hand each other their messages without the middleware, see `IntraProcess`.

    Args:
        builds: of each node by its name: how to build its program, and its ROS arguments.

    Returns:
        exit code of the first that failed, see `run_node`.
    """
    return _run([sys.argv[0]], dict(builds))


def _run(words: Sequence[str], builds: Mapping[str, tuple[Build, Sequence[str] | None]]) -> int:
    who = " ".join(builds) if len(builds) == 1 else "composed"
    os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(MIDDLEWARE))
    try:
        rclpy.init(args=[*words, *QUIET], signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy has a class of its own for each kind of wrong argument
        sys.stderr.write(f"{who}: {str(error).splitlines()[0]}\n")
        return EXIT_BAD_INPUT
    nodes: list[Node] = []
    runs: list[NodeRun] = []
    priority, core = 0, -1
    try:
        for who, (build, arguments) in builds.items():
            own = {} if arguments is None else {"cli_args": list(arguments), "use_global_arguments": False}
            nodes.append(rclpy.create_node(who, **own))
            text = "SCHED_FIFO priority, 0 for none"
            own_priority = declare_integer(nodes[-1], "real_time_priority", 0, text, 0, 90)
            priority = max(priority, own_priority)  # one process has one
            text = "core of the machine that its process stays on, -1 for any"
            core = max(core, declare_integer(nodes[-1], "core", -1, text, -1, MOST_CORES))
            text = "nodes of this graph, comma-separated: publishers wait for those among them that listen"
            running = declare_names(nodes[-1], "running", text)
            runs.append(NodeRun(nodes[-1], build(nodes[-1], running), running))
        _Loop(runs).run(priority, core)
        return next((run.code for run in runs if run.code), EXIT_FLOWN)
    except (InputError, rclpy.exceptions.ParameterException) as error:
        sys.stderr.write(f"{who}: {error}\n")
        return EXIT_BAD_INPUT
    except (KeyboardInterrupt, ExternalShutdownException, ROSInterruptException):
        return EXIT_FLOWN
    finally:
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()


class _Loop:
    """Programs in one thread: turns, messages, and now and then the executor."""

    def __init__(self, runs: Sequence[NodeRun]) -> None:
        self._runs = runs
        self._own = IntraProcess(runs)
        self._awake = [run for run in runs if run.program.waking] or runs
        self._executor = EventsExecutor()
        self._never: Future[None] = Future()
        size = sum(len(run.inbox.awaited) for run in runs)
        self._set = rclpy_implementation.WaitSet(size, 0, 0, 0, 0, 0, runs[0].node.context.handle)
        for run in runs:
            self._executor.add_node(run.node)

    def run(self, priority: int, core: int) -> None:
        """Until a signal, a failure or the end of those that end by themselves.

        The flight begins when all nodes have said that they are ready, so scheduling comes before that: the
        collection of garbage takes longer than a control period.
        """
        try:
            self._serve_until(NodeRun.wired)
            if not self._over:
                self._schedule(priority, core)
                self._serve(0.0)  # another node of this name may have spoken meanwhile
            self._serve_until(NodeRun.start)
            self._turns()
            for run in self._runs:
                run.tell_failure()
        finally:
            for run in self._runs:
                run.close()
            self._set.destroy_when_not_in_use()
            self._executor.shutdown()

    def _serve_until(self, done: Callable[[NodeRun], bool]) -> None:
        """Until all have done it, or the end."""
        while not self._over and not all(done(run) for run in self._runs):
            self._serve(WIRING_SECONDS)

    def _turns(self) -> None:
        """Programs act, wait, take in turn; those that wait for no message and the executor now and then."""
        idle, serve_at = True, 0.0
        self._own.look_outside()
        while not self._over:
            now = monotonic()
            runs = self._runs if idle or now >= serve_at else self._awake
            seconds = min(run.turn() for run in runs)
            if now >= serve_at and (seconds >= FREE_SECONDS or now >= serve_at + WAIT_SECONDS):
                self._serve(0.0)
                self._own.look_outside()
                serve_at = monotonic() + WAIT_SECONDS
                continue
            if not self._own and (idle or len(self._runs) == 1):
                self._wait(min(seconds, WAIT_SECONDS))
            delivered = self._own.deliver()
            taken = sum([run.take() for run in runs])
            idle = not delivered and not taken
            if idle:
                for run in self._runs:
                    run.inbox.incomplete()

    def _wait(self, seconds: float) -> None:
        """Until a message that somebody waits for has come, or the time is over."""
        awaited = [handle for run in self._runs for handle in run.inbox.awaited]
        if not awaited:
            self._serve(seconds)
            return
        self._set.clear_entities()
        for handle in awaited:
            self._set.add_subscription(handle)
        self._set.wait(int(seconds * 1e9))

    @property
    def _over(self) -> bool:
        if STOP or any(run.failure for run in self._runs):
            return True
        programs = [run.program for run in self._runs]
        ending = programs if len(programs) == 1 else [program for program in programs if program.ends]
        return bool(ending) and all(program.finished for program in ending)

    def _serve(self, seconds: float) -> None:
        self._executor.spin_until_future_complete(self._never, timeout_sec=seconds)

    def _schedule(self, priority: int, core: int) -> None:
        name = self._runs[0].program.name
        if refused := become_real_time(priority):
            sys.stderr.write(f"{name}: warning: {refused}; ordinary scheduling\n")
        if refused := stay_on(core):
            sys.stderr.write(f"{name}: warning: {refused}; any core\n")
