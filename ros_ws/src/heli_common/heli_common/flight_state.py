"""The stages of a flight, as the supervisor tells them to everybody (topic `flight_state`)."""

from __future__ import annotations

from enum import IntEnum
from functools import cached_property


class FlightState(IntEnum):
    """Code in `position.flight_state`; the words are those of diagnostics, plans and reports."""

    IDLE = 0
    HOMING = 1
    RUN_UP = 2
    FLYING = 3
    LANDING = 4
    RUN_DOWN = 5
    STOPPED = 6
    FAULT = 7

    @cached_property
    def word(self) -> str:
        """Lower-case name for people."""
        return self.name.lower().replace("_", "-")

    @cached_property
    def ended(self) -> bool:
        """Whether the flight is over: the recorder closes its bag and the bench exits."""
        return self in (FlightState.STOPPED, FlightState.FAULT)

    @cached_property
    def controlled(self) -> bool:
        """Whether position and attitude controllers steer the helicopter."""
        return self in (FlightState.FLYING, FlightState.LANDING)


_STATES = tuple(FlightState)


def flight_state_from_code(code: float) -> FlightState:
    """The state of a code in a message.

    Raises:
        ValueError: no such code.
    """
    if -0.5 <= code < len(_STATES) - 0.5:
        return _STATES[round(code)]
    raise ValueError(f"flight state code {code!r} is none of 0 .. {len(_STATES) - 1}")


def flight_state_values(
    state: float,
    rotor_speed: float = 0.0,
    fan: float = 0.0,
    *,
    controller: int = 0,
    excitation: int = 0,
) -> tuple[float, ...]:
    """Numbers of a `flight_state` message.

    Args:
        state: its code.
        rotor_speed: reference of the rotor speed [rad/s], 0 for a rotor at rest.
        fan: speed asked of the wind generator [m/s].
        controller: which of the plan's controllers shall fly, 0 for the first.
        excitation: number of the plan's excitation being flown, from 1; 0 for none.
    """
    positions = (float(state), 0.0, 0.0, float(controller))
    return (*positions, 0.0, rotor_speed, fan, 0.0, float(excitation), 0.0, 0.0, 0.0)
