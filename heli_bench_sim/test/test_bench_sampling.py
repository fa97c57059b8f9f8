"""The bench sample by sample: sensors, air, faults and exchanged parts, together in one loop."""

import dataclasses
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from heli_bench_sim.arm_inertia import ArmInertiaParameters, arm_inertia_constants, arm_mass_matrix
from heli_bench_sim.bench import NOISE_BLOCK, Bench
from heli_bench_sim.bench_memory import Memory, Noise, Reading, blank_memory
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.delta_arm import arm_constants
from heli_bench_sim.faults import (
    EncoderLostCounts,
    EncoderStuck,
    Fault,
    FaultSchedule,
    ImuBiasJump,
    ImuDropout,
    ServoJam,
    SupplySag,
)
from heli_bench_sim.imu import ImuReading, ImuTruth
from heli_bench_sim.imu_parameters import ImuParameters
from heli_bench_sim.parameters import thesis
from heli_bench_sim.room_air import GUSTY_ROOM
from heli_bench_sim.states import Input, State
from heli_bench_sim.trim import trim
from heli_common.timing import SENSOR_PERIOD, SENSOR_PERIOD_NS

Array = NDArray[np.float64]
HOVER = trim(thesis())
QUIET_IMU = ImuParameters(
    gyro_noise=0.0,
    gyro_bias=0.0,
    gyro_walk=0.0,
    accelerometer_noise=0.0,
    accelerometer_bias=0.0,
    vibration_once=0.0,
    vibration_twice=0.0,
    bits=24.0,
)


def hovering(bench: Bench, **changes: float) -> Bench:
    state = HOVER.state
    for name, value in changes.items():
        state[State[name]] = value
    bench.place(state, HOVER.inputs)
    return bench


def test_parts_of_the_memory_follow_each_other() -> None:
    assert list(Memory) == sorted(Memory)
    assert blank_memory().shape == (Memory.end,)
    assert Memory.azimuth - Memory.hand == 7
    assert Reading.end == Reading.rotor_speed + 1
    assert list(Noise) == sorted(Noise)


@pytest.mark.parametrize("cut", [1, 3, 7, NOISE_BLOCK + 1])
def test_however_cut_the_flight_is_the_same_to_the_last_bit(cut: int) -> None:
    parameters = BenchParameters(room=GUSTY_ROOM)
    whole, pieces = (hovering(Bench(parameters, seed=5), u=0.2) for _ in range(2))
    for bench in (whole, pieces):
        bench.set_fan(3.0)
    samples = 2 * NOISE_BLOCK + 5
    expected = whole.run(samples)
    rows = []
    while (left := samples - len(rows) * cut) > 0:
        rows.append(pieces.run(min(cut, left)))
    assert np.concatenate(rows).tobytes() == expected.tobytes()
    assert pieces.memory.tobytes() == whole.memory.tobytes()
    assert pieces.stamp_ns == whole.stamp_ns


def test_seeds_differ_and_repeat() -> None:
    first, again, other = (hovering(Bench(seed=seed)).run(50) for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes()
    imu, counts = slice(Reading.gyro, Reading.rotor_speed), slice(Reading.count, Reading.gyro)
    assert (first[:, imu] != other[:, imu]).any()
    assert (first[:, counts] == other[:, counts]).all()


def test_placed_in_flight_every_sensor_reads_at_once() -> None:
    bench = hovering(Bench(BenchParameters(imu=QUIET_IMU)))
    assert bench.rotor_reading() == pytest.approx(163.363, abs=0.1)
    reading = bench.imu_reading()
    assert reading.valid
    theta, phi = HOVER.theta, HOVER.phi
    gravity = np.array([math.sin(theta), -math.sin(phi) * math.cos(theta), -math.cos(phi) * math.cos(theta)])
    assert reading.accelerometer == pytest.approx(9.81 * gravity, abs=1e-4)
    assert reading.gyro == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)
    speeds = [float(row[Reading.rotor_speed]) for row in bench.run(40)]
    assert speeds == pytest.approx([163.363] * 40, abs=0.1)


def test_accelerometer_feels_what_the_motion_does() -> None:
    """Twin: the mean of the specific force over a sample is what changes the velocity, in earth axes."""
    bench = hovering(Bench(BenchParameters(imu=dataclasses.replace(QUIET_IMU, x=0.0, z=0.0))), u=1.0, v=-0.5)
    steps = []
    for _ in range(200):
        _, theta, phi = bench.attitude
        velocity, before = np.array(bench.velocity), np.array(bench.imu_reading().accelerometer)
        rates = np.array(bench.rates)
        bench.advance()
        after = np.array(bench.imu_reading().accelerometer)
        sine, cosine = math.sin(theta), math.cos(theta)
        gravity = 9.81 * np.array([-sine, math.sin(phi) * cosine, math.cos(phi) * cosine])
        change = (np.array(bench.velocity) - velocity) / SENSOR_PERIOD
        turning = np.cross(0.5 * (rates + bench.rates), 0.5 * (velocity + bench.velocity))
        steps.append(change + turning - gravity - 0.5 * (before + after))
    assert np.abs(steps).max() < 0.02


def test_still_room_has_no_air_and_a_fan_blows_from_the_front() -> None:
    bench = hovering(Bench())
    bench.run(100)
    assert bench.wind == (0.0, 0.0, 0.0)
    assert bench.gust_yaw == 0.0
    bench.set_fan(5.0)
    bench.run(600)
    assert bench.fan_speed == pytest.approx(5.0 * (1.0 - math.exp(-1.0)), rel=1e-6)
    assert bench.wind[0] < -1.5
    with pytest.raises(ValueError, match=r"0 \.\. 8"):
        bench.set_fan(9.0)


