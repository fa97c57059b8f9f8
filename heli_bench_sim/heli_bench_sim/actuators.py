"""What servos and drive really do, read out of the bench's state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import drive, servos
from heli_bench_sim.motion import BenchConstants, BenchState
from heli_bench_sim.servos import SERVOS
from heli_bench_sim.states import Input, State
from heli_common.compiled import compiled

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


@compiled
def read_actuators(state: Array, command: Array, box: Sequence[BenchConstants], out: Array) -> None:
    """Write what servos and drive do now into `out`.

    Args:
        state: (29,) of the bench.
        command: (5,) shaft commands [rad] and control voltage [V].
        box: constants of the bench, boxed.
        out: (9,) receives four blade angles [rad], their rates [rad/s] and the motor's current [A].
    """
    c = box[0]
    angles = servos.unmix(state, BenchState.shaft, c.servo)
    rates = servos.unmix(state, BenchState.shaft_rate, c.servo)
    for blade in range(SERVOS):
        out[blade] = angles[blade]
        out[SERVOS + blade] = rates[blade]
    # a rate has no neutral angle
    out[SERVOS + Input.theta_0] -= c.servo.collective_neutral
    out[SERVOS + Input.theta_t] -= c.servo.tail_neutral
    out[2 * SERVOS] = drive.current(command[SERVOS], state[State.Omega], c.helicopter)


@compiled
def command_servos(
    b_1s: float,
    a_1s: float,
    theta_0: float,
    theta_t: float,
    box: Sequence[BenchConstants],
    shafts: Array,
) -> bool:
    """Write the shaft angles that a pulse frame asks for; True if the command had to be limited.

    Args:
        b_1s: longitudinal cyclic [rad].
        a_1s: lateral cyclic [rad].
        theta_0: collective [rad].
        theta_t: tail collective [rad].
        box: constants of the bench, boxed.
        shafts: (4,) receives the shaft angles [rad].
    """
    return servos.reach_shafts(b_1s, a_1s, theta_0, theta_t, box[0].servo, shafts)


def actual_inputs(state: Array, command: Array, box: Sequence[BenchConstants]) -> Array:
    """(5,) blade angles as the servos hold them now [rad], and the control voltage [V].

    Args:
        state: (29,) of the bench.
        command: (5,) shaft commands [rad] and control voltage [V].
        box: constants of the bench, boxed.
    """
    read = np.empty(2 * SERVOS + 1)
    read_actuators(state, command, box, read)
    read[SERVOS] = command[SERVOS]
    return read[: SERVOS + 1]


def actuator_state(
    state: Array, command: Array, saturated: bool, motor_gear: float, box: Sequence[BenchConstants]
) -> ActuatorState:
    """Actual angles, rates, torque and current.

    Args:
        state: (29,) of the bench.
        command: (5,) shaft commands [rad] and control voltage [V].
        saturated: whether the limits changed the latest servo command.
        motor_gear: motor turns per rotor turn.
        box: constants of the bench, boxed.
    """
    read = np.empty(2 * SERVOS + 1)
    read_actuators(state, command, box, read)
    b_1s, a_1s, theta_0, theta_t, *rates, current = read.tolist()
    return ActuatorState(
        angles=(b_1s, a_1s, theta_0, theta_t),
        angle_rates=(rates[0], rates[1], rates[2], rates[3]),
        saturated=saturated,
        motor_speed=motor_gear * float(state[State.Omega]),
        motor_torque=float(state[State.M_A]),
        motor_current=current,
    )
