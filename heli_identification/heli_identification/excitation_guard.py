"""When an excitation has to stop: not flying, too far from the reference, too much tilt."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, hypot, radians

from heli_common.flight_state import FlightState
from heli_common.quantities import quantity
from heli_common.rotations import Vector3
from heli_common.vehicle_state import VehicleState


@dataclass(frozen=True)
class GuardParameters:
    """Limits inside which an excitation goes on; the supervisor's, which stop the flight, are wider."""

    radius: float = quantity(0.25, "m", "D", "horizontal distance from the reference", 0.01, 0.5)
    height: float = quantity(0.20, "m", "D", "vertical distance from the reference", 0.01, 0.5)
    tilt: float = quantity(radians(12.0), "rad", "D", "roll or pitch", 0.01, 0.35)
    release_time: float = quantity(0.1, "s", "D", "in which a stopped excitation fades out", 0.01, 2.0)


def objection(
    stage: FlightState, state: VehicleState, reference: Vector3, parameters: GuardParameters
) -> str:
    """Why an excitation has to stop now, or an empty string.

    Args:
        stage: of the flight.
        state: of the helicopter.
        reference: position in earth NED [m].
        parameters: limits.
    """
    if stage is not FlightState.FLYING:
        return f"not flying ({stage.word})"
    if not state.known:
        return "position not known"
    north, east, down = (there - here for there, here in zip(state.position, reference, strict=True))
    if (radius := hypot(north, east)) > parameters.radius:
        return f"{radius:.2f} m beside the reference (limit {parameters.radius:g} m)"
    if abs(down) > parameters.height:
        return f"{abs(down):.2f} m above or below the reference (limit {parameters.height:g} m)"
    tilt = max(abs(state.attitude.theta), abs(state.attitude.phi))
    if tilt > parameters.tilt:
        return f"roll or pitch of {degrees(tilt):.1f} deg (limit {degrees(parameters.tilt):.1f} deg)"
    return ""
