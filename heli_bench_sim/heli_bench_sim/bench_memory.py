"""All that a bench remembers from one sample to the next, in one array: copy it and you have the bench.

The counters of the encoders stand beside it, because they are whole numbers.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.hall_sensor import HALL_STATE_SIZE
from heli_bench_sim.imu import IMU_NORMALS, IMU_SIZE
from heli_bench_sim.motion import AIR_SIZE, BENCH_STATE_SIZE, COMMAND_SIZE, Hand
from heli_bench_sim.room_air import ROOM_NORMALS, ROOM_STATE_SIZE
from heli_bench_sim.wind_generator import WIND_NORMALS, WIND_STATE_SIZE

Array = NDArray[np.float64]

HAND_SIZE = len(Hand._fields)


class Memory(IntEnum):
    """Where each part begins; a part reaches to the beginning of the next."""

    state = 0
    """helicopter, servos, bristles, in the order of `State` and `BenchState`"""
    slope = BENCH_STATE_SIZE
    """derivative of the state at the latest sample"""
    command = slope + BENCH_STATE_SIZE
    """latched shaft commands [rad] and control voltage [V]"""
    air = command + COMMAND_SIZE
    """velocity of the air at the helicopter, NED [m/s], and its yaw moment [N m]"""
    steady_wind = air + AIR_SIZE
    """part of it that is the same everywhere, NED [m/s]"""
    fan_command = steady_wind + 3
    """speed asked of the wind generator [m/s]"""
    jet = fan_command + 1
    """fan and turbulence, in the order of `WindState`"""
    room = jet + WIND_STATE_SIZE
    """the rotor's own air coming back, in the order of `RoomState`"""
    hand = room + ROOM_STATE_SIZE
    """the homing script, in the order of `Hand`"""
    azimuth = hand + HAND_SIZE
    """of the main rotor [rad]"""
    hall = azimuth + 1
    """converter of the rotor speed sensor"""
    imu_bias = hall + HALL_STATE_SIZE
    """biases of the IMU's next sample, in the order of `ImuAxis`, FRD"""
    end = imu_bias + IMU_SIZE


class Reading(IntEnum):
    """Columns of what the sensors say at one sample; the first of several where a part is longer than one."""

    count = 0
    """six counts of the encoders"""
    indexed = 6
    """six flags, 1 once the index pulse has passed"""
    gyro = 12
    """three body rates, FRD [rad/s]"""
    accelerometer = 15
    """three specific forces, FRD [m/s^2]"""
    rotor_speed = 18
    """by the Hall sensor [rad/s]"""
    end = 19


READING_SIZE = int(Reading.end)


class Noise(IntEnum):
    """Columns of the standard normal numbers that one sample needs; the first of each component."""

    imu = 0
    jet = IMU_NORMALS
    room = jet + WIND_NORMALS
    end = room + ROOM_NORMALS


def blank_memory() -> Array:
    """Zeros everywhere, and no hand."""
    memory = np.zeros(Memory.end)
    memory[Memory.hand] = -1.0
    return memory
