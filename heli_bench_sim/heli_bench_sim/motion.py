"""The bench in motion: helicopter, servos and rig in one state, integrated by Runge and Kutta.

One compiled `advance` serves the single bench, batches and tests, so they agree to the last bit. All forces
of the rig on the helicopter are summed in `rig_load`: what acts on the platform is added there.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import arm_friction, end_stops, helicopter, homing_hand, lower_stop, rigid_body, servos
from heli_bench_sim.arm_friction import ArmFrictionConstants
from heli_bench_sim.end_stops import EndStopConstants
from heli_bench_sim.homing_hand import HandConstants
from heli_bench_sim.lower_stop import StopConstants
from heli_bench_sim.parameters import Constants
from heli_bench_sim.servos import SERVOS, ServoConstants
from heli_bench_sim.states import INPUT_SIZE, STATE_SIZE, Input, State
from heli_common.compiled import compiled

Array = NDArray[np.float64]


class BenchState(IntEnum):
    """What follows the helicopter's 18 states: `shaft` and `shaft_rate` are the first of four each."""

    shaft = STATE_SIZE
    """servo shaft angles [rad], three swash-plate servos and the tail"""
    shaft_rate = STATE_SIZE + SERVOS
    """their rates [rad/s]"""
    bristle_north = STATE_SIZE + 2 * SERVOS
    """bend of the skids' friction bristle, north [m]"""
    bristle_east = STATE_SIZE + 2 * SERVOS + 1
    """the same, east [m]"""
    bristle_yaw = STATE_SIZE + 2 * SERVOS + 2
    """twist of the skids on the stop [rad]"""


BENCH_STATE_SIZE = STATE_SIZE + 2 * SERVOS + 3

COMMAND_SIZE = SERVOS + 1
"""Four shaft commands [rad] and the control voltage [V]."""

WORK_ROWS = 5
"""Rows of working memory that `advance` needs: four slopes and one trial state."""


class BenchConstants(NamedTuple):
    """All constants of the compiled bench."""

    helicopter: Constants
    servo: ServoConstants
    stop: StopConstants
    friction: ArmFrictionConstants
    ends: EndStopConstants
    hand: HandConstants


class Hand(NamedTuple):
    """Where the homing script stands; a negative time means no hand."""

    time: float
    """since homing began [s]"""
    x: float
    """position when homing began, NED [m]"""
    y: float
    z: float
    psi: float
    """angles when homing began [rad]"""
    theta: float
    phi: float


