"""One flight, whichever way it runs."""

from __future__ import annotations

from collections.abc import Callable

from heli_flight.fly_graph import fly_graph
from heli_flight.mode import Mode
from heli_flight.order import FlightEnd, FlightOrder
from heli_flight.progress import Progress


def fly(order: FlightOrder, tell: Callable[[Progress], None], warn: Callable[[str], None]) -> FlightEnd:
    """Fly an order to its end and leave its bag.

    Args:
        order: what to fly.
        tell: called with every line of progress.
        warn: called with what a person should know.
    """
    if order.mode is Mode.INPROCESS:
        from heli_flight.fly_in_process import fly_in_process  # not needed on the graph, and slow to load

        return fly_in_process(order, tell)
    return fly_graph(order, tell, warn)
