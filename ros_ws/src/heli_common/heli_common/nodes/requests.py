"""What was asked of a node in flight, told on `diagnostics` with the stamp at which it acts (spec 6.4).

The recorder keeps `diagnostics`, so a flight in which somebody set a parameter or called a service can be
replayed from its bag.
"""

from __future__ import annotations

from heli_common.nodes.connection import Connection

REQUEST = "request"
"""Key of the request's text among the values of a status."""


class Requests:
    """Requests that were accepted and have not been told yet."""

    def __init__(self) -> None:
        self._accepted: list[str] = []

    def add(self, text: str) -> None:
        """A request was accepted; it acts with the node's next output."""
        self._accepted.append(text)

    def tell(self, connection: Connection | None, stamp_ns: int, text: str = REQUEST) -> None:
        """The output of this stamp has been sent: what was accepted before has acted with it.

        Args:
            connection: of the node.
            stamp_ns: of the output.
            text: for people.
        """
        if connection is None:
            return
        for request in self._accepted:
            connection.diagnose(stamp_ns, "ok", text, {REQUEST: request})
        self._accepted.clear()
