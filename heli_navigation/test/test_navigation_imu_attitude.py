"""Attitude from the IMU alone: by hand, against numerical twins, and honest about its own errors."""

import math
from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import chi2

from heli_common.compiled import compiled
from heli_common.quantities import about
from heli_common.records import boxed, packed
from heli_common.rotations import Euler, Quaternion, matrix_from_euler
from heli_common.vehicle_state import UNKNOWN_VARIANCE, attitude_ned
from heli_navigation.imu_attitude import LARGEST, STEEPEST, ImuAttitude, attitude_step
from heli_navigation.imu_attitude_equations import ROWS, AttitudeMemory, cell, correct, euler_rates, predict
from heli_navigation.imu_attitude_parameters import (
    SLOWEST_CORRECTION,
    STILL_SAMPLES,
    ImuAttitudeConstants,
    ImuAttitudeParameters,
    acceleration_density,
    correction_bandwidth,
    imu_attitude_constants,
)

Array = NDArray[np.float64]

G, PERIOD = 9.81, 0.0025
DEG = math.radians(1.0)
STANDARD = ImuAttitudeParameters()
AT_CENTRE = replace(STANDARD, imu_x=0.0, imu_z=0.0)
C = packed(imu_attitude_constants(STANDARD))
STILL = (0.0, 0.0, 0.0)
LEVEL = (0.0, 0.0, -G)
RARE = 1e-5
"""Chance that a right filter fails one chi-square test; the seeds are fixed all the same."""


@compiled
def follow(memory: Array, readings: Array, box: Sequence[ImuAttitudeConstants], out: Array) -> None:
    """Angles, biases and their variances, one row per sample."""
    for k in range(readings.shape[0]):
        attitude_step(
            memory,
            readings[k, 0],
            readings[k, 1],
            readings[k, 2],
            readings[k, 3],
            readings[k, 4],
            readings[k, 5],
            True,
            box,
        )
        for row in range(6):
            out[k, row] = memory[row]
            out[k, 6 + row] = memory[cell(row, row)]


def run(readings: Array, start: Euler, parameters: ImuAttitudeParameters = STANDARD) -> tuple[Array, Array]:
    """(n, 6) estimates and (n, 6) standard deviations; `start` is the attitude at the first sample."""
    filter_ = ImuAttitude(parameters)
    filter_.step(readings[0, :3].tolist(), readings[0, 3:].tolist())
    filter_.align(*start)
    out = np.empty((len(readings) - 1, 12))
    follow(filter_._memory, readings[1:], filter_._box, out)
    return out[:, :6], np.sqrt(out[:, 6:])


def matrices(angles: Array) -> Array:
    """(n, 3, 3) C_nb of (n, 3) psi, theta, phi."""
    c, s = np.cos(angles).T, np.sin(angles).T
    return np.array(
        [
            [c[0] * c[1], c[0] * s[1] * s[2] - s[0] * c[2], c[0] * s[1] * c[2] + s[0] * s[2]],
            [s[0] * c[1], s[0] * s[1] * s[2] + c[0] * c[2], s[0] * s[1] * c[2] - c[0] * s[2]],
            [-s[1], c[1] * s[2], c[1] * c[2]],
        ]
    ).transpose(2, 0, 1)


