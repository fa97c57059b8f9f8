"""identification: excites the flying helicopter and estimates its coefficients while it flies."""

from __future__ import annotations

import sys

from heli_common.nodes.runner import ComponentProgram, run_node  # first: it takes the signals before rclpy

# isort: split
from rclpy.node import Node

from heli_common.nodes.parameters import declare_parameters, declare_request, declare_text
from heli_common.nodes.requests import Requests
from heli_common.topics import IDENTIFICATION
from heli_identification.excitation_guard import GuardParameters
from heli_identification.excitation_words import excitations_from_text
from heli_identification.identifier import Identifier
from heli_identification.running_estimate import EstimateParameters


class IdentificationProgram(ComponentProgram):
    """The component on the graph; what it has to say goes to diagnostics."""

    def __init__(self, identifier: Identifier) -> None:
        super().__init__(identifier)
        self._identifier = identifier
        self._requests = Requests()

    def request(self, text: str) -> None:
        """Excite, or stop exciting, from the next control tick on.

        Raises:
            InputError: it is not allowed.
        """
        self._identifier.request(text)
        self._requests.add(text)

    def on_message(self, topic: str, data: bytes) -> None:
        """Act, then tell people about it."""
        stamp_ns, values = self._unpack[topic](data)
        sent = self.component.receive(topic, stamp_ns, values)
        self.publish(sent)
        if sent and topic != "servo_command":
            self._requests.tell(self.connection, stamp_ns)
        remarks = self._identifier.remarks
        while remarks and self.connection is not None:
            level, text = remarks.pop(0)
            self.connection.diagnose(stamp_ns, level, text)


def build(node: Node, _running: tuple[str, ...]) -> IdentificationProgram:
    """Declare parameters and build the identification.

    Raises:
        InputError: an excitation or a parameter is not allowed.
    """
    plan = declare_text(node, "excitations", "[]", "what the plan's excite phases say, in order (YAML)")
    guard = declare_parameters(node, GuardParameters, "guard.")
    estimate = declare_parameters(node, EstimateParameters, "estimate.")
    identifier = Identifier(excitations_from_text(plan), guard, estimate)
    about = "set it to excite now, e.g. {signal: prbs, channel: B_1s, amplitude_deg: 0.5, "
    about += "band_rad_s: [0.5, 12], duration: 20}; an empty text stops"
    program = IdentificationProgram(identifier)
    declare_request(node, "excite", "", about, lambda text: program.request(str(text)))
    return program


def main() -> None:
    """Entry point of the node."""
    sys.exit(run_node(IDENTIFICATION, build))


if __name__ == "__main__":
    main()
