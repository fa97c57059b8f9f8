"""A controller file as it flies: both axes with their states, what they ask for and what was applied.

    asked = trim + C x + D in,   x+ = A x + B in + E (applied - asked)

A law that takes over in flight is settled first: of the states that ask for the command wanted it takes the
one nearest to rest for the present inputs,

    C x = command - trim - D in,   |(A - I) x + B in| least                                        (1)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from heli_common.linear_model import Array
from heli_common.rotations import Vector3
from heli_common.topics import SERVO_CHANNELS
from heli_common.vehicle_state import VehicleState
from heli_control.controller_file import SIGNALS, ControllerAxis, ControllerFile
from heli_control.state_space import DiscreteBlock, add_product, product, rows_of

_RANK_TOLERANCE = 1e-9


def settling_maps(axis: ControllerAxis) -> tuple[Array, Array]:
    """Maps of (1): x = M_y (command - trim - D in) + M_in in.

    Where C cannot give every command the output comes as near as it can; where rest leaves a choice the
    shortest x is taken.

    Args:
        axis: with n states, m inputs, p outputs.

    Returns:
        M_y, shape (n, p), and M_in, shape (n, m).
    """
    system = axis.system
    n = len(system.states)
    if n == 0:
        return np.zeros((0, len(system.outputs))), np.zeros((0, len(system.inputs)))
    drift = system.A - np.eye(n)
    _, sizes, right = np.linalg.svd(system.C)
    rank = int(np.count_nonzero(sizes > _RANK_TOLERANCE * max(sizes.max(), 1e-300)))
    output = np.asarray(np.linalg.pinv(system.C, rcond=_RANK_TOLERANCE), dtype=np.float64)
    free: Array = right[rank:].T  # what the output does not see, shape (n, n - rank)
    rest: Array = free @ np.linalg.pinv(drift @ free, rcond=_RANK_TOLERANCE)
    return output - rest @ drift @ output, -rest @ system.B


class _Axis:
    """One axis: where its inputs come from, where its outputs go, its states."""

    def __init__(self, axis: ControllerAxis, trim: Sequence[float]) -> None:
        system = axis.system
        self.given = tuple(SERVO_CHANNELS.index(name) for name in system.outputs)
        self._taken = tuple(SIGNALS.index(name) for name in system.inputs)
        self._trim = tuple(trim[index] for index in self.given)
        self._direct = rows_of(system.D)
        self._correction = rows_of(axis.anti_windup)
        by_output, by_input = settling_maps(axis)
        self._settling = rows_of(np.hstack((by_output, by_input)))
        self._asked = (0.0,) * len(self.given)
        self.block = DiscreteBlock(system)

    def step(self, signals: Sequence[float], commands: list[float]) -> None:
        """Write what this axis asks for; the state goes on as if that were applied."""
        self._asked = self.block.step([signals[index] for index in self._taken])
        for index, trim, asked in zip(self.given, self._trim, self._asked, strict=True):
            commands[index] = trim + asked

    def follow(self, applied: Sequence[float]) -> None:
        """Correct the state by what was applied instead."""
        missed = tuple(
            applied[index] - trim - asked
            for index, trim, asked in zip(self.given, self._trim, self._asked, strict=True)
        )
        state = list(self.block.state)
        add_product(state, self._correction, missed)
        self.block.place(tuple(state))

    def settle(self, signals: Sequence[float], commands: Sequence[float]) -> None:
        """Take the state of (1)."""
        inputs = tuple(signals[index] for index in self._taken)
        wanted = tuple(
            commands[index] - trim - product(row, inputs)
            for index, trim, row in zip(self.given, self._trim, self._direct, strict=True)
        )
        column = (*wanted, *inputs)
        self.block.place(tuple(product(row, column) for row in self._settling))


class FlightLaw:
    """Both axes of a controller file, with their operating point.

    Args:
        controller: as read from its file.

    Attributes:
        name: of the controller.
        trim: B_1s A_1s theta_0 theta_t at the operating point [rad].
        theta: pitch at the operating point [rad].
        phi: roll at the operating point [rad].
    """

    def __init__(self, controller: ControllerFile) -> None:
        point = controller.operating_point
        self.name = controller.name
        self.trim = tuple(float(getattr(point, channel)) for channel in SERVO_CHANNELS)
        self.theta, self.phi = point.theta, point.phi
        self._axes = [_Axis(axis, self.trim) for axis in (controller.horizontal, controller.vertical)]

    def step(self, state: VehicleState, velocity: Vector3, yaw_rate: float) -> list[float]:
        """Commands B_1s A_1s theta_0 theta_t asked for [rad].

        Args:
            state: of the helicopter.
            velocity: reference in body FRD [m/s].
            yaw_rate: reference about body z [rad/s].
        """
        signals = self._signals(state, velocity, yaw_rate)
        commands = list(self.trim)
        for axis in self._axes:
            axis.step(signals, commands)
        return commands

    def follow(self, applied: Sequence[float]) -> None:
        """Tell the law which commands of the last step really went out [rad]."""
        for axis in self._axes:
            axis.follow(applied)

    def settle(
        self, state: VehicleState, velocity: Vector3, yaw_rate: float, commands: Sequence[float]
    ) -> None:
        """Take the state from which the next step asks for these commands and moves on least.

        Args:
            state: of the helicopter.
            velocity: reference in body FRD [m/s].
            yaw_rate: reference about body z [rad/s].
            commands: B_1s A_1s theta_0 theta_t [rad].
        """
        signals = self._signals(state, velocity, yaw_rate)
        for axis in self._axes:
            axis.settle(signals, commands)

    def reset(self) -> None:
        """Back to rest at the operating point."""
        for axis in self._axes:
            axis.block.reset()

    def _signals(self, state: VehicleState, velocity: Vector3, yaw_rate: float) -> tuple[float, ...]:
        """Numbers in the order of SIGNALS."""
        u, v, w = state.velocity
        p, q, r = state.rates
        theta, phi = state.attitude.theta - self.theta, state.attitude.phi - self.phi
        return (theta, phi, u, v, w, p, q, r, *velocity, yaw_rate)
