"""What servos and drive really do, read out of the bench's state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import drive, servos
from heli_bench_sim.motion import BenchConstants, BenchState
from heli_bench_sim.servos import SERVOS
from heli_bench_sim.states import Input, State

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ActuatorState:
    """What the actuators really do."""

    angles: tuple[float, float, float, float]
    """blade angles B_1s, A_1s, theta_0, theta_t [rad]"""
    angle_rates: tuple[float, float, float, float]
    """their rates [rad/s]"""
    saturated: bool
    """whether the latest servo command lay outside what the servos reach"""
    motor_speed: float
    """[rad/s]"""
    motor_torque: float
    """[N m]"""
    motor_current: float
    """[A]"""


def actual_inputs(state: Array, command: Array, c: BenchConstants) -> Array:
    """(5,) blade angles as the servos hold them now [rad], and the control voltage [V].

    Args:
        state: (29,) of the bench.
        command: (5,) shaft commands [rad] and control voltage [V].
        c: constants of the bench.
    """
    return np.array([*servos.unmix(state, BenchState.shaft, c.servo), command[SERVOS]])


def actuator_state(state: Array, command: Array, saturated: bool, c: BenchConstants) -> ActuatorState:
    """Actual angles, rates, torque and current.

    Args:
        state: (29,) of the bench.
        command: (5,) shaft commands [rad] and control voltage [V].
        saturated: whether the limits changed the latest servo command.
        c: constants of the bench.
    """
    inputs = actual_inputs(state, command, c)
    moving = np.array(servos.unmix(state, BenchState.shaft_rate, c.servo))
    # a rate has no neutral angle
    moving[Input.theta_0] -= c.servo.collective_neutral
    moving[Input.theta_t] -= c.servo.tail_neutral
    omega = float(state[State.Omega])
    return ActuatorState(
        angles=_four(inputs),
        angle_rates=_four(moving),
        saturated=saturated,
        motor_speed=c.helicopter.motor_gear * omega,
        motor_torque=float(state[State.M_A]),
        motor_current=float(drive.current(float(inputs[Input.U_mot]), omega, c.helicopter)),
    )


def _four(values: Array) -> tuple[float, float, float, float]:
    return float(values[0]), float(values[1]), float(values[2]), float(values[3])