class Motion:
    """Swinging angles and positions, beginning at rest; what a perfect IMU reads of them.

    Args:
        seed: of frequencies and phases.
        angle: amplitude of yaw, pitch and roll [rad].
        distance: amplitude of the position [m].
        place: of the IMU from the centre of gravity, body FRD [m].
        rest: how long it stands before [s].
    """

    def __init__(
        self,
        seed: int,
        angle: Sequence[float] = (0.5, 0.1, 0.1),
        distance: float = 0.05,
        place: Sequence[float] = (0.10, 0.0, -0.05),
        rest: float = 0.0,
    ) -> None:
        draw = np.random.default_rng(seed)
        self.size = np.array([*angle, distance, distance, distance])
        self.omega = draw.uniform(0.8, 4.0, 6)
        self.place, self.rest = np.asarray(place), rest

    def pose(self, time: Array) -> Array:
        """(n, 6) psi, theta, phi [rad], north, east, down [m]; a swing that sets in smoothly."""
        moving = np.maximum(time - self.rest, 0.0)[:, None]
        pose: Array = self.size * np.sin(self.omega * moving) * -np.expm1(-(moving**3))
        return pose

    def angles(self, time: Array) -> Array:
        return self.pose(time)[:, :3]

    def readings(self, time: Array) -> Array:
        """(n, 6) body rates and specific force, by differencing angles and the IMU's place in the earth."""
        step = 1e-4

        def where(moment: Array) -> Array:
            pose = self.pose(moment)
            place: Array = pose[:, 3:] + matrices(pose[:, :3]) @ self.place
            return place

        angles = self.angles(time)
        slope = (self.angles(time + step) - self.angles(time - step)) / (2.0 * step)
        psi, theta, phi = slope.T
        s, c = np.sin(angles).T, np.cos(angles).T
        rates = np.array(
            [
                phi - psi * s[1],
                theta * c[2] + psi * c[1] * s[2],
                -theta * s[2] + psi * c[1] * c[2],
            ]
        ).T
        acceleration = (where(time + step) - 2.0 * where(time) + where(time - step)) / step**2
        force = np.einsum("kji,kj->ki", matrices(angles), acceleration - [0.0, 0.0, G])
        return np.hstack([rates, force])


def noisy(perfect: Array, seed: int, parameters: ImuAttitudeParameters = STANDARD) -> tuple[Array, Array]:
    """Readings with noise, walking biases and vibration while not standing; and (n, 3) the gyros' biases."""
    draw, count = np.random.default_rng(seed), len(perfect)
    p = parameters
    walk = np.cumsum(p.gyro_walk * math.sqrt(PERIOD) * draw.standard_normal((count, 3)), axis=0)
    bias = p.gyro_bias * draw.standard_normal(3) + walk
    readings = perfect.copy()
    readings[:, :3] += bias + p.gyro_noise / math.sqrt(PERIOD) * draw.standard_normal((count, 3))
    readings[:, 3:] += p.accelerometer_bias * draw.standard_normal(3)
    readings[:, 3:] += p.accelerometer_noise / math.sqrt(PERIOD) * draw.standard_normal((count, 3))
    turn = 163.363 * PERIOD * np.arange(count)
    shaking = np.abs(perfect[:, :3]).max(axis=1) > 0.0
    readings[:, 3] += 0.5 * shaking * np.cos(turn)
    readings[:, 4] -= 0.5 * shaking * np.sin(turn)
    readings[:, 5] += 0.8 * shaking * np.cos(2.0 * turn)
    return readings, bias


def times(seconds: float) -> Array:
    return np.arange(round(seconds / PERIOD)) * np.float64(PERIOD)


def aligned(parameters: ImuAttitudeParameters = STANDARD, attitude: Sequence[float] = STILL) -> ImuAttitude:
    filter_ = ImuAttitude(parameters)
    filter_.align(*attitude)
    return filter_


def knows(filter_: ImuAttitude) -> bool:
    return filter_.known


def resting(attitude: Sequence[float]) -> tuple[float, float, float]:
    """What accelerometers read at rest."""
    _, theta, phi = attitude
    return G * math.sin(theta), -G * math.cos(theta) * math.sin(phi), -G * math.cos(theta) * math.cos(phi)


# Parameters --------------------------------------------------------------------------------------------


def test_defaults_are_in_their_ranges() -> None:
    for field in fields(ImuAttitudeParameters):
        known = about(field)
        assert known.minimum <= getattr(STANDARD, field.name) <= known.maximum, field.name


def test_constants_by_hand() -> None:
    """0.02 deg/s/sqrt(Hz) over 2.5 ms: 0.001 deg; 0.01 deg/s/sqrt(s): 0.0005 deg/s; 0.4 deg/s / sqrt(200)."""
    assert math.sqrt(C.turn_variance) == pytest.approx(0.001 * DEG, rel=1e-12)
    assert math.sqrt(C.walk_variance) == pytest.approx(0.0005 * DEG, rel=1e-12)
    assert math.sqrt(C.alignment) == pytest.approx(0.18 * DEG / math.sqrt(12.0), rel=1e-12)
    assert C.still_gyro == pytest.approx((1.3 * 0.4 * DEG) ** 2, rel=1e-12)
    assert C.still_variance == pytest.approx((0.4 * DEG) ** 2 / 200 + (0.01 * DEG) ** 2, rel=1e-12)
    assert C.force_variance == pytest.approx(acceleration_density(STANDARD) * 400.0 + 0.06**2, rel=1e-12)


