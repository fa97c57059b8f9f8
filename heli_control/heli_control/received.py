"""What controllers read from messages beside the odometry."""

from __future__ import annotations

from collections.abc import Sequence

from heli_common.flight_state import FlightState, flight_state_from_code
from heli_common.topics import TOPICS

_FLIGHT_STATE = TOPICS["flight_state"].layout.fields.index("position.flight_state")
_ROTOR_REFERENCE = TOPICS["flight_state"].layout.fields.index("velocity.rotor")


def flight_state(values: Sequence[float]) -> tuple[FlightState, float]:
    """Stage of the flight and rotor speed reference [rad/s] from the numbers of `flight_state`.

    Raises:
        ValueError: no such stage.
    """
    return flight_state_from_code(values[_FLIGHT_STATE]), values[_ROTOR_REFERENCE]
