"""Numbers of the bench's messages: compiled code says what the plain conversions say, bit for bit."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_bench_sim.bench import Bench
from heli_bench_sim.bench_memory import READING_SIZE, Reading
from heli_bench_sim.bench_messages import write_sensors
from heli_common.rig_geometry import RADIAN_PER_COUNT
from heli_common.rotations import Euler
from heli_common.vehicle_state import VehicleState, imu_values, odometry_values, swap_body, swap_earth

NUMBER = st.floats(-100.0, 100.0)


def written(reading, valid, variances):
    encoders, imu = np.zeros(18), np.zeros(37)
    write_sensors(reading, valid, *variances, encoders, imu)
    return encoders, imu


def test_a_quarter_turn_is_five_hundred_counts_and_down_is_turned_up():
    reading = np.zeros(READING_SIZE)
    reading[Reading.count + 3], reading[Reading.indexed + 3] = 500.0, 1.0
    reading[Reading.gyro : Reading.rotor_speed] = (0.1, 0.2, 0.3, 1.0, 2.0, -9.81)
    encoders, imu = written(reading, True, (1e-5, 1e-3))
    assert encoders[3] == pytest.approx(math.pi / 2)
    assert encoders[[9, 15]].tolist() == [0.0, 1.0]
    assert imu[13:16].tolist() == [0.1, -0.2, -0.3]
    assert imu[25:28].tolist() == [1.0, -2.0, 9.81]
    assert imu[4] == -1.0  # no attitude (REP 145)
    assert imu[[16, 20, 24]].tolist() == [1e-5] * 3


@given(st.lists(NUMBER, min_size=6, max_size=6), st.booleans(), st.floats(1e-9, 1.0), st.floats(1e-9, 1.0))
def test_sensors_as_the_plain_conversions_give_them(felt, valid, gyro, force):
    reading = np.zeros(READING_SIZE)
    reading[Reading.count : Reading.count + 6] = (-500.0, -1.0, 0.0, 1.0, 999.0, 1e6)
    reading[Reading.gyro : Reading.rotor_speed] = felt
    encoders, imu = written(reading, valid, (gyro, force))
    assert encoders[:6].tobytes() == (reading[:6].astype(np.int64) * RADIAN_PER_COUNT).tobytes()
    plain = imu_values(tuple(felt[:3]), tuple(felt[3:]), (gyro, force), valid)
    assert imu.tobytes() == np.array(plain).tobytes()


@settings(deadline=None, max_examples=20)
@given(st.lists(st.floats(-0.2, 0.2), min_size=12, max_size=12), st.booleans())
def test_the_truth_as_the_plain_conversions_give_it(motion, outside):
    bench = Bench()
    state = bench.state
    state[:9], state[12:14], state[9] = motion[:9], motion[9:11], motion[11]
    bench.place(state, np.array([0.01, -0.02, 0.1, 0.05, 3.0]))
    bench.set_wind((1.0, -2.0, 0.5))
    bench.set_servo_command(0.0, 0.0, 9.0 if outside else 0.1, 0.0)
    actuators, odometry, wind = np.zeros(15), np.zeros(85), np.zeros(3)
    bench.write_truth(actuators, odometry, wind)
    seen = bench.actuator_state()
    saturated = (float(seen.saturated),) * 4
    joints = (*seen.angles, 0.0, *seen.angle_rates, seen.motor_speed, *saturated, seen.motor_torque)
    assert seen.saturated == outside
    assert actuators.tobytes() == np.array(joints).tobytes()
    vehicle = VehicleState(bench.position, Euler(*bench.attitude), bench.velocity, bench.rates)
    assert odometry.tobytes() == np.array(odometry_values(vehicle, (0.0,) * 6, (0.0,) * 6)).tobytes()
    assert wind.tobytes() == np.array(swap_earth(bench.wind)).tobytes()


def test_the_body_axes_of_the_truth():
    bench = Bench()
    state = bench.state
    state[[6, 7, 12]], state[[9, 8, 13]] = (0.1, 0.2, 0.3), (0.4, 0.5, 0.6)  # u v w, p q r
    bench.place(state, np.zeros(5))
    odometry = np.zeros(85)
    bench.write_truth(np.zeros(15), odometry, np.zeros(3))
    assert odometry[43:46].tolist() == list(swap_body((0.1, 0.2, 0.3)))
    assert odometry[46:49].tolist() == list(swap_body((0.4, 0.5, 0.6)))