@given(st.floats(1e-5, 1e-2), st.floats(0.01, 2.0))
def test_noise_of_acceleration_makes_the_two_errors_equal(walk: float, spread: float) -> None:
    p = replace(STANDARD, gyro_walk=walk, velocity_spread=spread)
    omega, density = correction_bandwidth(p), acceleration_density(p)
    gain = math.sqrt(2.0) * omega
    assert 0.75 * gain * density / G**2 == pytest.approx((gain * spread / G) ** 2, rel=1e-12)
    if omega > SLOWEST_CORRECTION:
        assert omega**4 == pytest.approx(walk**2 * G**2 / density, rel=1e-9)


def test_correction_without_walk_is_the_slowest() -> None:
    assert correction_bandwidth(replace(STANDARD, gyro_walk=0.0)) == SLOWEST_CORRECTION


def test_bandwidth_is_that_of_the_kalman_filter() -> None:
    """In calm flight the gain settles at K_1 = sqrt(2) omega, a little more for the gyros' noise."""
    p = replace(AT_CENTRE, accelerometer_bias=0.0, still_margin=0.0)
    filter_ = aligned(p)
    readings = np.tile([*STILL, *LEVEL], (40_000, 1))
    follow(filter_._memory, readings, filter_._box, np.empty((len(readings), 12)))
    density = acceleration_density(p)
    gain = filter_.covariance[1, 1] * G**2 / density
    expected = math.sqrt(2.0 * correction_bandwidth(p) ** 2 + p.gyro_noise**2 * G**2 / density)
    assert gain == pytest.approx(expected, rel=0.01)


# By hand -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("attitude", [STILL, (1.0, 0.3, -0.4), (-3.0, -1.2, 2.0)])
def test_at_rest_it_stays(attitude: tuple[float, float, float]) -> None:
    filter_ = aligned(attitude=attitude)
    for _ in range(2000):
        filter_.step(STILL, resting(attitude))
    assert filter_.attitude == pytest.approx(attitude, abs=1e-12)
    assert filter_.bias == pytest.approx(STILL, abs=1e-12)
    assert filter_.accelerometer_bias == pytest.approx(STILL, abs=1e-12)


def test_pure_yaw_by_hand() -> None:
    """Half a turn a second from 170 deg for 1.5 s: 440 deg, which is 80 deg."""
    filter_ = aligned(AT_CENTRE, (170.0 * DEG, 0.0, 0.0))
    for _ in range(600):
        filter_.step((0.0, 0.0, math.pi), LEVEL)
    assert filter_.attitude == pytest.approx((80.0 * DEG, 0.0, 0.0), abs=1e-9)
    assert filter_.standstills == 0


def test_nothing_is_known_before_the_start() -> None:
    filter_ = ImuAttitude()
    for _ in range(10):
        filter_.step((1.0, 1.0, 1.0), LEVEL)
    assert not knows(filter_)
    assert filter_.attitude == STILL
    assert filter_.sigma[:3] == (math.sqrt(UNKNOWN_VARIANCE),) * 3
    assert filter_.sigma[3:] == pytest.approx((0.5 * DEG,) * 3, rel=1e-4)
    filter_.align(0.1, 0.2, 0.3)
    assert knows(filter_)
    assert filter_.attitude == Euler(0.1, 0.2, 0.3)
    assert filter_.sigma[:3] == pytest.approx((0.18 * DEG / math.sqrt(12.0),) * 3, rel=1e-12)


def test_yaw_grows_as_predicted_by_hand() -> None:
    """Level, all else known: var psi = sigma_0^2 + N^2 t + sigma_b^2 t^2 + K^2 t^3 / 3."""
    p = replace(STANDARD, still_margin=0.0)
    filter_ = aligned(p)
    for _ in range(4000):
        filter_.step(STILL, LEVEL)
    variance = (
        p.alignment**2 + p.gyro_noise**2 * 10.0 + p.gyro_bias**2 * 100.0 + p.gyro_walk**2 * 1000.0 / 3.0
    )
    assert filter_.sigma[0] == pytest.approx(math.sqrt(variance), rel=1e-3)