def test_gusts_come_and_go_with_the_rotor() -> None:
    parameters = BenchParameters(room=GUSTY_ROOM)
    flying, standing = hovering(Bench(parameters)), Bench(parameters)
    flying.run(400)
    standing.run(400)
    assert np.abs(flying.wind).max() > 0.1
    assert flying.gust_yaw != 0.0
    assert standing.wind == (0.0, 0.0, 0.0)


class WoodenImu:
    """Somebody's own: no noise, no vibration, whole centimetres per second squared."""

    def __init__(self) -> None:
        self.stamps: list[int] = []

    def sample(self, truth: ImuTruth) -> ImuReading:
        self.stamps.append(truth.stamp_ns)
        north, east, down = (round(part, 2) for part in truth.specific_force)
        return ImuReading(truth.rates, (north, east, down), valid=len(self.stamps) % 10 != 0)


def test_somebody_s_own_imu_is_read() -> None:
    own = WoodenImu()
    bench = hovering(Bench(imu=own))
    plain = hovering(Bench())
    for sample in range(25):
        assert bench.imu_reading().accelerometer[2] == round(bench.imu_reading().accelerometer[2], 2)
        assert bench.imu_reading().valid == ((sample + 2) % 10 != 0)
        bench.advance()
        plain.advance()
    assert own.stamps == [0, 0, *(SENSOR_PERIOD_NS * k for k in range(1, 26))]  # power-up, placing, flying
    assert bench.imu_reading().gyro == bench.rates
    assert bench.whole_state.tobytes() == plain.whole_state.tobytes()


def with_fault(*faults: Fault) -> Bench:
    return hovering(Bench(faults=FaultSchedule(faults)), u=0.5, q=0.2)


def test_encoder_faults_show_in_the_counts_only() -> None:
    at = 20 * SENSOR_PERIOD_NS
    bench = with_fault(
        EncoderStuck(start_ns=at, encoder="arm_1"), EncoderLostCounts(start_ns=at, encoder="yaw", counts=-40)
    )
    sound = with_fault()
    wrong, right = bench.run(100), sound.run(100)
    assert (wrong[:19] == right[:19]).all()
    assert (wrong[19:, Reading.count] == wrong[19, Reading.count]).all()
    assert (right[19:, Reading.count] != right[19, Reading.count]).any()
    assert (wrong[19:, Reading.count + 3] == right[19:, Reading.count + 3] - 40).all()
    assert bench.whole_state.tobytes() == sound.whole_state.tobytes()
    assert bench.faults.values(bench.stamp_ns)[:2] == (1.0, 8.0)


def test_imu_faults_show_in_its_readings_only() -> None:
    at, end = 20 * SENSOR_PERIOD_NS, 30 * SENSOR_PERIOD_NS
    bench = with_fault(
        ImuDropout(start_ns=at, end_ns=end), ImuBiasJump(start_ns=end, axis="gyro_x", size=math.radians(20.0))
    )
    sound = with_fault()
    wrong, right = bench.run(60), sound.run(60)
    imu = slice(Reading.gyro, Reading.rotor_speed)
    assert (wrong[:19] == right[:19]).all()
    assert (wrong[19:29, imu] == wrong[18, imu]).all()
    jump = wrong[29:, Reading.gyro] - right[29:, Reading.gyro]
    assert jump == pytest.approx(np.full(31, math.radians(20.0)), abs=math.radians(300.0 / 2048.0))
    assert bench.imu_bias[0] - sound.imu_bias[0] == pytest.approx(math.radians(20.0), rel=1e-9)


def test_actuator_faults_change_the_flight() -> None:
    at = 10 * SENSOR_PERIOD_NS
    bench = with_fault(ServoJam(start_ns=at, servo="tail"), SupplySag(start_ns=at, fraction=0.5))
    bench.run(10)
    held = bench.command[3]
    bench.set_servo_command(0.0, 0.0, 0.1, 0.3)
    bench.run(20)
    assert bench.command[3] == held != 0.0
    assert bench.actuator_state().angles[3] == pytest.approx(HOVER.inputs[Input.theta_t], abs=0.02)
    assert bench.command[4] == pytest.approx(0.5 * HOVER.inputs[Input.U_mot])
    assert bench.actuator_state().motor_current == 0.0


def test_a_fault_can_be_asked_for_in_flight() -> None:
    bench = with_fault()
    bench.run(7)
    bench.add_fault(EncoderStuck(start_ns=0, encoder="roll"))
    assert not bench.faults.quiet(bench.stamp_ns)
    rows = bench.run(40)
    assert (rows[:, Reading.count + 5] == rows[0, Reading.count + 5]).all()


def test_heavy_arms_fall_by_their_mass_matrix() -> None:
    """Dropped from rest at the centre: (m + M_zz) a = m g, by hand."""
    arms = ArmInertiaParameters(active=1.0)
    light, heavy = Bench(), Bench(BenchParameters(arms=arms))
    for bench in (light, heavy):
        bench.place(np.zeros(len(State)), np.zeros(len(Input)))
        bench.run(4)
    mass, force = np.empty(9), np.empty(3)
    geometry = arm_constants(heavy.parameters.geometry)
    arm_mass_matrix(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, geometry, arm_inertia_constants(arms), mass, force)
    assert heavy.velocity[2] / light.velocity[2] == pytest.approx(7.3 / (7.3 + mass[8]), rel=2e-3)


def test_descent_through_its_own_wake_is_told_with_quantity_and_bound() -> None:
    bench = hovering(Bench(), z=-0.3, w=3.5)
    (violation,) = bench.violations
    assert violation.name == "vortex_ring"
    assert violation.bound == 0.5
    assert "descent over induced velocity" in str(violation)
    bench.run(400)
    assert bench.is_finite
