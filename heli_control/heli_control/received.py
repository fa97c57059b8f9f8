"""What controllers read from messages beside the odometry."""

from __future__ import annotations

from collections.abc import Sequence

from heli_common.flight_state import FlightState, flight_state_from_code
from heli_common.topics import TOPICS

_FLIGHT_STATE = TOPICS["flight_state"].layout.fields.index("position.flight_state")
_CONTROLLER = TOPICS["flight_state"].layout.fields.index("position.controller")
_ROTOR_REFERENCE = TOPICS["flight_state"].layout.fields.index("velocity.rotor")


def flight_state(values: Sequence[float]) -> tuple[FlightState, float]:
    """Stage of the flight and rotor speed reference [rad/s] from the numbers of `flight_state`.

    Raises:
        ValueError: no such stage.
    """
    return flight_state_from_code(values[_FLIGHT_STATE]), values[_ROTOR_REFERENCE]


def planned_controller(values: Sequence[float], known: int) -> int:
    """Which of the plan's controllers shall fly, from the numbers of `flight_state`.

    Args:
        values: numbers of the message.
        known: how many controllers there are.

    Raises:
        ValueError: there is no such controller.
    """
    index = values[_CONTROLLER]
    if index not in range(known):
        raise ValueError(f"flight_state: position.controller {index!r} is none of 0 .. {known - 1}")
    return int(index)