def test_dropout_grows_sigma_by_hand() -> None:
    filter_ = aligned()
    for _ in range(400):
        filter_.step(STILL, LEVEL)
    before = filter_.sigma
    for _ in range(400):
        filter_.step((math.nan,) * 3, (math.nan,) * 3, valid=False)
    blind = filter_.sigma
    for axis in range(3):
        expected = math.hypot(before[axis], STANDARD.blind_noise)  # over 1 s
        assert blind[axis] == pytest.approx(expected, rel=1e-3)
    assert filter_.skipped == 400
    assert filter_.attitude == pytest.approx(STILL, abs=1e-12)
    for _ in range(8000):
        filter_.step(STILL, LEVEL)
    after = filter_.sigma
    assert after[0] > 0.99 * blind[0]
    assert max(after[1:3]) < 0.1 * blind[1]


def test_start_anew_keeps_the_biases() -> None:
    filter_ = aligned()
    for _ in range(1000):
        filter_.step((0.002, -0.003, 0.004), LEVEL)
    bias, sigma = filter_.bias, filter_.sigma
    assert filter_.standstills == 5
    filter_.align(3.0 + math.tau, 0.1, -0.1)
    assert filter_.attitude == pytest.approx((3.0, 0.1, -0.1), abs=1e-12)
    assert filter_.bias == bias
    assert filter_.sigma[3:] == sigma[3:]


# Refusals ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 2.0 * LARGEST])
def test_what_is_no_reading_is_refused(axis: int, value: float) -> None:
    filter_ = aligned()
    filter_.step(STILL, LEVEL)
    before = filter_.memory
    readings = [*STILL, *LEVEL]
    readings[axis] = value
    with pytest.raises(ValueError, match="allowed"):
        filter_.step(readings[:3], readings[3:])
    assert np.array_equal(filter_.memory, before)


def test_bad_start_is_refused() -> None:
    filter_ = ImuAttitude()
    for axis in range(3):
        angles = [0.0, 0.0, 0.0]
        angles[axis] = math.nan
        with pytest.raises(ValueError, match="finite"):
            filter_.align(*angles)
    with pytest.raises(ValueError, match="steep"):
        filter_.align(0.0, STEEPEST, 0.0)
    assert not knows(filter_)


def test_too_steep_is_lost_and_may_start_anew() -> None:
    filter_ = aligned(attitude=(0.0, 75.0 * DEG, 0.0))
    steps = 0
    while knows(filter_):
        filter_.step((0.0, 1.0, 0.0), resting((0.0, 75.0 * DEG, 0.0)))
        steps += 1
        assert steps < 100
    assert filter_.lost == 1
    assert filter_.sigma[0] == math.sqrt(UNKNOWN_VARIANCE)
    assert np.isfinite(filter_.memory).all()
    filter_.align(0.0, 0.0, 0.0)
    for _ in range(100):
        filter_.step(STILL, LEVEL)
    assert knows(filter_)
    assert filter_.lost == 1


# Against numerical twins -------------------------------------------------------------------------------

steep = st.floats(-1.2, 1.2)
turning = st.floats(-5.0, 5.0)


@given(steep, st.floats(-3.0, 3.0), turning, turning, turning)
def test_euler_rates_against_the_inverse_relation(
    theta: float, phi: float, p: float, q: float, r: float
) -> None:
    """Source eq. A.11, which gives body rates from Euler rates."""
    psi_rate, theta_rate, phi_rate = euler_rates(theta, phi, p, q, r)
    s, c = math.sin(phi), math.cos(phi)
    back = np.array(
        [
            [1.0, 0.0, -math.sin(theta)],
            [0.0, c, s * math.cos(theta)],
            [0.0, -s, c * math.cos(theta)],
        ]
    ) @ [phi_rate, theta_rate, psi_rate]
    assert back == pytest.approx([p, q, r], abs=1e-11)


