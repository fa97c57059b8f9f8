"""IMU: lever arms by hand and by differencing, noise against its densities, vibration, range, steps."""

import math
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import chi2

from heli_bench_sim.imu import (
    IMU_NORMALS,
    IMU_SIZE,
    Imu,
    ImuAxis,
    ImuReading,
    ImuTruth,
    imu_sample,
    imu_truth,
    quantised,
)
from heli_bench_sim.imu_parameters import ImuConstants, ImuParameters, imu_constants, initial_bias
from heli_bench_sim.random_streams import generator
from heli_bench_sim.states import STATE_SIZE, State
from heli_common.compiled import compiled
from heli_common.records import packed

Array = NDArray[np.float64]

G, OMEGA_0, PERIOD = 9.81, 163.363, 0.0025
DEG = math.radians(1.0)
STANDARD = ImuParameters()
C = packed(imu_constants(STANDARD, G, OMEGA_0))
PERFECT = replace(
    STANDARD,
    gyro_noise=0.0,
    gyro_bias=0.0,
    gyro_walk=0.0,
    accelerometer_noise=0.0,
    accelerometer_bias=0.0,
    vibration_once=0.0,
    vibration_twice=0.0,
    bits=32.0,
)
RARE = 1e-5
"""Chance that a right model fails one chi-square test; the seeds are fixed all the same."""


def made(parameters: ImuParameters) -> ImuConstants:
    return packed(imu_constants(parameters, G, OMEGA_0))


def truth(values: dict[State, float], rates: dict[State, float] | None = None, c: ImuConstants = C) -> Array:
    state, rate, out = np.zeros(STATE_SIZE), np.zeros(STATE_SIZE), np.full(IMU_SIZE, np.nan)
    for name, value in values.items():
        state[name] = value
    for name, value in (rates or {}).items():
        rate[name] = value
    imu_truth(state, rate, c, out)
    return out


def reading(
    values: dict[State, float], azimuth: float = 0.0, c: ImuConstants = C, bias: Array | None = None
) -> Array:
    state, out = np.zeros(STATE_SIZE), np.full(IMU_SIZE, np.nan)
    for name, value in values.items():
        state[name] = value
    used = np.zeros(IMU_SIZE) if bias is None else bias
    imu_sample(state, np.zeros(STATE_SIZE), azimuth, used, np.zeros(IMU_NORMALS), c, out)
    return out


@compiled
def record(
    state: Array, rate: Array, speed: float, bias: Array, normals: Array, c: ImuConstants, out: Array
) -> None:
    """Readings and the biases they were made with, one row per sample, the rotor turning evenly."""
    for k in range(normals.shape[0]):
        for axis in range(6):
            out[k, 6 + axis] = bias[axis]
        imu_sample(state, rate, speed * k * 0.0025, bias, normals[k], c, out[k])


def standing(c: ImuConstants, samples: int, seed: int = 1, speed: float = 0.0) -> Array:
    """(samples, 12) readings and biases of the IMU at rest and level."""
    state, out = np.zeros(STATE_SIZE), np.empty((samples, 2 * IMU_SIZE))
    state[State.Omega] = speed
    normals = generator(seed, "imu").standard_normal((samples, IMU_NORMALS))
    record(state, np.zeros(STATE_SIZE), speed, np.zeros(IMU_SIZE), normals, c, out)
    return out


# Truth -------------------------------------------------------------------------------------------------


def test_constants_by_hand() -> None:
    """0.02 deg/s/sqrt(Hz) * sqrt(400 Hz), 0.01 deg/s/sqrt(s) * sqrt(2.5 ms), 600 deg/s and 10 g over 4096."""
    c = imu_constants(STANDARD, G, OMEGA_0)
    assert (c.x, c.y, c.z) == (0.10, 0.0, -0.05)
    assert c.gyro_sigma == pytest.approx(0.4 * DEG, rel=1e-14)
    assert c.gyro_walk_sigma == pytest.approx(0.0005 * DEG, rel=1e-14)
    assert c.accelerometer_sigma == pytest.approx(0.06, rel=1e-14)
    assert c.gyro_step == pytest.approx(600.0 * DEG / 4096.0, rel=1e-14)
    assert c.accelerometer_step == pytest.approx(98.0665 / 4096.0, rel=1e-14)
    assert c.top_code == 2047.0


def test_bad_constants_are_refused() -> None:
    with pytest.raises(ValueError, match=r"bits 11\.5"):
        imu_constants(replace(STANDARD, bits=11.5), G, OMEGA_0)
    for speed in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match="rotor_speed"):
            imu_constants(STANDARD, G, speed)


