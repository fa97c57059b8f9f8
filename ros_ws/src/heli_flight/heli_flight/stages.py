"""What the supervisor asks for during each phase of a plan, as functions of stamped data only."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from heli_common.errors import SafetyStop
from heli_common.flight_state import FlightState
from heli_common.quantities import quantity
from heli_common.rotations import Vector3, wrap
from heli_common.vehicle_state import VehicleState
from heli_flight.plan_phases import (
    Excite,
    Home,
    Hover,
    Land,
    Phase,
    RunDown,
    RunUp,
    Step,
    TakeOff,
    commands_wind,
    wind_command,
)

SPOOL_TIME = 2.5
"""The rotor takes the load up before the reference leaves the stop [s] (D)."""

PATIENCE = 10.0
"""A phase that has not reached its end so long after it should is given up [s] (D)."""

SETTLED_TIME = 0.5
ROTOR_TOLERANCE = 0.02
HEIGHT_TOLERANCE = 0.05
TOUCHDOWN_DEPTH = 0.02
"""How close above the stop counts as down [m]."""


@dataclass
class Reference:
    """What the supervisor asks for.

    Attributes:
        state: stage of the flight.
        position: NED reference [m].
        heading: yaw reference [rad].
        rotor_speed: reference [rad/s], 0 for a rotor at rest.
        wind: speed asked of the wind generator [m/s].
        excitation: number of the plan's excitation being flown, from 1; 0 for none.
        excitations: flown so far.
    """

    state: FlightState = FlightState.IDLE
    position: Vector3 = (0.0, 0.0, 0.0)
    heading: float = 0.0
    rotor_speed: float = 0.0
    wind: float = 0.0
    excitation: int = 0
    excitations: int = 0


@dataclass(frozen=True)
class Observation:
    """What the supervisor sees at one control tick."""

    time: float
    vehicle: VehicleState
    rotor_speed: float


@dataclass(frozen=True)
class FlightLimits:
    """What the supervisor must know of the bench, and where it stops a flight."""

    nominal_rotor_speed: float = quantity(163.363, "rad/s", "T", "rotor speed of flight", 1.0, 400.0)
    maximum_tilt: float = quantity(0.349, "rad", "D", "roll or pitch that stops a flight", 0.05, 0.43)
    maximum_radius: float = quantity(0.48, "m", "D", "distance from the axis that stops a flight", 0.05, 0.5)
    minimum_rotor_fraction: float = quantity(
        0.8, "", "D", "rotor speed below which no flight goes on", 0.0, 1.0
    )
    landing_deviation: float = quantity(
        0.03, "m", "D", "position known no better than so: the helicopter is landed", 0.001, 1.0
    )
    maximum_deviation: float = quantity(
        0.10, "m", "D", "position known no better than so: the flight is stopped", 0.001, 1.0
    )
    rest_depth: float = quantity(0.45, "m", "D", "lower stop below the flight-space centre", 0.0, 2.0)


Stage = Iterator[None]
"""Advanced once a control tick; it changes the reference and ends when the phase is over."""

See = Callable[[], Observation]


def run_phase(phase: Phase, reference: Reference, see: See, limits: FlightLimits) -> Stage:
    """The stage of a phase with its wind: advance it at every control tick until it ends.

    Raises:
        SafetyStop: while advanced, if the phase cannot be completed.
    """
    if not commands_wind(phase):
        yield from _stage(phase, reference, see, limits)
        return
    before, start = reference.wind, see().time
    for _ in _stage(phase, reference, see, limits):
        reference.wind = wind_command(phase, see().time - start, before)
        yield
    reference.wind = wind_command(phase, math.inf, before)  # a ramp ends exactly at its end


def _stage(phase: Phase, reference: Reference, see: See, limits: FlightLimits) -> Stage:
    if isinstance(phase, Home):
        return _home(phase, reference, see)
    if isinstance(phase, RunUp):
        return _run_up(phase, reference, see, limits)
    if isinstance(phase, TakeOff):
        return _take_off(phase, reference, see)
    if isinstance(phase, Hover):
        return _hold(phase.duration, reference, see)
    if isinstance(phase, Step):
        return _step(phase, reference, see)
    if isinstance(phase, Excite):
        return _excite(phase, reference, see)
    if isinstance(phase, Land):
        return _land(phase, reference, see, limits)
    if isinstance(phase, RunDown):
        return _run_down(phase, reference, see, limits)
    raise TypeError(f"no stage for {type(phase).__name__}")


def _hold(duration: float, reference: Reference, see: See) -> Stage:
    start = see().time
    reference.state = FlightState.FLYING
    while see().time - start < duration:
        yield


def _home(phase: Home, reference: Reference, see: See) -> Stage:
    start = see().time
    reference.state = FlightState.HOMING
    while see().time - start < phase.duration:
        yield
    reference.state = FlightState.IDLE
    if not see().vehicle.known:
        raise SafetyStop(f"the encoders are not indexed after {phase.duration:.1f} s of homing")


def _run_up(phase: RunUp, reference: Reference, see: See, limits: FlightLimits) -> Stage:
    start = see().time
    nominal = limits.nominal_rotor_speed
    if not see().vehicle.known:
        raise SafetyStop("run-up before homing is refused")
    reference.state = FlightState.RUN_UP

    def at_speed() -> bool:
        fraction = min(1.0, (see().time - start) / phase.duration)
        reference.rotor_speed = nominal * fraction
        return fraction >= 1.0 and abs(see().rotor_speed - nominal) < ROTOR_TOLERANCE * nominal

    yield from _until(at_speed, see, phase.duration + PATIENCE, "rotor speed within 2 %")


def _take_off(phase: TakeOff, reference: Reference, see: See) -> Stage:
    start = see().time
    depth = see().vehicle.position[2]
    reference.position = (0.0, 0.0, depth)
    reference.heading = see().vehicle.attitude.psi
    reference.state = FlightState.FLYING
    climb = abs(depth + phase.height) / phase.speed

    def up() -> bool:
        flown = max(0.0, see().time - start - SPOOL_TIME)
        reference.position = (0.0, 0.0, _ramp(depth, -phase.height, phase.speed * flown))
        return flown >= climb and abs(see().vehicle.position[2] + phase.height) < HEIGHT_TOLERANCE

    yield from _until(up, see, SPOOL_TIME + climb + PATIENCE, f"height {phase.height:.2f} m")


def _step(phase: Step, reference: Reference, see: See) -> Stage:
    x, y, z = reference.position
    if phase.axis == "psi":
        reference.heading = wrap(reference.heading + phase.amplitude)
    else:
        reference.position = (
            x + phase.amplitude * (phase.axis == "x"),
            y + phase.amplitude * (phase.axis == "y"),
            z + phase.amplitude * (phase.axis == "z"),
        )
    return _hold(phase.duration, reference, see)


def _excite(phase: Excite, reference: Reference, see: See) -> Stage:
    reference.excitations += 1
    reference.excitation = reference.excitations
    yield from _hold(phase.duration, reference, see)
    reference.excitation = 0


def _land(phase: Land, reference: Reference, see: See, limits: FlightLimits) -> Stage:
    start = see().time
    x, y, depth = reference.position
    below = limits.rest_depth + 0.15
    reference.state = FlightState.LANDING
    reference.excitation = 0  # the landing may have cut one short

    def down() -> bool:
        flown = see().time - start
        reference.position = (x, y, _ramp(depth, below, phase.speed * flown))
        vehicle = see().vehicle
        return vehicle.position[2] > limits.rest_depth - TOUCHDOWN_DEPTH and abs(vehicle.velocity[2]) < 0.1

    yield from _until(down, see, (below - depth) / phase.speed + PATIENCE, "touch-down")


def _run_down(phase: RunDown, reference: Reference, see: See, limits: FlightLimits) -> Stage:
    start = see().time
    reference.state = FlightState.RUN_DOWN
    while see().time - start < phase.duration:
        unloaded = see().time - start > 0.4 * phase.duration
        reference.rotor_speed = 0.0 if unloaded else limits.nominal_rotor_speed
        yield


def _until(reached: Callable[[], bool], see: See, patience: float, goal: str) -> Stage:
    """Go on until the condition has held for the settling time."""
    start = see().time
    since: float | None = None
    while since is None or see().time - since < SETTLED_TIME:
        if not reached():
            since = None
        elif since is None:
            since = see().time
        if see().time - start > patience:
            raise SafetyStop(f"{goal} not reached after {patience:.1f} s")
        yield


def _ramp(start: float, end: float, travel: float) -> float:
    """From start towards end by `travel`, and no further."""
    return min(end, start + travel) if end > start else max(end, start - travel)