def covariance_of(seed: int) -> Array:
    """Some (9, 9) covariance of a likely size."""
    draw = np.random.default_rng(seed)
    root = draw.standard_normal((ROWS, ROWS)) * np.repeat([0.02, 0.01, 0.05], 3)[:, None]
    covariance: Array = root @ root.T
    return covariance


def memory_of(angles: Sequence[float], covariance: Array) -> Array:
    memory = np.zeros(AttitudeMemory.end)
    memory[:3] = angles
    memory[AttitudeMemory.covariance :] = covariance.ravel()
    return memory


@settings(deadline=None)
@given(steep, st.floats(-3.0, 3.0), turning, turning, turning, st.integers(0, 2**31))
def test_prediction_against_differenced_jacobian(
    theta: float, phi: float, p: float, q: float, r: float, seed: int
) -> None:
    """P' = F P F' + Q with F from differencing the step itself; what is left is of second order in 2.5 ms."""
    covariance = covariance_of(seed)

    def moved(change: Array) -> Array:
        memory = memory_of((0.3 + change[0], theta + change[1], phi + change[2]), covariance)
        predict(memory, p - change[3], q - change[4], r - change[5], 1.0, C)
        return memory[:3].copy()

    jacobian, step = np.eye(ROWS), 1e-5
    for column in range(6):
        change = np.zeros(6)
        change[column] = step
        jacobian[:3, column] = (moved(change) - moved(-change)) / (2.0 * step)
    upright, slope = 1.0 / math.cos(theta), math.tan(theta)
    noise = np.zeros((ROWS, ROWS))
    noise[:3, :3] = [
        [upright**2, 0.0, slope * upright],
        [0.0, 1.0, 0.0],
        [slope * upright, 0.0, 1.0 + slope**2],
    ]
    memory = memory_of((0.3, theta, phi), covariance)
    predict(memory, p, q, r, 1.0, C)
    found = memory[AttitudeMemory.covariance :].reshape(ROWS, ROWS)
    expected = jacobian @ covariance @ jacobian.T + C.turn_variance * noise
    # second order: rates up to 5 rad/s times 2.5 ms, 1 / cos up to 2.8; its order is tested below
    scale = np.abs(covariance).max() * upright**4
    assert np.abs(found - expected).max() < 2e-3 * scale
    assert np.array_equal(found, found.T)
    assert found[3:, 3:] == pytest.approx(covariance[3:, 3:], rel=1e-12)