def test_at_rest_by_hand() -> None:
    assert truth({}).tolist() == [0.0, 0.0, 0.0, 0.0, 0.0, -G]
    assert truth({State.theta: 0.5 * math.pi}) == pytest.approx([0.0, 0.0, 0.0, G, 0.0, 0.0], abs=1e-14)
    assert truth({State.phi: 0.5 * math.pi}) == pytest.approx([0.0, 0.0, 0.0, 0.0, -G, 0.0], abs=1e-14)
    assert truth({State.psi: 1.0, State.x: 3.0, State.z: -2.0}).tolist() == [0.0, 0.0, 0.0, 0.0, 0.0, -G]


@pytest.mark.parametrize(
    ("values", "rates", "expected"),
    [
        ({State.r: 2.0}, {}, [0.0, 0.0, 2.0, -0.1 * 4.0, 0.0, -G]),
        ({State.q: 2.0}, {}, [0.0, 2.0, 0.0, -0.1 * 4.0, 0.0, -G + 0.05 * 4.0]),
        ({State.p: 2.0}, {}, [2.0, 0.0, 0.0, 0.0, 0.0, -G + 0.05 * 4.0]),
        ({State.p: 2.0, State.q: 1.0}, {}, [2.0, 1.0, 0.0, -0.1, 0.2, -G + 0.25]),
        ({}, {State.r: 3.0}, [0.0, 0.0, 0.0, 0.0, 0.1 * 3.0, -G]),
        ({}, {State.q: 5.0}, [0.0, 0.0, 0.0, -0.05 * 5.0, 0.0, -G - 0.1 * 5.0]),
        ({}, {State.p: 4.0}, [0.0, 0.0, 0.0, 0.0, 0.05 * 4.0, -G]),
        ({}, {State.u: 1.0, State.v: 2.0, State.w: 3.0}, [0.0, 0.0, 0.0, 1.0, 2.0, 3.0 - G]),
        ({}, {State.w: G}, [0.0] * 6),
    ],
)
def test_lever_arm_by_hand(
    values: dict[State, float], rates: dict[State, float], expected: list[float]
) -> None:
    assert truth(values, rates) == pytest.approx(expected, abs=1e-14)


def test_flat_turn_by_hand() -> None:
    """3 m/s forward at 1 rad/s to the right: 3 m/s^2 to the right at the centre of gravity."""
    centre = made(replace(STANDARD, x=0.0, z=0.0))
    assert truth({State.u: 3.0, State.r: 1.0}, c=centre).tolist() == [0.0, 0.0, 1.0, 0.0, 3.0, -G]
    assert truth({State.v: 3.0, State.r: 1.0}, c=centre).tolist() == [0.0, 0.0, 1.0, -3.0, 0.0, -G]
    assert truth({State.u: 3.0, State.q: 1.0}, c=centre).tolist() == [0.0, 1.0, 0.0, 0.0, 0.0, -G - 3.0]


def place(t: float) -> Array:
    """A smooth path, NED [m]."""
    return np.array([0.4 * math.sin(1.3 * t), 0.3 * math.cos(2.1 * t + 0.4), 0.2 * math.sin(1.7 * t - 0.3)])


def attitude(t: float) -> Array:
    """Body to earth along it."""
    psi, theta, phi = 0.8 * math.sin(1.1 * t), 0.4 * math.cos(2.3 * t), 0.5 * math.sin(1.9 * t + 1.0)
    cz, sz, cy, sy, cx, sx = (f(a) for a in (psi, theta, phi) for f in (math.cos, math.sin))
    yaw = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    pitch = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    roll = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    return np.asarray(yaw @ pitch @ roll)


H = 2e-3


def slope(path: Callable[[float], Array], t: float) -> Array:
    """First derivative, central differences of fourth order."""
    near, far = path(t + H) - path(t - H), path(t + 2.0 * H) - path(t - 2.0 * H)
    return (8.0 * near - far) / (12.0 * H)


def bend(path: Callable[[float], Array], t: float) -> Array:
    """Second derivative, central differences of fourth order."""
    near, far = path(t + H) + path(t - H), path(t + 2.0 * H) + path(t - 2.0 * H)
    return (16.0 * near - far - 30.0 * path(t)) / (12.0 * H * H)


def body_velocity(t: float) -> Array:
    return np.asarray(attitude(t).T @ slope(place, t))


def body_rates(t: float) -> Array:
    skew = attitude(t).T @ slope(attitude, t)
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


