"""Position, attitude and motor controller of one flight, packed for `compiled_control`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heli_common.topics import SERVO_CHANNELS
from heli_control.attitude_control import AttitudeController
from heli_control.controller_file import SIGNALS, ControllerAxis, ControllerFile
from heli_control.flight_law import FlightLaw
from heli_control.motor_control import SpeedGovernor
from heli_control.position_control import PositionLaw
from heli_flight.compiled_control import CHANNELS, Array, Indices, Memory, Table, control_step


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of an attitude law in two arrays.

    Attributes:
        places: numbers of states, inputs, outputs; then which signals go in and which commands come out.
        numbers: state, column (state and inputs), asked, missed, [A B], [C D], E, row by row.
    """

    places: Indices
    numbers: Array


def packed_axis(axis: ControllerAxis) -> Axis:
    """One axis at rest.

    Args:
        axis: of a controller file.
    """
    system = axis.system
    n, m, p = len(system.states), len(system.inputs), len(system.outputs)
    taken = [SIGNALS.index(name) for name in system.inputs]
    given = [SERVO_CHANNELS.index(name) for name in system.outputs]
    blank = np.zeros(n + (n + m) + 2 * p)
    rows = [np.hstack((system.A, system.B)), np.hstack((system.C, system.D)), axis.anti_windup]
    return Axis(
        np.array([n, m, p, *taken, *given], dtype=np.int64),
        np.concatenate([blank, *(row.ravel() for row in rows)]),
    )


class SwiftControl:
    """Position, attitude and motor controller of a flight with one controller and no excitation.

    Args:
        position: the law, for its constants.
        attitude: the component, for its limits and times.
        controller: that it flies.
        governor: of the motor, for its constants.

    Attributes:
        command: (5,) servo command [rad] and control voltage [V] of the latest period.
    """

    def __init__(
        self,
        position: PositionLaw,
        attitude: AttitudeController,
        controller: ControllerFile,
        governor: SpeedGovernor,
    ) -> None:
        law = FlightLaw(controller)
        limits = attitude.limits
        table: Array = np.zeros((Table.end, CHANNELS))
        for column, (axis, model) in enumerate(zip(position.axes, position.models, strict=True)):
            table[: Table.idle, column] = (
                axis.gain,
                axis.growth,
                axis.integral_limit,
                axis.limit,
                model.frequency,
                model.decay,
            )
        table[Table.idle] = attitude.idle
        table[Table.lowest], table[Table.highest], table[Table.trim] = limits.lowest, limits.highest, law.trim
        table[Table.more] = attitude.rise, attitude.fall, limits.neutral, limits.reach
        table[Table.point, :2] = law.theta, law.phi
        self._table = table
        self._governor = governor.constants
        self._memory = np.zeros(Memory.end)
        self._memory[Memory.asked :] = law.trim
        self._axes = [packed_axis(axis) for axis in (controller.horizontal, controller.vertical)]
        self._work = np.zeros(7 + 6 + len(SIGNALS) + CHANNELS)
        self.command = np.zeros(CHANNELS + 1)

    def step(
        self,
        state: Array,
        reference: tuple[float, float, float, float],
        rotor: tuple[float, float],
        flags: int,
    ) -> bool:
        """The commands of one control period; False if one of them is not finite.

        Args:
            state: (12 or more,) see `heli_navigation.filter_outputs.read_vehicle`.
            reference: north, east, down [m], yaw [rad].
            rotor: reference and measured speed [rad/s].
            flags: sum of `Flag`.
        """
        first, second = self._axes
        return control_step(
            state,
            *reference,
            *rotor,
            flags,
            self._memory,
            self._table,
            self._governor,
            first.places,
            first.numbers,
            second.places,
            second.numbers,
            self._work,
            self.command,
        )
