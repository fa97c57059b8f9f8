"""Numbers of the bench's messages, written by compiled code; NED/FRD becomes ENU/FLU on the way out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.actuators import read_actuators
from heli_bench_sim.bench_memory import Memory, Reading
from heli_bench_sim.encoders import ENCODERS
from heli_bench_sim.motion import BenchConstants
from heli_bench_sim.servos import SERVOS
from heli_bench_sim.states import State
from heli_common.compiled import compiled
from heli_common.compiled_messages import write_pose
from heli_common.rig_geometry import RADIAN_PER_COUNT
from heli_common.rotations import Euler
from heli_common.vehicle_state import swap_body, swap_earth

Array = NDArray[np.float64]

_GYRO, _FORCE, _COUNT, _INDEXED = (
    int(part) for part in (Reading.gyro, Reading.accelerometer, Reading.count, Reading.indexed)
)
_AIR = int(Memory.air)


@compiled
def write_sensors(
    reading: Array, valid: bool, gyro_variance: float, force_variance: float, encoders: Array, imu: Array
) -> None:
    """The numbers of `encoders` and of `imu`; as `imu_values`, the attitude is marked unknown (REP 145).

    Args:
        reading: (19,) of one sample, in the columns of `Reading`.
        valid: False marks the IMU's readings as not measured at this sample.
        gyro_variance: of one sample of a gyro [rad^2/s^2].
        force_variance: of one sample of an accelerometer [m^2/s^4].
        encoders: (18,) zeros, written.
        imu: (37,) zeros, written.
    """
    for encoder in range(ENCODERS):
        encoders[encoder] = reading[_COUNT + encoder] * RADIAN_PER_COUNT
        encoders[2 * ENCODERS + encoder] = reading[_INDEXED + encoder]
    known = 1.0 if valid else 0.0
    unknown = known - 1.0
    imu[3], imu[4] = 1.0, -1.0
    imu[13], imu[14], imu[15] = swap_body((reading[_GYRO], reading[_GYRO + 1], reading[_GYRO + 2]))
    imu[25], imu[26], imu[27] = swap_body((reading[_FORCE], reading[_FORCE + 1], reading[_FORCE + 2]))
    for axis in range(3):
        imu[16 + 4 * axis] = known * gyro_variance + (unknown if axis == 0 else 0.0)
        imu[28 + 4 * axis] = known * force_variance + (unknown if axis == 0 else 0.0)


@compiled
def write_truth(
    memory: Array,
    saturated: bool,
    motor_gear: float,
    box: Sequence[BenchConstants],
    actuators: Array,
    odometry: Array,
    wind: Array,
) -> None:
    """The numbers of `actuator_state`, `ground_truth` (no covariance: it is the truth) and `wind`.

    Args:
        memory: of the bench, in the parts of `Memory`.
        saturated: whether the limits changed the latest servo command.
        motor_gear: motor turns per rotor turn.
        box: constants of the bench, boxed.
        actuators: (15,) written.
        odometry: (85,) zeros, written.
        wind: (3,) written.
    """
    state = memory[Memory.state : Memory.slope]
    channels = SERVOS + 1
    read_actuators(state, memory[Memory.command : Memory.air], box, actuators)
    for blade in range(SERVOS - 1, -1, -1):
        actuators[channels + blade] = actuators[SERVOS + blade]
        actuators[2 * channels + blade] = 1.0 if saturated else 0.0
    actuators[SERVOS] = 0.0
    actuators[channels + SERVOS] = motor_gear * state[State.Omega]
    actuators[2 * channels + SERVOS] = state[State.M_A]
    attitude = Euler(state[State.psi], state[State.theta], state[State.phi])
    write_pose((state[State.x], state[State.y], state[State.z]), attitude, odometry[:7])
    odometry[43], odometry[44], odometry[45] = swap_body((state[State.u], state[State.v], state[State.w]))
    odometry[46], odometry[47], odometry[48] = swap_body((state[State.p], state[State.q], state[State.r]))
    wind[0], wind[1], wind[2] = swap_earth((memory[_AIR], memory[_AIR + 1], memory[_AIR + 2]))
