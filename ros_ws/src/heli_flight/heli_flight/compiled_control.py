"""The three controllers in one compiled call per control period: their own equations, wired for speed.

What each controller computes are the functions of `heli_control`, made known to compiled code here; only the
order of the calls is written down once more. References pass through the same conversions as in messages, so
a flight gets the same commands bit for bit as from the components (`test_swift_flight.py`).
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import callable_too, compiled
from heli_common.compiled_messages import read_pose, write_pose
from heli_common.rotations import Euler, matrix_from_euler, rotate, transpose
from heli_common.topics import SERVO_CHANNELS
from heli_control.attitude_control import body_from_level, faded, next_authority
from heli_control.command_limits import limit_command
from heli_control.controller_file import SIGNALS
from heli_control.motor_control import GovernorConstants, govern
from heli_control.position_control import heading_errors, proportional_integral
from heli_control.reference_model import respond
from heli_control.state_space import add_product, multiply, product

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

for _function in (
    add_product,
    faded,
    govern,
    heading_errors,
    limit_command,
    matrix_from_euler,
    multiply,
    next_authority,
    product,
    proportional_integral,
    respond,
    rotate,
    transpose,
    body_from_level,
):
    callable_too(_function)

CHANNELS = len(SERVO_CHANNELS)


class Memory(IntEnum):
    """Where each part of what the controllers remember begins."""

    integral = 0
    """of the position law, forward, right, down, heading"""
    value = 4
    """of the expected response, north, east, down, heading"""
    rate = 8
    """of the same"""
    engaged = 12
    """1 once the position law has begun"""
    authority = 13
    """of the attitude controller"""
    voltage = 14
    """integral part of the governor [V]"""
    asked = 15
    """what the attitude law asked for last, within its limits [rad]"""
    end = asked + CHANNELS


class Table(IntEnum):
    """Rows of the constants, four columns each."""

    gain = 0
    """of the position law"""
    growth = 1
    integral_limit = 2
    limit = 3
    frequency = 4
    """of the expected response"""
    decay = 5
    idle = 6
    """command without authority [rad]"""
    lowest = 7
    """of each command [rad]"""
    highest = 8
    trim = 9
    """of the attitude law [rad]"""
    more = 10
    """rise and fall of the authority; neutral collective and reach [rad]"""
    point = 11
    """pitch and roll of the operating point [rad]"""
    end = 12


class Flag(IntEnum):
    """What the flight state says to the controllers."""

    controlled = 1
    ended = 2
    driven = 4
    """the governor works"""
    known = 8
    """the pose is known"""


@compiled
def control_step(
    state: Array,
    north: float,
    east: float,
    down: float,
    heading: float,
    rotor_reference: float,
    rotor_speed: float,
    flags: int,
    memory: Array,
    table: Array,
    governor: GovernorConstants,
    first_places: Indices,
    first_numbers: Array,
    second_places: Indices,
    second_numbers: Array,
    work: Array,
    command: Array,
) -> bool:
    """All controllers once; arguments as for `SwiftControl.step`, memory in the parts of `Memory`."""
    known = flags & Flag.known != 0
    steered = known and flags & Flag.controlled != 0
    pose, place, signals = work[0:7], work[7:13], work[13 : 13 + len(SIGNALS)]
    forward, right, fall, turn = 0.0, 0.0, 0.0, 0.0
    if steered:
        write_pose((north, east, down), Euler(heading, 0.0, 0.0), pose)
        read_pose(pose, place)
        forward, right, fall, turn = _position(memory, table, state, place)
    else:
        memory[Memory.engaged] = 0.0
        for axis in range(CHANNELS):
            memory[Memory.integral + axis] = 0.0
    more = table[Table.more]
    authority = next_authority(memory[Memory.authority], flags & Flag.ended != 0, steered, more[0], more[1])
    memory[Memory.authority] = authority
    asked = memory[Memory.asked : Memory.end]
    if authority == 0.0:
        _rest(first_places, first_numbers)
        _rest(second_places, second_numbers)
        for channel in range(CHANNELS):
            asked[channel] = table[Table.trim, channel]
            command[channel] = table[Table.idle, channel]
    else:
        if known:
            _signals(state, body_from_level((forward, right, fall), state[4], state[5]), turn, table, signals)
            for channel in range(CHANNELS):
                asked[channel] = table[Table.trim, channel]
            _axis_step(first_places, first_numbers, signals, asked)
            _axis_step(second_places, second_numbers, signals, asked)
            limit_command(asked, table[Table.lowest], table[Table.highest], more[2], more[3])
        for channel in range(CHANNELS):
            command[channel] = faded(table[Table.idle, channel], asked[channel], authority)
        if known:
            _axis_follow(first_places, first_numbers, table[Table.trim], command)
            _axis_follow(second_places, second_numbers, table[Table.trim], command)
    if flags & Flag.driven != 0:
        voltage, memory[Memory.voltage] = govern(
            memory[Memory.voltage], rotor_reference, rotor_speed, governor
        )
        command[CHANNELS] = voltage
    else:
        memory[Memory.voltage], command[CHANNELS] = 0.0, 0.0
    total = 0.0
    for channel in range(CHANNELS + 1):
        total += 0.0 * command[channel]  # NaN of infinity and of NaN
    return total == 0.0


@compiled
def _position(
    memory: Array, table: Array, state: Array, reference: Array
) -> tuple[float, float, float, float]:
    """Velocity reference in heading axes, within its limits."""
    place = (state[0], state[1], state[2], state[3])
    wanted = (reference[0], reference[1], reference[2], reference[3])
    value, rate = Memory.value, Memory.rate
    if memory[Memory.engaged] == 0.0:
        memory[Memory.engaged] = 1.0
        for axis in range(CHANNELS):
            memory[value + axis], memory[rate + axis] = place[axis], 0.0
    for axis in range(CHANNELS):
        memory[value + axis], memory[rate + axis] = respond(
            memory[value + axis],
            memory[rate + axis],
            wanted[axis],
            table[Table.frequency, axis],
            table[Table.decay, axis],
        )
    expected = (memory[value], memory[value + 1], memory[value + 2], memory[value + 3])
    errors = heading_errors(place, wanted, expected, memory[rate + 2], (0.0, 0.0, 0.0, 0.0))
    return (
        _axis(memory, table, 0, errors[0]),
        _axis(memory, table, 1, errors[1]),
        _axis(memory, table, 2, errors[2]),
        _axis(memory, table, 3, errors[3]),
    )


@compiled
def _axis(memory: Array, table: Array, axis: int, errors: tuple[float, float, float]) -> float:
    output, memory[Memory.integral + axis] = proportional_integral(
        memory[Memory.integral + axis],
        errors,
        table[Table.gain, axis],
        table[Table.growth, axis],
        table[Table.integral_limit, axis],
        table[Table.limit, axis],
    )
    return output


@compiled
def _signals(
    state: Array, velocity: tuple[float, float, float], yaw_rate: float, table: Array, signals: Array
) -> None:
    """Numbers in the order of SIGNALS."""
    signals[0], signals[1] = state[4] - table[Table.point, 0], state[5] - table[Table.point, 1]
    for part in range(6):
        signals[2 + part] = state[6 + part]
    signals[8], signals[9], signals[10] = velocity
    signals[11] = yaw_rate


@compiled
def _axis_step(places: Indices, numbers: Array, signals: Array, commands: Array) -> None:
    n, m, p = places[0], places[1], places[2]
    wide = n + m
    state, column = numbers[:n], numbers[n : n + wide]
    at = n + wide
    asked = numbers[at : at + p]
    at += 2 * p
    next_rows = numbers[at : at + n * wide].reshape(n, wide)
    output_rows = numbers[at + n * wide : at + (n + p) * wide].reshape(p, wide)
    for index in range(n):
        column[index] = state[index]
    for index in range(m):
        column[n + index] = signals[places[3 + index]]
    multiply(output_rows, column, asked)
    multiply(next_rows, column, state)
    for index in range(p):
        channel = places[3 + m + index]
        commands[channel] = commands[channel] + asked[index]


@compiled
def _axis_follow(places: Indices, numbers: Array, trim: Array, applied: Array) -> None:
    n, m, p = places[0], places[1], places[2]
    wide = n + m
    at = n + wide
    asked, missed = numbers[at : at + p], numbers[at + p : at + 2 * p]
    at += 2 * p + (n + p) * wide
    for index in range(p):
        channel = places[3 + m + index]
        missed[index] = applied[channel] - trim[channel] - asked[index]
    add_product(numbers[:n], numbers[at : at + n * p].reshape(n, p), missed)


@compiled
def _rest(places: Indices, numbers: Array) -> None:
    for index in range(places[0]):
        numbers[index] = 0.0
