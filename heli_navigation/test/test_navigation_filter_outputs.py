"""What the filter says at the centre of gravity: by hand, and its covariances against differences."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.compiled_messages import write_odometry
from heli_common.records import boxed, packed
from heli_common.rig_geometry import RigGeometry
from heli_navigation.filter_memory import SIZE, Estimate, Memory, Work, blank_memory
from heli_navigation.filter_outputs import (
    TWIST,
    BiasMessage,
    Output,
    read_alarms,
    read_biases,
    read_covariance,
    read_motion,
    read_odometry,
)
from heli_navigation.filter_parameters import FilterParameters, filter_constants
from heli_navigation.strapdown import orient

CONSTANTS = filter_constants(FilterParameters(imu_x=0.10, imu_y=0.03, imu_z=-0.05), RigGeometry())
BOX = boxed(packed(CONSTANTS))
NOISE = CONSTANTS.gyro_density / CONSTANTS.period
SHAKE = np.diag([CONSTANTS.shake_once, CONSTANTS.shake_once, CONSTANTS.shake_twice])


def motion(memory: np.ndarray) -> np.ndarray:
    out = np.zeros(Output.end)
    read_motion(memory, BOX, np.zeros(Work.end), out)
    return out[: Output.pose]


def covariances(memory: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    out = np.zeros(Output.end)
    read_covariance(memory, BOX, np.zeros(Work.end), np.zeros(TWIST * SIZE), out)
    return out[Output.pose : Output.twist].reshape(6, 6), out[Output.twist :].reshape(6, 6)


def body(angles: np.ndarray) -> np.ndarray:
    work = np.zeros(Work.end)
    orient(*angles, work)
    return work[Work.body : Work.rates].reshape(3, 3).copy()


def some_memory(seed: int) -> np.ndarray:
    generator, memory = np.random.default_rng(seed), blank_memory()
    memory[:SIZE] = generator.normal(0.0, 0.2, SIZE)
    memory[Memory.gyro : Memory.force] = generator.normal(0.0, 0.5, 3)
    root = generator.normal(0.0, 1e-2, (SIZE, SIZE))
    memory[Memory.covariance : Memory.gyro] = (root @ root.T).ravel()
    return memory


def test_level_flight_by_hand() -> None:
    memory = blank_memory()
    memory[:3], memory[3:6] = (1.1, 2.03, 2.95), (0.0, 0.5, 0.0)
    memory[Memory.gyro + 2] = 0.2  # turning right: the IMU ahead moves right by 0.1 m * 0.2 rad/s
    said = motion(memory)
    assert said[Output.position : Output.attitude] == pytest.approx((1.0, 2.0, 3.0))
    assert said[Output.velocity : Output.rates] == pytest.approx((0.03 * 0.2, 0.5 - 0.1 * 0.2, 0.0))
    assert said[Output.rates : Output.pose] == pytest.approx((0.0, 0.0, 0.2))


def test_a_known_state_leaves_the_sensors_own_noise() -> None:
    pose, twist = covariances(blank_memory())
    assert not pose.any()
    assert twist[3:, 3:] == pytest.approx(NOISE * np.eye(3))
    # n about z moves the centre of gravity by d x n: -0.1 m to the right, 0.03 m ahead
    assert twist[1, 5] == pytest.approx(-0.10 * NOISE)
    assert twist[0, 5] == pytest.approx(0.03 * NOISE)
    lever = (0.03**2 + 0.05**2) * NOISE
    assert twist[0, 0] == pytest.approx(CONSTANTS.shake_once + lever)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000))
def test_covariances_by_differences(seed: int) -> None:
    memory, step = some_memory(seed), 1e-6
    covariance = memory[Memory.covariance : Memory.gyro].reshape(SIZE, SIZE)
    pose_slope, twist_slope = np.zeros((6, SIZE)), np.zeros((6, SIZE))
    here = body(memory[Estimate.angle : Estimate.gyro_bias])
    for column in range(SIZE):
        up, down = memory.copy(), memory.copy()
        up[column] += step
        down[column] -= step
        slope = (motion(up) - motion(down)) / (2.0 * step)
        pose_slope[:3, column], twist_slope[:, column] = slope[:3], slope[Output.velocity :]
        ends = [body(one[Estimate.angle : Estimate.gyro_bias]) for one in (up, down)]
        spin = (ends[0] - ends[1]) @ here.T / (2.0 * step)
        pose_slope[3:, column] = spin[2, 1], spin[0, 2], spin[1, 0]
    pose, twist = covariances(memory)
    assert pose == pytest.approx(pose_slope @ covariance @ pose_slope.T, abs=1e-9)
    x, y, z = CONSTANTS.x, CONSTANTS.y, CONSTANTS.z
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    felt = np.vstack([cross, np.eye(3)])
    extra = NOISE * felt @ felt.T
    extra[:3, :3] += SHAKE
    assert twist == pytest.approx(twist_slope @ covariance @ twist_slope.T + extra, abs=1e-9)
    assert np.linalg.eigvalsh(pose)[0] > 0.0
    assert np.linalg.eigvalsh(twist)[0] > 0.0


def test_without_imu_the_rates_are_estimates() -> None:
    memory = some_memory(1)
    memory[Memory.gyro : Memory.force] = 0.0
    memory[Memory.coasting] = 1.0
    assert motion(memory)[Output.rates :] == pytest.approx(-memory[Estimate.gyro_bias : Estimate.force_bias])
    covariance = memory[Memory.covariance : Memory.gyro].reshape(SIZE, SIZE)
    assert covariances(memory)[1][3:, 3:] == pytest.approx(covariance[9:12, 9:12])
    assert math.isfinite(covariance.sum())


def test_the_odometry_is_motion_and_covariances() -> None:
    memory, said, values, wanted = some_memory(2), np.zeros(Output.end), np.zeros(85), np.zeros(85)
    read_odometry(memory, BOX, np.zeros(Work.end), np.zeros(TWIST * SIZE), said, values)
    write_odometry(np.concatenate([motion(memory), *(part.ravel() for part in covariances(memory))]), wanted)
    assert values.tolist() == wanted.tolist()


def test_biases_by_hand_and_those_from_before_the_imu_fell_silent() -> None:
    memory, values = blank_memory(), np.full(BiasMessage.end, 7.0)
    memory[Estimate.gyro_bias : Estimate.end] = np.arange(1.0, 7.0)
    for error in range(6):
        memory[Memory.covariance + (SIZE + 1) * (Estimate.gyro_bias + error)] = (error + 1.0) ** 2
    read_biases(memory, BOX, values)
    assert values.tolist() == [1.0, -2.0, -3.0, 4.0, -5.0, -6.0, *[7.0] * 6, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    memory[Memory.coasting], memory[Memory.coasted] = 1.0, 100.0
    memory[Memory.kept_bias : Memory.kept_variance], memory[Memory.kept_variance : Memory.jumps] = 0.5, 1e-6
    read_biases(memory, BOX, values)
    assert values[:6].tolist() == [0.5, -0.5, -0.5, 4.0, -5.0, -6.0]
    assert values[12:15] == pytest.approx([math.sqrt(1e-6 + 100.0 * CONSTANTS.gyro_walk)] * 3)
    assert values[15:].tolist() == [4.0, 5.0, 6.0]


def test_every_alarm_has_a_number_of_its_own() -> None:
    places = [Memory.coasting, *(Memory.lost + encoder for encoder in range(6)), Memory.jumps]
    seen = {read_alarms(blank_memory())}
    assert seen == {0}
    for first in places:
        for second in places:
            memory = blank_memory()
            memory[first] = memory[second] = 1.0
            seen.add(read_alarms(memory))
    memory[Memory.jumps + 2] = 1.0  # a second jump, in another axis
    seen.add(read_alarms(memory))
    assert len(seen) == 2 + 8 + 8 * 7 // 2
