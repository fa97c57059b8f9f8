"""What a node does between start and end, whatever runs it: alone in a process or composed with others."""

from __future__ import annotations

from typing import Protocol

from heli_common.component import Component, Message, update_of
from heli_common.nodes.connection import Connection
from heli_common.topics import TOPICS

TURN_SECONDS = 0.1


class Program(Protocol):
    """What a node does between start and end; all calls come from one thread.

    Attributes:
        name: what the node is in the table of topics.
        inputs: topics that it hears.
        outputs: topics that it speaks on.
        waking: inputs that come last in a burst, see `Inbox`; none for a node that looks every now and then:
            it keeps messages and acts on them in `turn`.
        ends: whether it ends by itself when the flight is over; composed nodes wait for those that do.
        finished: whether it has nothing more to do.
    """

    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    waking: tuple[str, ...]
    ends: bool

    def start(self, connection: Connection) -> None:
        """The graph is wired: the program may publish from now on."""
        ...

    def on_message(self, topic: str, data: bytes) -> None:
        """A serialized message of an input topic."""
        ...

    def turn(self) -> float:
        """Called between two looks at the inbox; returns for how long the next may wait [s]."""
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

    ends = False

    def __init__(self, component: Component) -> None:
        self.component = component
        self.name, self.inputs, self.outputs = component.name, component.inputs, component.outputs
        self.waking: tuple[str, ...] = getattr(component, "waking", component.inputs)
        self.finished = False
        self._unpack = {topic: TOPICS[topic].layout.unpack for topic in component.inputs}
        self._update = update_of(component)
        self.connection: Connection | None = None

    def start(self, connection: Connection) -> None:
        """Keep the connection for publishing."""
        self.connection = connection

    def on_message(self, topic: str, data: bytes) -> None:
        """Hand the numbers to the component and publish what it gives back, then what could wait."""
        stamp_ns, values = self._unpack[topic](data)
        self.publish(self.component.receive(topic, stamp_ns, values))
        self.publish(self._update())

    def publish(self, messages: list[Message]) -> None:
        """Send messages of the component."""
        if messages and self.connection is not None:
            self.connection.publish(messages)

    def turn(self) -> float:
        """Nothing to do between messages."""
        return TURN_SECONDS

    def close(self) -> None:
        """Nothing to finish."""
