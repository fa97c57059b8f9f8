"""The supervisor on the graph: its services, its words on diagnostics, and a line of progress for people."""

from __future__ import annotations

import sys

from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from heli_common.nodes.connection import Connection
from heli_common.nodes.qos import LATCHED
from heli_common.nodes.requests import Requests
from heli_common.nodes.runner import ComponentProgram
from heli_common.timing import CONTROL_PERIOD_NS
from heli_flight.progress import Progress
from heli_flight.supervisor import Supervisor

PROGRESS_TICKS = 50
SERVICES = ("home", "arm", "take_off", "land", "stop")


class SupervisorProgram(ComponentProgram):
    """A supervisor component with services and a report of every change of state."""

    def __init__(self, node: Node, supervisor: Supervisor) -> None:
        super().__init__(supervisor)
        self._supervisor = supervisor
        self._requests = Requests()
        self._ticks = 0
        self._reported = ""
        self._state = node.create_publisher(String, "state", LATCHED)
        self._services = [node.create_service(Trigger, name, self._handler(name)) for name in SERVICES]

    def _handler(self, name: str):  # type: ignore[no-untyped-def]
        def handle(_request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            response.success, response.message = self._supervisor.command(name)
            if response.success:
                self._requests.add(name)
            return response

        return handle

    def set_wind(self, speed: float) -> None:
        """Command the wind generator.

        Raises:
            InputError: see `Supervisor.set_wind`.
        """
        self._supervisor.set_wind(speed)
        self._requests.add(f"wind {speed!r}")

    def start(self, connection: Connection) -> None:
        """The graph is wired: say which state the flight is in."""
        super().start(connection)
        self._report(0)

    def on_message(self, topic: str, data: bytes) -> None:
        """Advance the flight and tell people about it."""
        stamp_ns, values = self._unpack[topic](data)
        sent = self.component.receive(topic, stamp_ns, values)
        self.publish(sent)
        if not sent:
            return
        self._requests.tell(self.connection, stamp_ns)
        self._ticks += 1
        if self._supervisor.state.word != self._reported:
            self._report(stamp_ns)
        elif self._ticks % PROGRESS_TICKS == 0:
            self._tell(stamp_ns)

    def _report(self, stamp_ns: int) -> None:
        state, reason = self._supervisor.state, self._supervisor.reason
        self._reported = state.word
        self._state.publish(String(data=state.word))
        if self.connection is not None:
            text = f"{state.word}: {reason}" if reason else state.word
            self.connection.diagnose(stamp_ns, "error" if reason else "ok", text)
        self._tell(stamp_ns)

    def _tell(self, stamp_ns: int) -> None:
        supervisor = self._supervisor
        seconds = (stamp_ns // CONTROL_PERIOD_NS) * CONTROL_PERIOD_NS * 1e-9
        phases = len(supervisor.plan.phases) if supervisor.plan else 0
        progress = Progress(seconds, supervisor.state, supervisor.phase, phases, supervisor.reason)
        sys.stdout.write(progress.line() + "\n")
        sys.stdout.flush()
