"""Playing a bag into the graph, paced by the wall clock; pauses, steps and changes its rate when asked to."""

from __future__ import annotations

import sys
from collections.abc import Callable
from time import perf_counter

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from heli_common.component import Message
from heli_common.errors import InputError
from heli_common.nodes.connection import Connection
from heli_flight.nodes.keys import Keys
from heli_flight.playback import MAXIMUM_RATE, MINIMUM_RATE, Playback, check_rate

REPLAY = "replay"
CLOCK = "clock"
READY_SECONDS = 0.02
TURN_SECONDS = 0.05
RATE_STEP = 1.1
KEYS_TEXT = "space: pause, resume; right: next stamp; up, down: faster, slower"

Recorded = tuple[int, str, bytes]
"""Stamp [ns], topic, serialized message."""


class ReplayProgram:
    """Publishes messages at the distances of their stamps, and the clock after all messages of a stamp.

    Services (std_srvs/Trigger): `~/pause`, `~/resume`, `~/toggle_paused`, `~/is_paused`, `~/play_next`;
    parameter `rate`, which may be set at any time; the same by keys in a terminal.

    Args:
        node: of the player.
        messages: what is played, in the order of playing.
        topics: that are played.
        playback: its time.
    """

    name = REPLAY
    inputs: tuple[str, ...] = ()
    waking: tuple[str, ...] = ()
    ends = True

    def __init__(
        self, node: Node, messages: list[Recorded], topics: tuple[str, ...], playback: Playback
    ) -> None:
        self.outputs = (*topics, CLOCK)
        self.finished = not messages
        self._messages = messages
        self._playback = playback
        self._next = 0
        self._connection: Connection | None = None
        self._keys = Keys()
        self._node = node
        words: dict[str, Callable[[], tuple[bool, str]]] = {
            "pause": self.pause,
            "resume": self.resume,
            "toggle_paused": self.toggle_paused,
            "is_paused": lambda: (playback.paused, self._where()),
            "play_next": self.play_next,
        }
        self._services = [
            node.create_service(Trigger, f"~/{name}", _answer(do)) for name, do in words.items()
        ]
        node.add_on_set_parameters_callback(self._on_parameters)

    def start(self, connection: Connection) -> None:
        """The first message follows when every node of this graph has said that it is ready."""
        self._connection = connection
        if self._keys.open:
            self._say(KEYS_TEXT)
        if self._playback.paused:
            self._say(self._where())

    def on_message(self, topic: str, data: bytes) -> None:
        """Nothing is listened to."""

    def pause(self) -> tuple[bool, str]:
        """Let time rest."""
        self._playback.pause(perf_counter())
        return True, self._say(self._where())

    def resume(self) -> tuple[bool, str]:
        """Go on."""
        self._playback.resume(perf_counter())
        return True, self._say(self._where())

    def toggle_paused(self) -> tuple[bool, str]:
        """Go on or let time rest."""
        return self.resume() if self._playback.paused else self.pause()

    def play_next(self) -> tuple[bool, str]:
        """While paused, publish everything of the next stamp."""
        if not self._playback.paused:
            return False, "not paused"
        if self._connection is None or self._connection.absent() or self.finished:
            return False, "nothing can be played now"
        stamp_ns = self._messages[self._next][0]
        self._playback.skip_to(stamp_ns, perf_counter())
        self._play_until(stamp_ns)
        return True, self._say(self._where())

    def turn(self) -> float:
        """Publish what is due; returns how long until the next message [s]."""
        if self._connection is None or self._connection.absent():
            return READY_SECONDS
        self._playback.begin(perf_counter())
        self._obey_keys()
        while not self.finished:
            stamp_ns = self._messages[self._next][0]
            wait = self._playback.wait(stamp_ns, perf_counter())
            if wait > 0.0:
                return min(wait, TURN_SECONDS)
            self._play_until(stamp_ns)
        return READY_SECONDS

    def close(self) -> None:
        """Give the terminal back."""
        self._keys.close()

    def _play_until(self, stamp_ns: int) -> None:
        assert self._connection is not None
        messages = self._messages
        while self._next < len(messages) and messages[self._next][0] <= stamp_ns:
            _, topic, data = messages[self._next]
            self._connection.publish_serialized(topic, data)
            self._next += 1
        self._connection.publish([Message(CLOCK, stamp_ns, ())])
        self.finished = self._next == len(messages)

    def _obey_keys(self) -> None:
        for key in self._keys.pressed():
            if key == " ":
                self.toggle_paused()
            elif key == "right":
                self.play_next()
            elif key in ("up", "down"):
                factor = RATE_STEP if key == "up" else 1.0 / RATE_STEP
                rate = min(MAXIMUM_RATE, max(MINIMUM_RATE, self._playback.rate * factor))
                self._node.set_parameters([Parameter("rate", value=rate)])

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == "rate":
                try:
                    self._playback.set_rate(check_rate(parameter.value), perf_counter())
                except InputError as error:
                    return SetParametersResult(successful=False, reason=str(error))
                self._say(self._where())
        return SetParametersResult(successful=True)

    def _where(self) -> str:
        seconds = self._playback.position_ns(perf_counter()) * 1e-9
        state = "paused" if self._playback.paused else f"playing {self._playback.rate:g} x"
        return f"{state} at {seconds:.3f} s"

    @staticmethod
    def _say(text: str) -> str:
        sys.stdout.write(f"{text}\n")
        sys.stdout.flush()
        return text


def declare_rate(node: Node) -> float:
    """Declare the rate, which may be set while playing.

    Raises:
        InputError: it is no number or out of range.
    """
    about = "simulated seconds per second; may be set while playing"
    descriptor = ParameterDescriptor(description=about, dynamic_typing=True)
    descriptor.additional_constraints = f"{MINIMUM_RATE:g} .. {MAXIMUM_RATE:g}"
    return check_rate(node.declare_parameter("rate", 1.0, descriptor).value)


def _answer(
    do: Callable[[], tuple[bool, str]],
) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
    def handle(_request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = do()
        return response

    return handle
