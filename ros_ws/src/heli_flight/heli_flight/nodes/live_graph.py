"""A node that looks at the graph around it: who is there, what is said, and what is answered."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable
from time import monotonic
from types import TracebackType
from typing import Any, TypeVar

from heli_common.nodes.runner import MIDDLEWARE  # first: it takes the signals before rclpy does

# isort: split
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden

from heli_common.errors import InputError
from heli_common.nodes.signals import STOP

SETTLED_SECONDS = 0.6
"""The graph is known when nothing has changed for so long."""

PATIENCE_SECONDS = 4.0
"""How long to look for a name, or for any node at all."""

ANSWER_SECONDS = 10.0
_TURN_SECONDS = 0.05
_DEPTH = 1000

Found = TypeVar("Found")
Names = dict[str, list[str]]


class LiveGraph:
    """A hidden node without services or parameters of its own; to be used in a `with`."""

    def __enter__(self) -> LiveGraph:
        os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(MIDDLEWARE))
        quiet = ["--ros-args", "--disable-stdout-logs", "--disable-external-lib-logs"]
        rclpy.init(args=quiet, signal_handler_options=SignalHandlerOptions.NO)
        name = f"_heli_{os.getpid()}"
        self.node = Node(name, start_parameter_services=False, enable_rosout=False)
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown()

    # Who is there --------------------------------------------------------------------------------------

    def nodes(self) -> list[str]:
        """Full names of the other nodes, without hidden ones."""
        pairs = self.node.get_node_names_and_namespaces()
        return sorted(f"{space.rstrip('/')}/{name}" for name, space in pairs if not name.startswith("_"))

    def topics(self) -> Names:
        """Types of every topic by its name, without hidden ones."""
        return _visible(self.node.get_topic_names_and_types())

    def services(self) -> Names:
        """Types of every service by its name, without hidden ones."""
        return _visible(self.node.get_service_names_and_types())

    def settle(self) -> None:
        """Look until nothing has changed for a while.

        Raises:
            InputError: nobody is there.
        """
        seen: object = None
        since = started = monotonic()
        while monotonic() - since < SETTLED_SECONDS or not self.nodes():
            self.turn()
            now = (self.nodes(), self.topics(), self.services())
            if now != seen:
                seen, since = now, monotonic()
            if not self.nodes() and monotonic() - started > PATIENCE_SECONDS:
                raise nobody()

    def require(self, name: str, names: Callable[[], Iterable[str]], words: str) -> str:
        """The full form of a name, as soon as it is there.

        Args:
            name: with or without the leading slash.
            names: gives those that are there.
            words: put before the name if it is not.

        Raises:
            InputError: no such name, or nobody is there.
        """
        full = f"/{name.lstrip('/')}"
        if not self.wait(lambda: full in names(), PATIENCE_SECONDS):
            if not self.nodes():
                raise nobody()
            near = difflib.get_close_matches(full, list(names()), n=3)
            raise InputError(f"{words} '{full}'", allowed=", ".join(near))
        return full

    # What is said and answered -------------------------------------------------------------------------

    def listen(self, topic: str, kind: Any, hear: Callable[[Any], None], raw: bool) -> None:
        """Subscribe as reliably and as late as every publisher of the topic allows."""
        offered = [end.qos_profile for end in self.node.get_publishers_info_by_topic(topic)]
        reliable = all(each.reliability is ReliabilityPolicy.RELIABLE for each in offered)
        latched = bool(offered) and all(
            each.durability is DurabilityPolicy.TRANSIENT_LOCAL for each in offered
        )
        profile = QoSProfile(
            depth=_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        self.node.create_subscription(kind, topic, hear, profile, raw=raw)

    def ask(self, kind: Any, service: str, request: Any) -> Any:
        """Call a service and give back its response.

        Raises:
            InputError: it does not answer.
        """
        client = self.node.create_client(kind, service)
        if not self.wait(client.service_is_ready, PATIENCE_SECONDS):
            raise InputError(f"service '{service}' is not ready after {PATIENCE_SECONDS:.0f} s")
        future = client.call_async(request)
        if not self.wait(future.done, ANSWER_SECONDS):
            raise InputError(f"service '{service}' has not answered for {ANSWER_SECONDS:.0f} s")
        return future.result()

    def wait(self, condition: Callable[[], Found], seconds: float) -> Found:
        """The condition's value, as soon as it is true or the time is over.

        Raises:
            KeyboardInterrupt: asked to stop meanwhile.
        """
        deadline = monotonic() + seconds
        while not (value := condition()) and monotonic() < deadline:
            self.turn()
        return value

    def turn(self) -> None:
        """Take in what comes for a moment.

        Raises:
            KeyboardInterrupt: asked to stop.
        """
        if STOP:
            raise KeyboardInterrupt
        self._executor.spin_until_future_complete(Future(), timeout_sec=_TURN_SECONDS)


def nobody() -> InputError:
    """There is no graph."""
    domain = os.environ.get("ROS_DOMAIN_ID", "0")
    return InputError(f"no node found in ROS_DOMAIN_ID {domain}", allowed="a running graph")


def _visible(names: Iterable[tuple[str, list[str]]]) -> Names:
    return {name: types for name, types in sorted(names) if not topic_or_service_is_hidden(name)}
