"""From sample to sample: motion, air, sensors; compiled, for one bench and any number of samples.

At a sample the air moves on, the slope of the motion is taken in it, and the sensors read. The same slope is
the first stage of the next step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import encoders, hall_sensor, homing_hand, imu, room_air, wind_generator
from heli_bench_sim.bench_memory import Memory, Noise, Reading
from heli_bench_sim.delta_arm import ARMS, solve_arms
from heli_bench_sim.encoders import ENCODERS, Counter
from heli_bench_sim.motion import (
    BENCH_STATE_SIZE,
    NO_HAND,
    BenchConstants,
    Hand,
    bench_derivative,
    integrate,
    later,
)
from heli_bench_sim.rotor_azimuth import turned
from heli_bench_sim.states import State
from heli_common.compiled import compiled
from heli_common.timing import SENSOR_PERIOD

Array = NDArray[np.float64]
Counters = NDArray[np.int64]

WORK_SIZE = 10
"""Scratch numbers of `run` beside the rows of the integration: arm and gimbal angles, air."""


@compiled
def read_hand(memory: Array) -> Hand:
    """The homing script as the bench remembers it.

    Args:
        memory: of the bench, in the parts of `Memory`.
    """
    at = Memory.hand
    return Hand(
        memory[at],
        memory[at + 1],
        memory[at + 2],
        memory[at + 3],
        memory[at + 4],
        memory[at + 5],
        memory[at + 6],
    )


@compiled
def blow(memory: Array, normals: Array, c: BenchConstants, scratch: Array) -> None:
    """Move jet and room on by one sensor period and note the air at the helicopter.

    Args:
        memory: of the bench, in the parts of `Memory`.
        normals: (n,) standard normal numbers of this sample, in the columns of `Noise`.
        c: constants of the bench.
        scratch: (4 or more,) working memory.
    """
    jet, room = memory[Memory.jet : Memory.room], memory[Memory.room : Memory.hand]
    wind_generator.wind_advance(
        jet, memory[Memory.fan_command], normals[Noise.jet : Noise.room], SENSOR_PERIOD, c.jet
    )
    room_air.room_advance(room, normals[Noise.room : Noise.end], SENSOR_PERIOD, c.room)
    feel(memory, c, scratch)


@compiled
def feel(memory: Array, c: BenchConstants, scratch: Array) -> None:
    """Note the air at the helicopter as jet and room now are.

    Args:
        memory: of the bench, in the parts of `Memory`.
        c: constants of the bench.
        scratch: (4 or more,) working memory.
    """
    jet, room = memory[Memory.jet : Memory.room], memory[Memory.room : Memory.hand]
    air, steady = Memory.air, Memory.steady_wind
    wind_generator.wind_at(memory[State.x], memory[State.y], memory[State.z], jet, c.jet, scratch)
    for axis in range(3):
        memory[air + axis] = memory[steady + axis] + scratch[axis]
    room_air.room_gust(room, memory[State.V_i], c.room, scratch)
    for axis in range(4):
        if axis < 3:
            memory[air + axis] += scratch[axis]
        else:
            memory[air + axis] = scratch[axis]


@compiled
def refresh(memory: Array, box: Sequence[BenchConstants], scratch: Array) -> None:
    """Take the air and the slope anew, after something but a command has been changed by hand.

    Args:
        memory: of the bench, in the parts of `Memory`.
        box: constants of the bench, boxed.
        scratch: (4 or more,) working memory.
    """
    c = box[0]
    feel(memory, c, scratch)
    bench_derivative(
        memory[Memory.state : Memory.slope],
        memory[Memory.command : Memory.air],
        memory[Memory.air : Memory.steady_wind],
        read_hand(memory),
        c,
        memory[Memory.slope : Memory.command],
    )


@compiled
def sense(
    memory: Array, counters: Counters, normals: Array, c: BenchConstants, angles: Array, reading: Array
) -> bool:
    """Read every sensor; False, and nothing read, if no posture of the arms reaches the platform.

    Args:
        memory: of the bench, in the parts of `Memory`.
        counters: (4, 6) of the encoders.
        normals: (n,) standard normal numbers of this sample, in the columns of `Noise`.
        c: constants of the bench.
        angles: (6 or more,) working memory.
        reading: (19,) receives what they say, in the columns of `Reading`.
    """
    if not solve_arms(memory[State.x], memory[State.y], memory[State.z], c.arm, angles):
        return False
    for axis in range(ENCODERS - ARMS):
        angles[ARMS + axis] = memory[State.psi + axis]
    encoders.follow(angles, counters)
    for encoder in range(ENCODERS):
        reading[Reading.count + encoder] = encoders.count(encoder, counters)
        reading[Reading.indexed + encoder] = counters[Counter.indexed, encoder]
    imu.imu_sample(
        memory[Memory.state : Memory.slope],
        memory[Memory.slope : Memory.command],
        memory[Memory.azimuth],
        memory[Memory.imu_bias : Memory.end],
        normals[Noise.imu : Noise.jet],
        c.imu,
        reading[Reading.gyro : Reading.rotor_speed],
    )
    reading[Reading.rotor_speed] = hall_sensor.hall_sample(
        memory[State.Omega], memory[Memory.azimuth], memory[Memory.hall : Memory.imu_bias], c.hall
    )
    return True


@compiled
def run(
    memory: Array,
    counters: Counters,
    normals: Array,
    refinement: int,
    box: Sequence[BenchConstants],
    work: Array,
    scratch: Array,
    readings: Array,
) -> int:
    """Go on by as many sensor periods as there are rows of readings, commands held.

    Stops early if the motion becomes numerically meaningless or leaves the arms' reach; the encoders then
    stay where they were.

    Args:
        memory: of the bench, in the parts of `Memory`, overwritten.
        counters: (4, 6) of the encoders, overwritten.
        normals: (n, 16) standard normal numbers, in the columns of `Noise`.
        refinement: factor on the number of integration steps, 1 for flights.
        box: constants of the bench, boxed.
        work: (5, 29) working memory.
        scratch: (10,) working memory.
        readings: (n, 19) receives what the sensors say, in the columns of `Reading`.

    Returns:
        how many samples were completed.
    """
    c = box[0]
    state, slope = memory[Memory.state : Memory.slope], memory[Memory.slope : Memory.command]
    command, air = memory[Memory.command : Memory.air], memory[Memory.air : Memory.steady_wind]
    for sample in range(readings.shape[0]):
        hand, omega = read_hand(memory), state[State.Omega]
        integrate(state, slope, command, air, hand, SENSOR_PERIOD, refinement, c, work)
        for index in range(BENCH_STATE_SIZE):
            if not math.isfinite(state[index]):
                return sample
        hand = later(hand, SENSOR_PERIOD)
        if hand.time > homing_hand.duration(c.hand):
            hand = NO_HAND
        memory[Memory.hand] = hand.time
        memory[Memory.azimuth] = turned(memory[Memory.azimuth], omega, state[State.Omega], SENSOR_PERIOD)
        blow(memory, normals[sample], c, scratch)
        bench_derivative(state, command, air, hand, c, slope)
        if not sense(memory, counters, normals[sample], c, scratch, readings[sample]):
            return sample
    return int(readings.shape[0])