@settings(deadline=None, max_examples=40)
@given(
    st.floats(0.0, 6.0),
    st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)),
)
def test_specific_force_is_the_differenced_path_of_the_imu(
    t: float, lever: tuple[float, float, float]
) -> None:
    c = made(replace(STANDARD, x=lever[0], y=lever[1], z=lever[2]))
    turn = attitude(t)
    psi, theta = math.atan2(turn[1, 0], turn[0, 0]), -math.asin(turn[2, 0])
    state = dict(zip((State.u, State.v, State.w), body_velocity(t).tolist(), strict=True))
    state |= dict(zip((State.p, State.q, State.r), body_rates(t).tolist(), strict=True))
    state |= {State.psi: psi, State.theta: theta, State.phi: math.atan2(turn[2, 1], turn[2, 2])}
    rate = dict(zip((State.u, State.v, State.w), slope(body_velocity, t).tolist(), strict=True))
    rate |= dict(zip((State.p, State.q, State.r), slope(body_rates, t).tolist(), strict=True))
    found = truth(state, rate, c)

    acceleration = bend(lambda s: place(s) + attitude(s) @ np.array(lever), t)
    assert found[3:] == pytest.approx(turn.T @ (acceleration - [0.0, 0.0, G]), abs=1e-7)
    assert found[:3] == pytest.approx(body_rates(t), abs=0.0)


# Noise and bias ----------------------------------------------------------------------------------------

SAMPLES = 2**16
NOISY = made(
    replace(PERFECT, gyro_noise=STANDARD.gyro_noise, accelerometer_noise=STANDARD.accelerometer_noise)
)
DENSITY = [0.02 * DEG] * 3 + [0.003] * 3


@pytest.fixture(scope="module")
def noise() -> Array:
    """(n, 6) white noise of an IMU at rest that has no other fault."""
    return standing(NOISY, SAMPLES)[:, :IMU_SIZE] - [0.0, 0.0, 0.0, 0.0, 0.0, -G]


def inside(squares: float, freedom: int) -> bool:
    low, high = chi2.ppf([RARE / 2.0, 1.0 - RARE / 2.0], freedom)
    return bool(low < squares < high)


@pytest.mark.parametrize("axis", list(ImuAxis))
def test_allan_deviation_of_white_noise(noise: Array, axis: ImuAxis) -> None:
    """Density over root of tau; separate pairs of clusters are independent, so chi-square is exact."""
    for length in (1, 4, 16, 64, 256, 1024):
        tau = length * PERIOD
        means = noise[:, axis].reshape(-1, length).mean(axis=1)
        pairs = 0.5 * np.diff(means.reshape(-1, 2)) ** 2
        assert inside(float(np.sum(pairs)) / (DENSITY[axis] ** 2 / tau), len(pairs))


@pytest.mark.parametrize("axis", list(ImuAxis))
def test_spectrum_of_white_noise(noise: Array, axis: ImuAxis) -> None:
    """One-sided 2 N^2 in every band: two degrees of freedom per frequency."""
    power = 2.0 * PERIOD / SAMPLES * np.abs(np.fft.rfft(noise[:, axis])) ** 2
    frequency = np.fft.rfftfreq(SAMPLES, PERIOD)
    for low, high in ((0.01, 1.0), (1.0, 10.0), (10.0, 50.0), (50.0, 120.0), (120.0, 199.9)):
        band = (frequency >= low) & (frequency < high)
        ratio = power[band] / (2.0 * DENSITY[axis] ** 2)
        assert inside(2.0 * float(np.sum(ratio)), 2 * int(np.count_nonzero(band)))


def test_axes_are_uncorrelated(noise: Array) -> None:
    cross = np.corrcoef(noise.T)[np.triu_indices(IMU_SIZE, 1)]
    assert np.abs(cross).max() < 5.0 / math.sqrt(SAMPLES)


def test_whole_imu_at_rest() -> None:
    """White noise and quantisation together: sigma^2 + step^2 / 12."""
    c = made(replace(STANDARD, gyro_walk=0.0))
    found = standing(c, SAMPLES)[:, :IMU_SIZE]
    for axis, step in zip(ImuAxis, [C.gyro_step] * 3 + [C.accelerometer_step] * 3, strict=True):
        variance = DENSITY[axis] ** 2 / PERIOD + step**2 / 12.0
        mean = -G if axis is ImuAxis.accelerometer_z else 0.0
        assert inside(float(np.sum((found[:, axis] - mean) ** 2)) / variance, SAMPLES)


