"""Hall sensor: source eq. 4.1 by hand, pulses against their exact times, lag, steps, standstill."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from heli_bench_sim.hall_sensor import (
    HALL_STATE_SIZE,
    HallConstants,
    HallParameters,
    HallState,
    hall_constants,
    hall_sample,
    hall_settled,
)
from heli_bench_sim.rotor_azimuth import turned
from heli_common.records import packed

Array = NDArray[np.float64]

PERIOD, TURN, OMEGA_0 = 0.0025, 2.0 * math.pi, 163.363
STANDARD = HallParameters()
GEAR = 8.0
C = packed(hall_constants(STANDARD, GEAR))
FINE = packed(hall_constants(replace(STANDARD, lag=0.0, bits=24.0), GEAR))
STEP = 10.0 / 4096.0 * 2400.0 / 60.0 * TURN / GEAR
"""Of the measured rotor speed [rad/s]."""


def measured(
    speeds: list[float], state: Array, c: HallConstants = C, before: float | None = None
) -> list[float]:
    """Readings while the rotor takes these speeds, the azimuth following; `before` is that at the start."""
    azimuth, last = float(state[HallState.azimuth]), speeds[0] if before is None else before
    readings = []
    for speed in speeds:
        azimuth, last = turned(azimuth, last, speed, PERIOD), speed
        readings.append(hall_sample(speed, azimuth, state, c))
    return readings


def test_chain_by_hand() -> None:
    """1560 rpm of the rotor: motor 12480 rpm = 208 Hz, 416 pulses a second, 5.2 V, U * 80 * 0.5 * 60 rpm."""
    omega = 1560.0 / 60.0 * TURN
    state = hall_settled(omega, 0.0, C)
    assert state[HallState.frequency] == pytest.approx(416.0, rel=1e-14)
    assert state[HallState.voltage] == pytest.approx(5.2, rel=1e-14)
    motor_rpm = 5.2 * 80.0 * 0.5 * 60.0
    assert motor_rpm == pytest.approx(12480.0, rel=1e-14)
    assert C.speed_per_volt * 5.2 == pytest.approx(motor_rpm / 8.0 / 60.0 * TURN, rel=1e-14)
    # 5.2 V is 2129.92 steps of 10 V / 4096
    assert measured([omega], state)[0] == pytest.approx(2130.0 * STEP, rel=1e-12)


@settings(deadline=None, max_examples=50)
@given(
    st.floats(2.0, 310.0),
    st.sampled_from([-1.0, 1.0]),
    st.floats(0.0, TURN, exclude_max=True),
    st.sampled_from([8.0, 9.37]),
)
def test_steady_speed_is_read_to_half_a_step(omega: float, sense: float, azimuth: float, gear: float) -> None:
    """At any azimuth, either way round, also with a gear that does not turn a whole number of times."""
    omega *= 8.0 / gear
    c = packed(hall_constants(STANDARD, gear))
    readings = measured([sense * omega] * 200, hall_settled(sense * omega, azimuth, c), c)
    assert np.abs(np.array(readings) - omega).max() <= 0.5 * STEP * 8.0 / gear * (1.0 + 1e-9)


def test_readings_are_whole_steps_and_end_at_the_range() -> None:
    state = hall_settled(0.0, 0.0, C)
    ramp = [float(speed) for speed in np.linspace(0.0, 400.0, 2000)] + [400.0] * 100
    codes = np.array(measured(ramp, state)) / STEP
    assert codes == pytest.approx(np.rint(codes), abs=1e-9)
    assert len(np.unique(np.rint(codes))) > 1000
    assert codes.max() == pytest.approx(4095.0, abs=1e-9)  # 800 Hz is 314.16 rad/s
    assert codes[-1] == pytest.approx(4095.0, abs=1e-9)
    assert state[HallState.frequency] == 800.0
    assert state[HallState.voltage] == pytest.approx(10.0, rel=1e-6)


def test_lag_by_hand() -> None:
    """400 Hz, one pulse a sample: from 0 V the voltage goes exp(-t / 5 ms) of the way, also from above."""
    omega = 400.0 / 16.0 * TURN
    for start in (0.0, 9.0):
        state = hall_settled(omega, 0.1, C)
        state[HallState.voltage] = start
        for k, reading in enumerate(measured([omega] * 10, state), 1):
            volts = 5.0 + (start - 5.0) * math.exp(-k * PERIOD / 0.005)
            assert reading == pytest.approx(volts * C.speed_per_volt, abs=0.5 * STEP * (1.0 + 1e-9))


def exact_frequency(at: Array, ends: Array) -> Array:
    """Whole pulse distances that ended within each sample over their time, from the exact times of pulses."""
    done = np.searchsorted(at, ends, side="right")
    found, frequency = [], 0.0
    for k, end in enumerate(ends):
        before = done[k - 1] if k else 0
        if before and done[k] > before:
            frequency = (done[k] - before) / (at[done[k] - 1] - at[before - 1])
        elif done[k] > before:
            frequency = (done[k] - 1) / (at[done[k] - 1] - at[0]) if done[k] > 1 else 0.0
        elif before and frequency:
            frequency = min(frequency, 1.0 / (end - at[before - 1]))
        found.append(frequency if frequency >= 5.0 else 0.0)
        frequency = found[-1]
    return np.array(found)


@pytest.mark.parametrize("acceleration", [3.0, 40.0, 117.0])
def test_run_up_is_timed_exactly(acceleration: float) -> None:
    """Twin: with even acceleration a pulse i comes at sqrt(2 i / (pulses per rad * acceleration))."""
    pulses_per_radian = 16.0 / TURN
    samples = round(250.0 / acceleration / PERIOD)
    ends: Array = PERIOD * np.arange(1, samples + 1, dtype=np.float64)
    count = int(0.5 * acceleration * ends[-1] ** 2 * pulses_per_radian)
    at = np.sqrt(2.0 * np.arange(1, count + 1) / (pulses_per_radian * acceleration))
    speeds = [float(speed) for speed in acceleration * ends]
    found = np.array(measured(speeds, hall_settled(0.0, 0.0, FINE), FINE, before=0.0)) * pulses_per_radian
    expected = exact_frequency(at, ends)
    assert found == pytest.approx(expected, abs=800.0 / 2**24 + 1e-6)
    # the mean over the latest pulses lags by half of their time and by that since
    late = (acceleration * ends - found / pulses_per_radian)[ends > 0.5 * ends[-1]] / acceleration
    assert 0.0 < late.min() <= late.max() < 0.02


def test_run_down_is_timed_exactly_and_ends_at_zero() -> None:
    """Twin: from 100 rad/s at -50 rad/s^2 to a stop at 2 s, then standing."""
    pulses_per_radian, start, braking = 16.0 / TURN, 100.0, 50.0
    ends: Array = PERIOD * np.arange(1, 1201, dtype=np.float64)
    speeds = [max(start - braking * float(end), 0.0) for end in ends]
    number = np.arange(1, int(0.5 * start**2 / braking * pulses_per_radian) + 1) / pulses_per_radian
    at = (start - np.sqrt(start**2 - 2.0 * braking * number)) / braking
    state = hall_settled(0.0, 0.0, FINE)
    found = np.array(measured(speeds, state, FINE, before=start)) * pulses_per_radian
    assert found == pytest.approx(exact_frequency(at, ends), abs=800.0 / 2**24 + 1e-6)
    assert found[-1] == 0.0
    assert (found[700:] > 0.0).any()


def test_stopped_at_once_falls_as_one_over_the_waiting_time() -> None:
    state = hall_settled(OMEGA_0, 0.0, C)
    stopped = float(state[HallState.azimuth])
    for k in range(1, 200):
        reading = hall_sample(0.0, stopped, state, C)
        assert state[HallState.frequency] <= 1.0 / (k * PERIOD) * (1.0 + 1e-12)
    assert state[HallState.frequency] == 0.0
    assert reading == 0.0


@pytest.mark.parametrize("azimuth", [0.0, 0.3, TURN / 16.0])
def test_at_rest_nothing_is_read(azimuth: float) -> None:
    """Standing on a magnet or between two, still or rocking over it by rounding or by a hand."""
    for amount in (0.0, 1e-16, 1e-9, 0.1):
        state = hall_settled(0.0, azimuth, C)
        for k in range(400):
            rocked = (azimuth + amount * (-1) ** k) % TURN
            assert hall_sample(0.0, rocked, state, C) == 0.0
        assert np.isfinite(state).all()


def test_all_zeros_is_power_up_at_rest() -> None:
    assert hall_settled(0.0, 0.0, C).tolist() == [0.0] * HALL_STATE_SIZE


def test_first_pulse_gives_no_speed_the_second_does() -> None:
    """Powered up with the rotor turning: nothing is known before a whole distance of pulses."""
    state = hall_settled(0.0, 0.9 * TURN / 16.0, FINE)
    omega = 100.0 / 16.0 * TURN  # 100 Hz: a pulse every fourth sample, the first after 1 ms
    readings = np.array(measured([omega] * 8, state, FINE)) * 16.0 / TURN
    assert readings == pytest.approx([0.0] * 4 + [100.0] * 4, abs=1e-4)


def test_below_the_lowest_frequency_nothing_is_read() -> None:
    for frequency, expected in ((4.9, 0.0), (5.1, 5.1)):
        omega = frequency / 16.0 * TURN
        readings = measured([omega] * 400, hall_settled(omega, 0.0, C), C)
        assert readings[-1] == pytest.approx(expected / 16.0 * TURN, abs=0.5 * STEP)


@settings(deadline=None, max_examples=100)
@given(
    st.lists(st.tuples(st.floats(-600.0, 600.0), st.floats(0.0, TURN)), min_size=1, max_size=40),
    st.floats(0.0, TURN),
)
def test_never_leaves_its_range(motion: list[tuple[float, float]], start: float) -> None:
    """Even if speed and azimuth do not belong together."""
    state = hall_settled(0.0, start, C)
    for omega, azimuth in motion:
        assert 0.0 <= hall_sample(omega, azimuth, state, C) <= 4095.0 * STEP * (1.0 + 1e-12)
        assert np.isfinite(state).all()
        assert abs(state[HallState.way]) < 1.0


def test_wrapping_of_the_azimuth_does_not_matter() -> None:
    wrapped, running = hall_settled(OMEGA_0, 0.0, C), hall_settled(OMEGA_0, 0.0, C)
    for k in range(1, 400):
        azimuth = OMEGA_0 * PERIOD * k
        one = hall_sample(OMEGA_0, azimuth % TURN, wrapped, C)
        assert hall_sample(OMEGA_0, azimuth, running, C) == pytest.approx(one, abs=1e-9)


def test_bad_constants_are_refused() -> None:
    for parameters, gear, named in (
        (replace(STANDARD, magnets=1.5), GEAR, "magnets 1.5"),
        (replace(STANDARD, bits=7.5), GEAR, "bits 7.5"),
        (replace(STANDARD, lowest_frequency=50.0, top_frequency=50.0), GEAR, "lowest_frequency 50"),
        (STANDARD, 0.0, "motor_gear 0.0"),
        (STANDARD, math.nan, "motor_gear nan"),
    ):
        with pytest.raises(ValueError, match=named):
            hall_constants(parameters, gear)