NO_HAND = Hand(-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class RigLoad(NamedTuple):
    """What the rig does to the helicopter."""

    north: float
    """force on the platform, NED [N]"""
    east: float
    down: float
    yaw: float
    """torque about the gimbal's yaw axis [N m]"""
    pitch: float
    roll: float


@compiled
def rig_load(
    state: Array,
    velocity: tuple[float, float, float],
    turning: tuple[float, float, float],
    bristle_rates: tuple[float, float, float],
    normal: float,
    hand: Hand,
    c: BenchConstants,
) -> RigLoad:
    """Sum of all forces and torques of the rig.

    Args:
        state: (29,) of the bench.
        velocity: of the platform, NED [m/s].
        turning: rates of yaw, pitch and roll axis [rad/s].
        bristle_rates: of the skids' bristles, north, east [m/s], yaw [rad/s].
        normal: force of the lower stop [N].
        hand: the homing script.
        c: constants of the bench.
    """
    x, y, z = state[State.x], state[State.y], state[State.z]
    psi, theta, phi = state[State.psi], state[State.theta], state[State.phi]
    north, east, down = end_stops.platform_force(x, y, z, velocity[0], velocity[1], velocity[2], c.ends)
    yaw = end_stops.gimbal_torque(psi, turning[0], c.ends.yaw_limit, c.ends)
    pitch = end_stops.gimbal_torque(theta, turning[1], c.ends.tilt_limit, c.ends)
    roll = end_stops.gimbal_torque(phi, turning[2], c.ends.tilt_limit, c.ends)

    dry = arm_friction.platform_friction(velocity[0], velocity[1], velocity[2], c.friction)
    north, east, down = north + dry[0], east + dry[1], down + dry[2]
    yaw += arm_friction.gimbal_friction(turning[0], c.friction)
    pitch += arm_friction.gimbal_friction(turning[1], c.friction)
    roll += arm_friction.gimbal_friction(turning[2], c.friction)

    if normal > 0.0:
        north += lower_stop.friction_force(state[BenchState.bristle_north], bristle_rates[0], normal, c.stop)
        east += lower_stop.friction_force(state[BenchState.bristle_east], bristle_rates[1], normal, c.stop)
        down -= normal
        yaw += lower_stop.friction_moment(state[BenchState.bristle_yaw], bristle_rates[2], normal, c.stop)
        pitch += lower_stop.tilt_moment(theta, turning[1], normal, c.stop)
        roll += lower_stop.tilt_moment(phi, turning[2], normal, c.stop)

    if hand.time >= 0.0:
        h = c.hand
        north += homing_hand.pull(hand.time, x, velocity[0], hand.x, 0.0, 0.0, h)
        east += homing_hand.pull(hand.time, y, velocity[1], hand.y, 0.0, 0.0, h)
        down += homing_hand.pull(hand.time, z, velocity[2], hand.z, h.top, h.bottom, h)
        down -= homing_hand.lift(hand.time, h)
        yaw += homing_hand.turn(hand.time, 0, psi, turning[0], hand.psi, h)
        pitch += homing_hand.turn(hand.time, 1, theta, turning[1], hand.theta, h)
        roll += homing_hand.turn(hand.time, 2, phi, turning[2], hand.phi, h)
    return RigLoad(north, east, down, yaw, pitch, roll)


@compiled
def bench_derivative(
    state: Array, command: Array, wind_earth: Array, hand: Hand, c: BenchConstants, out: Array
) -> None:
    """Write the derivative of the bench's state into `out`.

    Args:
        state: (29,) helicopter, servos, bristles.
        command: (5,) shaft commands [rad] and control voltage [V].
        wind_earth: (3,) velocity of the air, NED [m/s].
        hand: the homing script.
        c: constants of the bench.
        out: (29,) receives the derivative.
    """
    theta, phi = state[State.theta], state[State.phi]
    velocity = rigid_body.earth_from_body(
        state[State.u], state[State.v], state[State.w], state[State.psi], theta, phi
    )
    turning = rigid_body.euler_rates(state[State.p], state[State.q], state[State.r], theta, phi)
    normal = lower_stop.normal_force(state[State.z], velocity[2], c.stop)
    sliding = math.hypot(velocity[0], velocity[1])
    slip, twist = c.stop.slip_distance, c.stop.slip_angle
    bends = (
        lower_stop.bristle_rate(state[BenchState.bristle_north], velocity[0], sliding, slip, normal, c.stop),
        lower_stop.bristle_rate(state[BenchState.bristle_east], velocity[1], sliding, slip, normal, c.stop),
        lower_stop.bristle_rate(
            state[BenchState.bristle_yaw], turning[0], abs(turning[0]), twist, normal, c.stop
        ),
    )
    out[BenchState.bristle_north], out[BenchState.bristle_east], out[BenchState.bristle_yaw] = bends

    load = rig_load(state, velocity, turning, bends, normal, hand, c)
    force, moment, inputs = np.empty(3), np.empty(3), np.empty(INPUT_SIZE)
    force[0], force[1], force[2] = load.north, load.east, load.down
    moment[0], moment[1], moment[2] = rigid_body.body_moment(load.yaw, load.pitch, load.roll, theta, phi)
    servos.unmix(state[BenchState.shaft : BenchState.shaft_rate], c.servo, inputs)
    inputs[Input.U_mot] = command[SERVOS]
    helicopter.derivative(
        state[:STATE_SIZE], inputs, wind_earth, force, moment, c.helicopter, out[:STATE_SIZE]
    )

    for servo in range(SERVOS):
        angle, rate = state[BenchState.shaft + servo], state[BenchState.shaft_rate + servo]
        out[BenchState.shaft + servo] = rate
        out[BenchState.shaft_rate + servo] = servos.shaft_acceleration(angle, rate, command[servo], c.servo)


@compiled
def later(hand: Hand, time: float) -> Hand:
    """The homing script some time [s] further on; no hand stays no hand."""
    if hand.time < 0.0:
        return hand
    return Hand(hand.time + time, hand.x, hand.y, hand.z, hand.psi, hand.theta, hand.phi)


@compiled
def advance(
    state: Array,
    command: Array,
    wind_earth: Array,
    hand: Hand,
    period: float,
    steps: int,
    c: BenchConstants,
    work: Array,
) -> None:
    """Advance one bench in place by a period, inputs held: classical Runge-Kutta of fourth order.

    Args:
        state: (29,), overwritten.
        command: (5,) shaft commands [rad] and control voltage [V].
        wind_earth: (3,) velocity of the air, NED [m/s].
        hand: the homing script at the beginning.
        period: [s].
        steps: number of equal integration steps in it.
        c: constants of the bench.
        work: (5, 29) working memory.
    """
    h = period / steps
    first, second, third, fourth, trial = work[0], work[1], work[2], work[3], work[4]
    for step in range(steps):
        now, middle, end = later(hand, step * h), later(hand, (step + 0.5) * h), later(hand, (step + 1) * h)
        bench_derivative(state, command, wind_earth, now, c, first)
        for index in range(BENCH_STATE_SIZE):
            trial[index] = state[index] + 0.5 * h * first[index]
        bench_derivative(trial, command, wind_earth, middle, c, second)
        for index in range(BENCH_STATE_SIZE):
            trial[index] = state[index] + 0.5 * h * second[index]
        bench_derivative(trial, command, wind_earth, middle, c, third)
        for index in range(BENCH_STATE_SIZE):
            trial[index] = state[index] + h * third[index]
        bench_derivative(trial, command, wind_earth, end, c, fourth)
        for index in range(BENCH_STATE_SIZE):
            slope = first[index] + 2.0 * (second[index] + third[index]) + fourth[index]
            state[index] += h / 6.0 * slope


@compiled
def advance_batch(
    states: Array,
    commands: Array,
    winds_earth: Array,
    period: float,
    steps: int,
    c: BenchConstants,
) -> None:
    """Advance many benches of the same kind in place, each exactly as `advance` would.

    Args:
        states: (n, 29), overwritten.
        commands: (n, 5) shaft commands [rad] and control voltage [V].
        winds_earth: (n, 3) velocity of the air, NED [m/s].
        period: [s].
        steps: number of equal integration steps in it.
        c: constants of the benches.
    """
    work = np.empty((WORK_ROWS, BENCH_STATE_SIZE))
    for bench in range(states.shape[0]):
        advance(states[bench], commands[bench], winds_earth[bench], NO_HAND, period, steps, c, work)
