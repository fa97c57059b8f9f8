"""A recorded flight as the plain columns that identification works on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.flight_state import FlightState
from heli_common.topics import SERVO_CHANNELS
from heli_flight.flight_record import FlightRecord, Stamps
from heli_identification.flight_signals import Channel, FlightSignals
from heli_identification.preparation import Segment

Array = NDArray[np.float64]

SETTLING = 5.0
"""What the first seconds of flight are left out by default [s]."""


def flight_signals(record: FlightRecord) -> FlightSignals:
    """Motion, actuators, commands and external signal of a flight; what was not recorded is missing.

    The command of a servo is what the controllers asked for plus the excitation, which the bench adds.

    Args:
        record: of a flight.
    """
    motion = record.estimate
    known = motion.known
    stamps = motion.stamps[known]
    columns = {
        "psi": motion.attitude[:, 0],
        "theta": motion.attitude[:, 1],
        "phi": motion.attitude[:, 2],
        "u": motion.velocity[:, 0],
        "v": motion.velocity[:, 1],
        "w": motion.velocity[:, 2],
        "p": motion.rates[:, 0],
        "q": motion.rates[:, 1],
        "r": motion.rates[:, 2],
    }
    measured = {name: Channel(stamps, values[known]) for name, values in columns.items()}
    measured["Omega"] = Channel(*record.rotor_speed)
    actuator = record.series["actuator_state"]
    measured["M_A"] = Channel(actuator.stamps, actuator.column("effort.motor"))
    actuators = _channels(*record.actuator_state)
    command_stamps, asked = record.servo_command
    excitation = _sent(record, "excitation", tuple(f"position.{name}" for name in SERVO_CHANNELS))
    if excitation is not None:
        asked = asked + _at(command_stamps, *excitation)
    commands = _channels(command_stamps, asked)
    voltage_stamps, volts = record.motor_voltage
    added = _sent(record, "motor_excitation", ("effort.motor",))
    if added is not None:
        volts = volts + _at(voltage_stamps, *added)[:, 0]
    actuators["U_mot"] = commands["U_mot"] = Channel(voltage_stamps, volts)
    external = {} if excitation is None else _channels(*excitation)
    if added is not None:
        external["U_mot"] = Channel(added[0], added[1][:, 0])
    return FlightSignals(
        name=record.bag.folder.name,
        measured=measured,
        actuators=actuators,
        commands=commands,
        excitation=external,
    )


def free_flight(record: FlightRecord) -> Segment:
    """The longest time in the air, without its first seconds.

    Raises:
        InputError: the flight never flew.
    """
    flown = [stage for stage in record.stages if stage.state is FlightState.FLYING]
    if not flown:
        raise InputError("never flew", allowed="a flight", file=record.bag.folder)
    longest = max(flown, key=lambda stage: stage.end_ns - stage.start_ns)
    return Segment(longest.start_ns * 1e-9 + SETTLING, longest.end_ns * 1e-9)


def _channels(stamps: Stamps, values: Array) -> dict[str, Channel]:
    return {name: Channel(stamps, values[:, index]) for index, name in enumerate(SERVO_CHANNELS)}


def _sent(record: FlightRecord, topic: str, fields: tuple[str, ...]) -> tuple[Stamps, Array] | None:
    """An external signal, if the flight has its topic and something was sent on it."""
    series = record.series.get(topic)
    if series is None or not len(series.stamps):
        return None
    return series.stamps, series.columns(fields)


def _at(stamps: Stamps, other: Stamps, values: Array) -> Array:
    """Values at other stamps, zero where there are none."""
    found = np.zeros((len(stamps), values.shape[1]))
    _, ours, theirs = np.intersect1d(stamps, other, return_indices=True)
    found[ours] = values[theirs]
    return found
