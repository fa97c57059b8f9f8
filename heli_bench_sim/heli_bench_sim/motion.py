"""The bench in motion: helicopter, servos and rig in one state, integrated by Runge and Kutta.

One compiled `integrate` serves the single bench, batches and tests, so they agree to the last bit. All forces
of the rig on the helicopter are summed in `rig_load`: what acts on the platform is added there. The slope at
a sample serves twice, for the accelerations that the IMU feels and as first stage of the next step; commands
latched in between touch nothing in it but servos and motor torque (`command_rates`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import (
    arm_friction,
    arm_inertia,
    drive,
    end_stops,
    helicopter,
    homing_hand,
    lower_stop,
    rigid_body,
    servos,
)
from heli_bench_sim.arm_friction import ArmFrictionConstants
from heli_bench_sim.arm_inertia import ArmInertiaConstants
from heli_bench_sim.delta_arm import ArmConstants
from heli_bench_sim.end_stops import EndStopConstants
from heli_bench_sim.hall_sensor import HallConstants
from heli_bench_sim.homing_hand import HandConstants
from heli_bench_sim.imu_parameters import ImuConstants
from heli_bench_sim.lower_stop import StopConstants
from heli_bench_sim.parameters import Constants
from heli_bench_sim.room_air import RoomConstants
from heli_bench_sim.servos import SERVOS, ServoConstants
from heli_bench_sim.states import STATE_SIZE, State
from heli_bench_sim.wind_generator import WindConstants
from heli_common.compiled import compiled, equation

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

AIR_SIZE = 4
"""Velocity of the air at the helicopter, NED [m/s], and yaw moment of the room's air [N m]."""

WORK_ROWS = 5
"""Rows of working memory: three slopes, one trial state, and the first slope of a bench in a batch."""

FLYING_STEPS, STANDING_STEPS = 1, 4
"""Runge-Kutta steps per sensor period of 2.5 ms: in flight, and near the stiff lower stop."""

STOP_MARGIN = 0.02
"""Height over the lower stop below which the short steps begin [m]."""


class BenchConstants(NamedTuple):
    """All constants of the compiled bench."""

    helicopter: Constants
    servo: ServoConstants
    stop: StopConstants
    friction: ArmFrictionConstants
    ends: EndStopConstants
    hand: HandConstants
    arm: ArmConstants
    inertia: ArmInertiaConstants
    jet: WindConstants
    room: RoomConstants
    imu: ImuConstants
    hall: HallConstants


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


