"""Bias, noise and vibration of an IMU against encoders: by hand, within statistical bounds, across gaps."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2

from heli_common.compiled import compiled
from heli_common.rig_geometry import RADIAN_PER_COUNT
from heli_navigation.imu_attitude_parameters import ImuAttitudeConstants, ImuAttitudeParameters
from heli_navigation.imu_monitor import ImuFigures, ImuMonitor
from heli_navigation.imu_monitor_equations import (
    AXES,
    DIFFERENCE_GAIN,
    LONG_SAMPLES,
    SHORT_SAMPLES,
    monitor_step,
)

Array = NDArray[np.float64]

G, PERIOD, OMEGA_0 = 9.81, 0.0025, 163.363
DEG = math.radians(1.0)
STILL, LEVEL = (0.0, 0.0, 0.0), (0.0, 0.0, -G)
ZERO = (0.0,) * AXES
RARE = 1e-5
"""Chance that a right monitor fails one chi-square test; the seeds are fixed all the same."""


@compiled
def follow(memory: Array, rows: Array, box: Sequence[ImuAttitudeConstants]) -> None:
    for k in range(rows.shape[0]):
        r = rows[k]
        monitor_step(memory, r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8], True, box)


def measured(angles: Array, readings: Array, parameters: ImuAttitudeParameters | None = None) -> ImuFigures:
    """Figures of (n, 3) encoder angles and (n, 6) readings."""
    monitor = ImuMonitor(parameters)
    follow(monitor._memory, np.hstack([angles, readings]), monitor._box)
    return monitor.figures()


def at_rest(samples: int) -> tuple[Array, Array]:
    """Level angles, and what an ideal IMU reads."""
    readings = np.zeros((samples, AXES))
    readings[:, 5] = -G
    return np.zeros((samples, 3)), readings


def swinging(seconds: float, seed: int, place: Sequence[float] = (0.10, 0.0, -0.05)) -> tuple[Array, Array]:
    """Exact angles and readings of a helicopter that turns about its centre of gravity.

    The rates come from turning matrices, the accelerations from differencing the place of the IMU.
    """
    draw, time, step = (
        np.random.default_rng(seed),
        np.arange(round(seconds / PERIOD)) * np.float64(PERIOD),
        1e-4,
    )
    size, omega, phase = np.array([0.3, 0.05, 0.08]), draw.uniform(1.0, 6.0, 3), draw.uniform(0.0, 6.0, 3)

    def angles(moment: Array) -> Array:
        swing: Array = size * np.sin(omega * moment[:, None] + phase)
        return swing

    def matrices(moment: Array) -> Array:
        s, c = np.sin(angles(moment)).T, np.cos(angles(moment)).T
        return np.array(
            [
                [c[0] * c[1], c[0] * s[1] * s[2] - s[0] * c[2], c[0] * s[1] * c[2] + s[0] * s[2]],
                [s[0] * c[1], s[0] * s[1] * s[2] + c[0] * c[2], s[0] * s[1] * c[2] - c[0] * s[2]],
                [-s[1], c[1] * s[2], c[1] * c[2]],
            ]
        ).transpose(2, 0, 1)

    now, later, earlier = matrices(time), matrices(time + step), matrices(time - step)
    turning = np.einsum("kji,kjl->kil", now, (later - earlier) / (2.0 * step))
    rates = np.array([turning[:, 2, 1], turning[:, 0, 2], turning[:, 1, 0]]).T
    acceleration = (later - 2.0 * now + earlier) @ np.asarray(place) / step**2
    force = np.einsum("kji,kj->ki", now, acceleration - [0.0, 0.0, G])
    return angles(time), np.hstack([rates, force])


# By hand -----------------------------------------------------------------------------------------------


def test_nothing_measured_yet() -> None:
    figures = ImuMonitor().figures()
    assert figures.duration == 0.0
    for part in (figures.bias, figures.noise, figures.vibration, figures.allan_1_s, figures.allan_10_s):
        assert part == ZERO


def test_what_is_constant_is_bias() -> None:
    bias = np.array([0.01, -0.02, 0.03, 0.1, -0.2, 0.3])
    angles, readings = at_rest(10_001)
    # turned by 0.03 rad/s without the encoders seeing it, d = (0.1, 0, -0.05) is pulled inwards
    p, q, r = bias[:3]
    inwards = np.array(
        [
            p * (0.1 * p - 0.05 * r) - 0.1 * (p * p + q * q + r * r),
            q * (0.1 * p - 0.05 * r),
            r * (0.1 * p - 0.05 * r) + 0.05 * (p * p + q * q + r * r),
        ]
    )
    figures = measured(angles, readings + bias)
    assert figures.duration == pytest.approx(25.0, rel=1e-12)
    assert figures.bias[:3] == pytest.approx(bias[:3].tolist(), rel=1e-12)
    assert figures.bias[3:] == pytest.approx((bias[3:] - inwards).tolist(), rel=1e-9)
    for part in (figures.noise, figures.vibration, figures.allan_1_s, figures.allan_10_s):
        assert part == pytest.approx(ZERO, abs=1e-6)
    ends = math.sqrt(2.0 / 12.0) * RADIAN_PER_COUNT / 25.0, math.sqrt(2.0) * 0.1 / 25.0
    assert figures.bias_sigma == pytest.approx((*(ends[0],) * 3, *(ends[1],) * 3), rel=1e-3)


def test_allan_deviation_of_a_ramp_by_hand() -> None:
    """A reading that drifts by D per second: sigma(tau) = D tau / sqrt(2)."""
    angles, readings = at_rest(3 * LONG_SAMPLES + 1)
    drift = np.arange(len(readings)) * np.float64(PERIOD) * 1e-4
    readings[:, 3] += drift
    figures = measured(angles, readings)
    assert figures.allan_1_s[3] == pytest.approx(1e-4 / math.sqrt(2.0), rel=1e-9)
    assert figures.allan_10_s[3] == pytest.approx(1e-3 / math.sqrt(2.0), rel=1e-9)
    assert figures.allan_1_s[4] == 0.0


def test_six_differences_by_hand() -> None:
    """A single spike of 1 leaves 1, -6, 15, -20, 15, -6, 1: squares of sum 924."""
    assert DIFFERENCE_GAIN == 924
    angles, readings = at_rest(100)
    readings[50, 0] = 1.0
    figures = measured(angles, readings)
    assert figures.noise[0] == pytest.approx(math.sqrt(PERIOD / (100 - 6)), rel=1e-12)


def test_turn_through_south_is_no_jump() -> None:
    """Yaw from 170 deg through 180 to -170 deg, as the gyro has it."""
    samples = 401
    angles, readings = at_rest(samples)
    yaw = 170.0 * DEG + 20.0 * DEG * np.arange(samples) * PERIOD
    angles[:, 0] = np.where(yaw > math.pi, yaw - math.tau, yaw)
    readings[:, 2] = 20.0 * DEG + 0.001
    assert measured(angles, readings).bias[:3] == pytest.approx((0.0, 0.0, 0.001), abs=1e-9)
    assert measured(-angles, readings * [1, 1, -1, 1, 1, 1]).bias[2] == pytest.approx(-0.001, abs=1e-9)


def test_gap_is_not_bridged() -> None:
    """While nothing is measured the helicopter turns and tilts and a bias changes; no difference sees it."""
    monitor, bias = ImuMonitor(), (0.01, 0.0, 0.0)
    for _ in range(SHORT_SAMPLES + 21):
        monitor.step(STILL, STILL, LEVEL)
    for _ in range(3):
        monitor.step((math.nan,) * 3, (math.nan,) * 3, (math.inf,) * 3, valid=False)
    tilted = (1.0, 0.2, -0.1)
    force = (
        G * math.sin(0.2),
        G * math.cos(0.2) * math.sin(0.1),
        -G * math.cos(0.2) * math.cos(0.1),
    )
    for _ in range(SHORT_SAMPLES + 21):
        monitor.step(tilted, bias, force)
    figures = monitor.figures()
    assert figures.duration == pytest.approx(2 * (SHORT_SAMPLES + 20) * PERIOD, rel=1e-12)
    assert figures.bias[:3] == pytest.approx((0.005, 0.0, 0.0), abs=1e-12)
    for part in (figures.noise, figures.vibration, figures.allan_1_s):
        assert part == pytest.approx(ZERO, abs=1e-6)


def test_reset_forgets() -> None:
    monitor = ImuMonitor()
    for k in range(50):
        monitor.step((0.01 * k, 0.0, 0.0), (1.0, 0.1 * k, 0.0), LEVEL)
    monitor.reset()
    assert monitor.figures() == ImuMonitor().figures()


@pytest.mark.parametrize("place", range(9))
def test_not_finite_is_refused(place: int) -> None:
    monitor = ImuMonitor()
    for _ in range(50):
        monitor.step(STILL, STILL, LEVEL)
    before = monitor.figures()
    numbers = [0.0] * 9
    numbers[place] = math.nan
    with pytest.raises(ValueError, match="finite"):
        monitor.step(numbers[:3], numbers[3:6], numbers[6:])
    assert monitor.figures() == before


# Statistics --------------------------------------------------------------------------------------------


def test_white_noise_has_its_density() -> None:
    """60 s; neighbouring sixth differences are so alike that only about a third of them count."""
    density = np.repeat([0.02 * DEG, 0.003], 3)
    angles, readings = at_rest(24_001)
    noise = np.random.default_rng(1).standard_normal(readings.shape)
    figures = measured(angles, readings + density / math.sqrt(PERIOD) * noise)
    assert np.asarray(figures.noise) == pytest.approx(density, rel=0.05)
    # 59 differences of windows of 1 s, of which neighbours are correlated: two thirds count
    ratio = (np.asarray(figures.allan_1_s) / density) ** 2
    free = 39
    assert chi2.isf(1.0 - RARE, free) / free < ratio.min()
    assert ratio.max() < chi2.isf(RARE, free) / free


def test_vibration_is_told_from_noise() -> None:
    """rms of 0.5 at 1/rev and 0.8 at 2/rev, within what 0.1 s see of them; noise hardly feels it."""
    angles, readings = at_rest(24_001)
    noise = 0.06 * np.random.default_rng(2).standard_normal((len(readings), 3))
    turn = OMEGA_0 * PERIOD * np.arange(len(readings))
    readings[:, 3:] += noise
    quiet = measured(angles, readings)
    readings[:, 3] += 0.5 * np.cos(turn)
    readings[:, 4] -= 0.5 * np.sin(turn)
    readings[:, 5] += 0.8 * np.cos(2.0 * turn)
    figures = measured(angles, readings)
    rms = np.array([0.5, 0.5, 0.8]) / math.sqrt(2.0)
    assert np.asarray(figures.vibration[3:]) == pytest.approx(rms, rel=0.03)
    assert np.asarray(figures.noise[3:]) == pytest.approx(np.asarray(quiet.noise[3:]), rel=0.01)
    assert max(quiet.vibration[3:]) < 0.01


def test_bias_in_motion_against_counting_encoders() -> None:
    """Errors over the predicted sigmas in sixteen flights of 30 s, the attitude known to a count."""
    flights, square = 16, np.zeros(AXES)
    for seed in range(flights):
        angles, readings = swinging(30.0, seed)
        draw = np.random.default_rng(100 + seed)
        bias = np.repeat([0.5 * DEG, 0.05], 3) * draw.standard_normal(AXES)
        sigma = np.repeat([0.4 * DEG, 0.06], 3)
        counted = RADIAN_PER_COUNT * np.round(angles / RADIAN_PER_COUNT)
        figures = measured(counted, readings + bias + sigma * draw.standard_normal(readings.shape))
        square += ((np.asarray(figures.bias) - bias) / np.asarray(figures.bias_sigma)) ** 2
    assert square.max() < chi2.isf(RARE, flights)
    assert square[:3].min() > chi2.isf(1.0 - RARE, flights)


def test_lever_arm_is_taken_off() -> None:
    place = (0.5, 0.2, -0.3)
    angles, readings = swinging(20.0, 3, place)
    told = measured(angles, readings, ImuAttitudeParameters(imu_x=0.5, imu_y=0.2, imu_z=-0.3))
    untold = measured(angles, readings, ImuAttitudeParameters(imu_x=0.0, imu_z=0.0))
    assert np.abs(told.bias[:3]).max() < 1e-5
    assert np.abs(told.bias[3:]).max() < 0.1 * np.abs(untold.bias[3:]).max()