def test_bias_of_gyros_walks_and_that_of_accelerometers_stays() -> None:
    """Separate windows of n samples: independent differences of variance K^2 n dt."""
    bias = standing(C, SAMPLES)[:, IMU_SIZE:]
    for axis in range(3):
        for length in (1, 16, 256, 2048):
            grown = np.diff(bias[::length, axis])
            variance = (0.01 * DEG) ** 2 * length * PERIOD
            assert inside(float(np.sum(grown**2)) / variance, len(grown))
    assert not bias[:, 3:].any()


def test_bias_of_this_sample_is_read_and_then_walks() -> None:
    c = made(replace(PERFECT, gyro_walk=STANDARD.gyro_walk))
    bias = np.array([0.01, -0.02, 0.03, 0.1, -0.2, 0.3])
    before, out = bias.copy(), np.empty(IMU_SIZE)
    normals = np.array([0.0] * 6 + [1.0, -2.0, 3.0])
    imu_sample(np.zeros(STATE_SIZE), np.zeros(STATE_SIZE), 0.0, bias, normals, c, out)
    assert out == pytest.approx(before + [0.0, 0.0, 0.0, 0.0, 0.0, -G], abs=1e-7)
    assert bias[:3] - before[:3] == pytest.approx(0.0005 * DEG * normals[6:], rel=1e-9)
    assert bias[3:].tolist() == before[3:].tolist()


def test_every_number_goes_to_its_own_axis() -> None:
    for axis in ImuAxis:
        normals, out = np.zeros(IMU_NORMALS), np.empty(IMU_SIZE)
        normals[axis] = 2.0
        imu_sample(np.zeros(STATE_SIZE), np.zeros(STATE_SIZE), 0.0, np.zeros(IMU_SIZE), normals, NOISY, out)
        expected = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -G])
        expected[axis] += 2.0 * (0.4 * DEG if axis < 3 else 0.06)
        assert out == pytest.approx(expected, abs=1e-7)


def test_bias_at_power_up() -> None:
    """Drawn per axis with the size of the specification; the seed decides."""
    numbers = generator(1, "imu_bias")
    drawn = np.array([initial_bias(STANDARD, numbers) for _ in range(2000)])
    for axes, size in ((slice(0, 3), 0.5 * DEG), (slice(3, 6), 0.05)):
        assert inside(float(np.sum(drawn[:, axes] ** 2)) / size**2, 6000)
    assert np.abs(np.corrcoef(drawn.T)[np.triu_indices(6, 1)]).max() < 5.0 / math.sqrt(2000)
    again = initial_bias(STANDARD, generator(1, "imu_bias"))
    assert again.tolist() == drawn[0].tolist()
    assert not np.isin(initial_bias(STANDARD, generator(2, "imu_bias")), again).any()
    assert not initial_bias(PERFECT, generator(1, "imu_bias")).any()


def test_same_numbers_same_readings() -> None:
    first, second = standing(C, 2000), standing(C, 2000)
    assert first.tobytes() == second.tobytes()
    assert standing(C, 2000, seed=2).tobytes() != first.tobytes()
    assert standing(imu_constants(STANDARD, G, OMEGA_0), 2000).tobytes() == first.tobytes()


# Vibration ---------------------------------------------------------------------------------------------

SHAKEN = made(
    replace(PERFECT, vibration_once=STANDARD.vibration_once, vibration_twice=STANDARD.vibration_twice)
)


def test_vibration_by_hand() -> None:
    """Ahead at azimuth 0, left a quarter turn later; the vertical one goes through two periods."""
    for azimuth, expected in (
        (0.0, [0.5, 0.0, 0.8 - G]),
        (0.5 * math.pi, [0.0, -0.5, -0.8 - G]),
        (math.pi, [-0.5, 0.0, 0.8 - G]),
        (0.25 * math.pi, [math.sqrt(0.125), -math.sqrt(0.125), -G]),
    ):
        found = reading({State.Omega: OMEGA_0}, azimuth, SHAKEN)
        assert found[3:] == pytest.approx(expected, abs=1e-7)
        assert found[:3].tolist() == [0.0, 0.0, 0.0]
    assert reading({State.Omega: 0.5 * OMEGA_0}, 0.0, SHAKEN)[3:] == pytest.approx(
        [0.125, 0.0, 0.2 - G], abs=1e-7
    )
    assert reading({}, 0.3, SHAKEN)[3:] == pytest.approx([0.0, 0.0, -G], abs=1e-7)