@equation
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
    state: Array, command: Array, air: Array, hand: Hand, c: BenchConstants, out: Array
) -> None:
    """Write the derivative of the bench's state into `out`.

    Args:
        state: (29,) helicopter, servos, bristles.
        command: (5,) shaft commands [rad] and control voltage [V].
        air: (4,) velocity of the air, NED [m/s], and its yaw moment [N m].
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
    sliding = math.sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1])
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
    moment = rigid_body.body_moment(load.yaw + air[3], load.pitch, load.roll, theta, phi)
    b_1s, a_1s, theta_0, theta_t = servos.unmix(state, BenchState.shaft, c.servo)
    helicopter.write_derivative(
        state,
        (b_1s, a_1s, theta_0, theta_t, command[SERVOS]),
        (air[0], air[1], air[2]),
        (load.north, load.east, load.down),
        moment,
        c.helicopter,
        out,
    )
    if c.inertia.swing_mass > 0.0:
        add_arms(state, velocity, c, out)
    for servo in range(SERVOS):
        out[BenchState.shaft + servo] = state[BenchState.shaft_rate + servo]
    command_rates(state, command, c, out)


@compiled
def add_arms(state: Array, velocity: tuple[float, float, float], c: BenchConstants, out: Array) -> None:
    """Correct the acceleration of the platform for the arms' own inertia: (m I + M) a = F - h.

    Args:
        state: (29,) of the bench.
        velocity: of the platform, NED [m/s].
        c: constants of the bench.
        out: (29,) derivative without arms, of which u, v and w are corrected.
    """
    psi, theta, phi = state[State.psi], state[State.theta], state[State.phi]
    u, v, w = state[State.u], state[State.v], state[State.w]
    p, q, r = state[State.p], state[State.q], state[State.r]
    north, east, down = rigid_body.earth_from_body(
        out[State.u] + q * w - r * v,
        out[State.v] + r * u - p * w,
        out[State.w] + p * v - q * u,
        psi,
        theta,
        phi,
    )
    mass, force = np.empty(9), np.empty(3)
    arm_inertia.arm_mass_matrix(
        state[State.x],
        state[State.y],
        state[State.z],
        velocity[0],
        velocity[1],
        velocity[2],
        c.arm,
        c.inertia,
        mass,
        force,
    )
    own = c.helicopter.mass
    force[0], force[1], force[2] = own * north - force[0], own * east - force[1], own * down - force[2]
    mass[0], mass[4], mass[8] = mass[0] + own, mass[4] + own, mass[8] + own
    arm_inertia.solve_three(mass, force, force)
    slower = rigid_body.body_from_earth(force[0] - north, force[1] - east, force[2] - down, psi, theta, phi)
    out[State.u] += slower[0]
    out[State.v] += slower[1]
    out[State.w] += slower[2]


@equation
def command_rates(state: Array, command: Array, c: BenchConstants, out: Array) -> None:
    """Write the only rates that depend on the command at once: servo shafts and motor torque.

    Args:
        state: (29,) of the bench.
        command: (5,) shaft commands [rad] and control voltage [V].
        c: constants of the bench.
        out: (29,) derivative, of which five are overwritten.
    """
    for servo in range(SERVOS):
        angle, rate = state[BenchState.shaft + servo], state[BenchState.shaft_rate + servo]
        out[BenchState.shaft_rate + servo] = servos.shaft_acceleration(angle, rate, command[servo], c.servo)
    current = drive.current(command[SERVOS], state[State.Omega], c.helicopter)
    out[State.M_A] = drive.torque_rate(state[State.M_A], current, c.helicopter)


@equation
def later(hand: Hand, time: float) -> Hand:
    """The homing script some time [s] further on; no hand stays no hand."""
    if hand.time < 0.0:
        return hand
    return Hand(hand.time + time, hand.x, hand.y, hand.z, hand.psi, hand.theta, hand.phi)


@equation
def integrate(
    state: Array,
    slope: Array,
    command: Array,
    air: Array,
    hand: Hand,
    period: float,
    refinement: int,
    c: BenchConstants,
    work: Array,
) -> None:
    """Advance one bench in place by a period, inputs held: classical Runge-Kutta of fourth order.

    Args:
        state: (29,), overwritten.
        slope: (29,) its derivative at the beginning, whatever command it was taken with; overwritten.
        command: (5,) shaft commands [rad] and control voltage [V].
        air: (4,) velocity of the air, NED [m/s], and its yaw moment [N m].
        hand: the homing script at the beginning.
        period: [s].
        refinement: factor on the number of integration steps in it, 1 for flights.
        c: constants of the bench.
        work: (5, 29) working memory.
    """
    near = state[State.z] > c.stop.surface - STOP_MARGIN
    steps = refinement * (STANDING_STEPS if near else FLYING_STEPS)
    h = period / steps
    second, third, fourth, trial = work[0], work[1], work[2], work[3]
    command_rates(state, command, c, slope)
    for step in range(steps):
        middle, end = later(hand, (step + 0.5) * h), later(hand, (step + 1) * h)
        if step > 0:
            bench_derivative(state, command, air, later(hand, step * h), c, slope)
        for index in range(BENCH_STATE_SIZE):
            trial[index] = state[index] + 0.5 * h * slope[index]
        bench_derivative(trial, command, air, middle, c, second)
        for index in range(BENCH_STATE_SIZE):
            trial[index] = state[index] + 0.5 * h * second[index]
        bench_derivative(trial, command, air, middle, c, third)
        for index in range(BENCH_STATE_SIZE):
            trial[index] = state[index] + h * third[index]
        bench_derivative(trial, command, air, end, c, fourth)
        for index in range(BENCH_STATE_SIZE):
            state[index] += h / 6.0 * (slope[index] + 2.0 * (second[index] + third[index]) + fourth[index])


@compiled
def advance_batch(
    states: Array,
    commands: Array,
    airs: Array,
    period: float,
    refinement: int,
    box: Sequence[BenchConstants],
    work: Array,
) -> None:
    """Advance many benches of the same kind in place, each exactly as it would move alone.

    Args:
        states: (n, 29), overwritten.
        commands: (n, 5) shaft commands [rad] and control voltage [V].
        airs: (n, 4) velocity of the air, NED [m/s], and its yaw moment [N m].
        period: [s].
        refinement: factor on the number of integration steps in it, 1 for flights.
        box: constants of the benches, boxed.
        work: (5, 29) working memory.
    """
    c = box[0]
    for bench in range(states.shape[0]):
        bench_derivative(states[bench], commands[bench], airs[bench], NO_HAND, c, work[4])
        integrate(states[bench], work[4], commands[bench], airs[bench], NO_HAND, period, refinement, c, work)