@given(steep, st.floats(-3.0, 3.0))
def test_noise_of_the_gyros_turns_every_angle(theta: float, phi: float) -> None:
    """Q = N^2 T E E' with E the Euler rates of unit body rates."""
    turns = np.array(
        [euler_rates(theta, phi, *row) for row in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    )
    for seen, variance in ((1.0, C.turn_variance), (0.0, C.blind_variance)):
        memory = memory_of((0.0, theta, phi), np.zeros((ROWS, ROWS)))
        predict(memory, 0.0, 0.0, 0.0, seen, C)
        found = memory[AttitudeMemory.covariance :].reshape(ROWS, ROWS)
        assert found[:3, :3] / variance == pytest.approx(turns.T @ turns, rel=1e-9, abs=1e-9)
        assert not found[3:].any()


def test_prediction_is_first_order_exact() -> None:
    """The difference from the differenced Jacobian falls with the square of the period."""
    covariance = covariance_of(3)
    p, q, r = 0.8, -1.1, 0.9
    differences = []
    for period in (0.02, 0.01, 0.005):
        c = packed(imu_attitude_constants(STANDARD)._replace(period=period, turn_variance=0.0))
        jacobian, step = np.eye(ROWS), 1e-5
        for column in range(6):
            ends = []
            for sign in (1.0, -1.0):
                change = np.zeros(6)
                change[column] = sign * step
                memory = memory_of((0.3 + change[0], 0.5 + change[1], -0.4 + change[2]), covariance)
                predict(memory, p - change[3], q - change[4], r - change[5], 1.0, c)
                ends.append(memory[:3].copy())
            jacobian[:3, column] = (ends[0] - ends[1]) / (2.0 * step)
        memory = memory_of((0.3, 0.5, -0.4), covariance)
        predict(memory, p, q, r, 1.0, c)
        found = memory[AttitudeMemory.covariance :].reshape(ROWS, ROWS)
        differences.append(float(np.abs(found - jacobian @ covariance @ jacobian.T).max()))
    assert differences[0] / differences[1] == pytest.approx(4.0, rel=0.1)
    assert differences[1] / differences[2] == pytest.approx(4.0, rel=0.1)


@settings(deadline=None)
@given(steep, st.floats(-3.0, 3.0), st.integers(0, 2**31))
def test_correction_against_the_textbook(theta: float, phi: float, seed: int) -> None:
    """All three accelerometers at once, Joseph form, H differenced from -C_nb' g."""
    draw, covariance = np.random.default_rng(seed), covariance_of(seed)

    def expected_force(angles: Array) -> Array:
        force: Array = np.asarray(matrix_from_euler(Euler(*angles))).T @ [0.0, 0.0, -G]
        return force

    angles, step = np.array([0.3, theta, phi]), 1e-6
    derivative = np.zeros((3, ROWS))
    derivative[:, 6:] = np.eye(3)
    for column in range(3):
        change = np.zeros(3)
        change[column] = step
        derivative[:, column] = (expected_force(angles + change) - expected_force(angles - change)) / (
            2 * step
        )
    force = expected_force(angles) + draw.standard_normal(3)
    memory = memory_of(angles.tolist(), covariance)
    correct(memory, force[0], force[1], force[2], C)
    velocity = memory[AttitudeMemory.velocity : AttitudeMemory.agitated]
    doubt = C.velocity_variance + C.tilt_velocity * (covariance[1, 1] + covariance[2, 2])
    noise = C.force_variance * (1.0 + float(velocity @ velocity) / doubt) * np.eye(3)
    gain = covariance @ derivative.T @ np.linalg.inv(derivative @ covariance @ derivative.T + noise)
    rest = np.eye(ROWS) - gain @ derivative
    state = np.array([*angles, *np.zeros(6)]) + gain @ (force - expected_force(angles))
    after = rest @ covariance @ rest.T + gain @ noise @ gain.T
    assert memory[:ROWS] == pytest.approx(state, abs=1e-8)
    found = memory[AttitudeMemory.covariance :].reshape(ROWS, ROWS)
    assert found == pytest.approx(after, abs=1e-9)


def test_swinging_is_followed_exactly() -> None:
    """Large slow swings, perfect gyros: what is left after 20 s is the trapezoidal rule's error."""
    p = replace(STANDARD, velocity_spread=10.0, gyro_walk=0.0, gyro_bias=1e-5)
    time, motion = times(20.0), Motion(1, angle=(2.0, 0.6, 0.9))
    estimate, _ = run(motion.readings(time), Euler(*motion.angles(time[:1])[0]), p)
    assert np.abs(estimate[:, :3] - motion.angles(time[1:])).max() < 1e-4


def test_lever_arm_is_taken_off() -> None:
    """Turned about its centre of gravity, an IMU 0.5 m off feels what the filter must not take for a tilt."""
    time = times(20.0)
    p = replace(
        STANDARD, imu_x=0.5, imu_y=0.2, imu_z=-0.3, gyro_bias=1e-5, gyro_walk=1e-3, velocity_spread=0.02
    )
    motion = Motion(2, angle=(1.0, 0.4, 0.4), distance=0.0, place=(0.5, 0.2, -0.3))
    start, readings = Euler(*motion.angles(time[:1])[0]), motion.readings(time)
    truth = motion.angles(time[1:])
    told, _ = run(readings, start, p)
    untold, _ = run(readings, start, replace(p, imu_x=0.0, imu_y=0.0, imu_z=0.0))
    error, without = (np.abs(e[:, 1:3] - truth[:, 1:]).max() for e in (told, untold))
    assert error < 0.2 * without


# Standstill --------------------------------------------------------------------------------------------


def standing(seconds: float, seed: int) -> tuple[Array, Array]:
    perfect = np.zeros((len(times(seconds)), 6))
    perfect[:, 5] = -G
    return noisy(perfect, seed)


@pytest.mark.parametrize("known", [True, False])
def test_biases_are_found_at_a_standstill(known: bool) -> None:
    """That of yaw too: 4 s of 0.02 deg/s/sqrt(Hz) leave 0.01 deg/s, and creep 0.005 deg/s more."""
    square = np.zeros(3)
    for seed in range(12):
        readings, bias = standing(4.05, seed)
        filter_ = aligned() if known else ImuAttitude()
        follow(filter_._memory, readings, filter_._box, np.empty((len(readings), 12)))
        assert filter_.standstills == 8
        assert max(filter_.sigma[3:]) < 0.03 * DEG
        square += ((np.array(filter_.bias) - bias[-1]) / filter_.sigma[3:]) ** 2
    assert square.max() < chi2.isf(RARE, 12)


def test_motion_is_no_standstill() -> None:
    readings, _ = standing(5.0, 1)
    turn = 163.363 * PERIOD * np.arange(len(readings))
    cases = {}
    cases["a turn"] = readings + [0.0, 0.0, 3.0 * DEG, 0.0, 0.0, 0.0]
    cases["swinging"] = readings + 1.0 * DEG * np.sin(0.05 * turn)[:, None] * [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    cases["vibration"] = readings + 0.2 * np.cos(turn)[:, None] * [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]
    for name, shaken in cases.items():
        filter_ = aligned()
        follow(filter_._memory, shaken, filter_._box, np.empty((len(shaken), 12)))
        assert filter_.standstills == 0, name
    never = aligned(replace(STANDARD, still_margin=0.0))
    follow(never._memory, readings, never._box, np.empty((len(readings), 12)))
    assert never.standstills == 0


def test_a_gap_begins_a_new_window() -> None:
    filter_ = ImuAttitude()
    for _ in range(STILL_SAMPLES - 1):
        filter_.step(STILL, LEVEL)
    filter_.step(STILL, LEVEL, valid=False)
    for _ in range(STILL_SAMPLES - 1):
        filter_.step(STILL, LEVEL)
    assert filter_.standstills == 0
    filter_.step(STILL, LEVEL)
    assert filter_.standstills == 1


# In motion ---------------------------------------------------------------------------------------------


def test_errors_are_those_it_predicts() -> None:
    """Errors over predicted sigmas in 24 flights of 40 s after 3 s on the ground; roll, pitch below 1 deg.

    Yaw and its bias must be neither better nor worse than predicted. Acceleration is no white noise, so that
    of pitch and roll and their biases only too large errors count.
    """
    flights, time = 24, times(43.0)
    scores, tilt = np.zeros(6), []
    for seed in range(flights):
        motion = Motion(seed, rest=3.0)
        readings, bias = noisy(motion.readings(time), 100 + seed)
        start = STANDARD.alignment * np.random.default_rng(200 + seed).standard_normal(3)
        estimate, sigma = run(readings, Euler(*start))
        error = estimate - np.hstack([motion.angles(time), bias])[1:]
        scores += (error[-1] / sigma[-1]) ** 2
        tilt.append(np.sqrt((error[1200:, 1:3] ** 2).mean(axis=0)))
    low, high = chi2.isf(1.0 - RARE, flights), chi2.isf(RARE, flights)
    assert low < scores[0] < high
    assert low < scores[5] < high
    assert scores.max() < high
    assert np.max(tilt) < 1.0 * DEG


def test_tilt_biases_are_found_in_flight_and_that_of_yaw_is_not() -> None:
    time, motion = times(60.0), Motion(4)
    readings, bias = noisy(motion.readings(time), 5)
    readings[:, :3] += np.array([1.0, -1.0, 1.0]) * DEG
    p = replace(STANDARD, gyro_bias=1.0 * DEG)
    estimate, sigma = run(readings, Euler(0.0, 0.0, 0.0), p)
    error = estimate[-1, 3:] - bias[-1] - np.array([1.0, -1.0, 1.0]) * DEG
    assert np.abs(error[:2]).max() < 0.15 * DEG
    assert sigma[-1, 3:5].max() < 0.1 * DEG
    assert sigma[-1, 5] > 0.3 * DEG


def test_bias_that_jumps_is_found_again() -> None:
    """2 deg/s more on the pitch gyro; without setting the biases free the tilt would be wrong far longer."""
    time, motion = times(60.0), Motion(6, rest=3.0)
    readings, _ = noisy(motion.readings(time), 7)
    jump = round(30.0 / PERIOD)
    readings[jump:, 1] += 2.0 * DEG
    errors = []
    for p in (STANDARD, replace(STANDARD, jump_walk=0.0)):
        estimate, _ = run(readings, Euler(0.0, 0.0, 0.0), p)
        errors.append(np.abs(estimate[:, 1] - motion.angles(time[1:])[:, 1]))
    later = round(42.0 / PERIOD)
    assert errors[0][jump:].max() > 3.0 * DEG
    assert errors[0][later:].max() < 1.5 * DEG
    assert errors[1][later:].max() > 3.0 * DEG


def test_agitation_makes_accelerometers_count_less() -> None:
    """A velocity at its spread counts half, any larger one a quarter."""
    covariance = np.zeros((ROWS, ROWS))
    covariance[1, 1] = 1e-6
    doubt = C.velocity_variance + C.tilt_velocity * 1e-6
    moved = []
    for velocity in (0.0, math.sqrt(doubt), 100.0):
        memory = memory_of(STILL, covariance)
        memory[AttitudeMemory.velocity + 1] = velocity / C.velocity_kept
        correct(memory, 1e-3, 0.0, -G, C)
        moved.append(memory[AttitudeMemory.theta])
    assert moved[0] / moved[1] == pytest.approx(2.0, rel=1e-3)
    assert moved[0] / moved[2] == pytest.approx(4.0, rel=1e-3)


@settings(deadline=None, max_examples=60)
@given(
    st.lists(
        st.tuples(
            st.integers(1, 300),
            st.booleans(),
            st.tuples(*[st.floats(-5.0, 5.0)] * 3),
            st.tuples(*[st.floats(-50.0, 50.0)] * 3),
        ),
        min_size=1,
        max_size=8,
    ),
    steep,
    st.floats(-3.1, 3.1),
)
def test_covariance_stays_positive(
    stretches: list[tuple[int, bool, tuple[float, ...], tuple[float, ...]]], theta: float, phi: float
) -> None:
    filter_ = aligned(attitude=(0.0, theta, phi))
    for count, valid, gyro, force in stretches:
        for _ in range(count):
            filter_.step(gyro, force, valid)
        covariance = filter_.covariance
        assert np.isfinite(filter_.memory).all()
        assert np.array_equal(covariance, covariance.T)
        first = 0 if filter_.known else 3
        deviation = np.sqrt(np.diag(covariance)[first:])
        correlation = covariance[first:, first:] / np.outer(deviation, deviation)
        assert np.linalg.eigvalsh(correlation).min() > -1e-9
        assert abs(filter_.attitude.theta) < STEEPEST
        assert max(abs(filter_.attitude.psi), abs(filter_.attitude.phi)) <= math.pi


def test_memory_is_a_copy_and_whole() -> None:
    """Two filters of one memory go the same way."""
    one, other = aligned(), aligned()
    readings, _ = noisy(Motion(8).readings(times(1.0)), 9)
    follow(one._memory, readings, one._box, np.empty((len(readings), 12)))
    one.memory[:] = 0.0
    other._memory[:] = one.memory
    constants = boxed(C)
    for filter_, box in ((one, one._box), (other, constants)):
        follow(filter_._memory, readings, box, np.empty((len(readings), 12)))
    assert np.array_equal(one.memory, other.memory)


def test_message_is_what_the_filter_knows() -> None:
    filter_ = ImuAttitude()
    filter_.step(STILL, LEVEL)
    assert filter_.message[4:13].reshape(3, 3).tolist() == (UNKNOWN_VARIANCE * np.eye(3)).tolist()
    filter_.align(0.3, 0.1, -0.2)
    filter_.step((0.1, 0.2, 0.3), LEVEL)
    said, bias, sigma = filter_.message, filter_.bias, filter_.sigma
    assert attitude_ned(Quaternion(*said[:4].tolist())) == pytest.approx(filter_.attitude)
    assert said[13:16] == pytest.approx((0.1 - bias[0], bias[1] - 0.2, bias[2] - 0.3))
    assert said[[4, 8, 12, 16]] == pytest.approx(np.square([sigma[1], sigma[2], sigma[0], sigma[3]]))
    filter_.step(STILL, LEVEL, valid=False)
    assert not filter_.message[13:16].any()
