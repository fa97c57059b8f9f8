"""The attitude controller on the graph: says which controller flies and takes another one in flight."""

from __future__ import annotations

from heli_common.nodes.requests import Requests
from heli_common.nodes.runner import ComponentProgram
from heli_control.attitude_control import AttitudeController
from heli_control.controller_file import load_controller


class AttitudeProgram(ComponentProgram):
    """An attitude controller with a report of every change of controller, and of the file of one asked for.

    Args:
        controller: the component.
        plant: hash of the plant that controllers must be for; empty: any.
    """

    def __init__(self, controller: AttitudeController, plant: str) -> None:
        super().__init__(controller)
        self._controller, self._plant = controller, plant
        self._told = controller.exchanged
        self._requests = Requests()

    def request(self, name: str | float) -> None:
        """Fly another controller from the next sample on.

        Args:
            name: of a shipped controller, or path of a controller file.

        Raises:
            InputError: it cannot be flown; the one before goes on.
        """
        file = load_controller(str(name), self._plant)
        self._controller.replace(file)
        self._requests.add(file.to_yaml())

    def on_message(self, topic: str, data: bytes) -> None:
        """Act on a message; tell people when another controller has begun to fly."""
        super().on_message(topic, data)
        exchanged = self._controller.exchanged
        if exchanged is not None and exchanged is not self._told and self.connection is not None:
            self._told = exchanged
            stamp_ns, name = exchanged
            self.connection.diagnose(stamp_ns, "ok", f"controller {name} flies")
            self._requests.tell(self.connection, stamp_ns, f"controller {name} was asked for")