@pytest.mark.parametrize("turns", [26, 13])
def test_lines_of_vibration(turns: int) -> None:
    """One second of whole turns: each line stands in one bin and nowhere else."""
    found = standing(SHAKEN, 400, speed=2.0 * math.pi * turns)[:, 3:IMU_SIZE]
    lines = np.fft.rfft(found + [0.0, 0.0, G], axis=0) / 200.0
    share = (2.0 * math.pi * turns / OMEGA_0) ** 2
    expected = np.zeros_like(lines)
    expected[turns] = [0.5 * share, 0.5j * share, 0.0]
    expected[2 * turns, 2] = 0.8 * share
    assert np.abs(lines - expected).max() < 1e-7


def test_lines_stand_out_of_the_whole_imu() -> None:
    """The standard IMU: amplitudes within five standard deviations, sqrt(2 / n) times that of a sample."""
    samples, speed = 4000, 2.0 * math.pi * 26.0
    found = standing(C, samples, speed=speed)[:, 3:IMU_SIZE]
    lines = 2.0 / samples * np.abs(np.fft.rfft(found, axis=0))
    sigma = math.sqrt(2.0 / samples * (0.06**2 + C.accelerometer_step**2 / 12.0))
    for axis, line, amplitude in ((0, 260, 0.5), (1, 260, 0.5), (2, 520, 0.8)):
        assert abs(lines[line, axis] - amplitude * (speed / OMEGA_0) ** 2) < 5.0 * sigma
        assert np.argmax(lines[1:, axis]) + 1 == line


# Range and quantisation --------------------------------------------------------------------------------


def test_saturation() -> None:
    fast = reading({State.p: 400.0 * DEG, State.q: -400.0 * DEG, State.r: 299.0 * DEG})
    step = 600.0 / 4096.0
    assert fast[:3] / DEG == pytest.approx([300.0 - step, -300.0, round(299.0 / step) * step], rel=1e-12)
    bias = np.array([0.0, 0.0, 0.0, 60.0, -60.0, 45.0])
    half, step = 5.0 * 9.80665, 98.0665 / 4096.0
    assert reading({}, c=made(replace(PERFECT, bits=12.0)), bias=bias)[3:] == pytest.approx(
        [half - step, -half, round((45.0 - G) / step) * step], rel=1e-12
    )


def test_codes_by_hand() -> None:
    """Four codes over -1 .. 1."""
    for value, expected in (
        (0.0, 0.0),
        (0.24, 0.0),
        (0.25, 0.5),
        (-0.25, 0.0),
        (-0.26, -0.5),
        (0.9, 0.5),
        (7.0, 0.5),
        (-0.76, -1.0),
        (-7.0, -1.0),
    ):
        assert quantised(value, 1.0, 0.5, 1.0) == expected


def test_no_number_is_made_of_a_nan() -> None:
    assert math.isnan(quantised(math.nan, 1.0, 0.5, 1.0))
    assert math.isnan(reading({State.p: math.nan})[ImuAxis.gyro_x])


@settings(deadline=None, max_examples=200)
@given(st.floats(-10.0, 10.0))
def test_quantisation_is_to_the_nearest_code(value: float) -> None:
    found = quantised(value, C.gyro_range, C.gyro_step, C.top_code)
    code = found / C.gyro_step
    assert code == pytest.approx(round(code), abs=1e-9)
    assert -2048 <= round(code) <= 2047
    assert quantised(found, C.gyro_range, C.gyro_step, C.top_code) == found
    if -C.gyro_range <= value <= C.gyro_range - C.gyro_step:
        assert abs(found - value) <= 0.5 * C.gyro_step * (1.0 + 1e-12)


def test_readings_are_whole_steps() -> None:
    found = standing(C, 4000, speed=OMEGA_0)[:, :IMU_SIZE] / ([C.gyro_step] * 3 + [C.accelerometer_step] * 3)
    assert found == pytest.approx(np.rint(found), abs=1e-9)
    assert all(len(np.unique(np.rint(found[:, axis]))) > 10 for axis in range(IMU_SIZE))


# An IMU of one's own -----------------------------------------------------------------------------------


def test_an_own_imu_fits_the_interface() -> None:
    class Swapped:
        """Mounted upside down."""

        def sample(self, truth: ImuTruth) -> ImuReading:
            (p, q, r), (x, y, z) = truth.rates, truth.specific_force
            return ImuReading((p, -q, -r), (x, -y, -z))

    own: Imu = Swapped()
    felt = ImuTruth((0.1, 0.2, 0.3), (0.0, 0.0, -G), 1.0, OMEGA_0, 2_500_000)
    assert own.sample(felt) == ImuReading((0.1, -0.2, -0.3), (0.0, 0.0, G))
    with pytest.raises(FrozenInstanceError):
        felt.stamp_ns = 0  # type: ignore[misc]
