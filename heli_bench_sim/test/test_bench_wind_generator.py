"""Wind generator: fan and jet by hand, the turbulence against Dryden's spectra, without and with chance."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import chi2

from heli_bench_sim.wind_generator import (
    WIND_NORMALS,
    WIND_STATE_SIZE,
    WindConstants,
    WindParameters,
    WindState,
    check_wind_command,
    wind_advance,
    wind_at,
    wind_constants,
)
from heli_common.compiled import compiled

C = wind_constants(WindParameters())
CALM = wind_constants(WindParameters(intensity=0.0))
TOP = 8.0
RARE = 1e-5
"""Chance that a right model fails one chi-square test; the seeds are fixed all the same."""
Array = NDArray[np.float64]


@compiled
def blow(state: Array, command: float, normals: Array, period: float, c: WindConstants, out: Array) -> None:
    """Air at the centre of the flight space after each step."""
    for step in range(normals.shape[0]):
        wind_advance(state, command, normals[step], period, c)
        wind_at(0.0, 0.0, 0.0, state, c, out[step])


def running(speed: float) -> Array:
    state = np.zeros(WIND_STATE_SIZE)
    state[WindState.speed] = speed
    return state


def air(state: Array, y: float, z: float, c: WindConstants = C) -> Array:
    out = np.full(3, np.nan)
    wind_at(0.1, y, z, state, c, out)
    return out


def gusts(speed: float, period: float, normals: Array, c: WindConstants = C) -> Array:
    """(n, 3) gusts at the centre over their standard deviation, the first 20 lengths of air left out."""
    out = np.empty((len(normals), 3))
    blow(running(speed), speed, normals, period, c, out)
    warm = math.ceil(20.0 * c.length / (speed * period))
    return (out[warm:] + [speed, 0.0, 0.0]) / (c.intensity * speed)


def correlation(lag: Array, component: int) -> Array:
    """Autocorrelation of Dryden's field over lag [lengths]: exp(-r) along, exp(-r) (1 - r / 2) across."""
    return np.exp(-lag) * (1.0 if component == 0 else 1.0 - 0.5 * lag)


def spectrum(w: Array, component: int) -> Array:
    """One-sided spectrum of unit variance over spatial frequency [rad/length], MIL-F-8785C."""
    if component == 0:
        return 2.0 / math.pi / (1.0 + w**2)
    return (1.0 + 3.0 * w**2) / (1.0 + w**2) ** 2 / math.pi


def frequencies(steps: int, h: float) -> Array:
    """Spatial frequencies [rad/length] of the Fourier transform of a record in steps of h lengths."""
    return 2.0 * math.pi * np.arange(steps // 2 + 1, dtype=np.float64) / (steps * h)


def test_steady_jet_by_hand() -> None:
    state = running(5.0)
    assert air(state, 0.0, 0.0).tolist() == [-5.0, 0.0, 0.0]
    assert air(state, 0.6, 0.0) == pytest.approx([-2.5, 0.0, 0.0], rel=1e-14)
    assert air(state, 0.0, -1.2) == pytest.approx([-5.0 / 16.0, 0.0, 0.0], rel=1e-14)
    assert air(state, 100.0, 0.0).tolist() == [0.0, 0.0, 0.0]


def test_gusts_by_hand() -> None:
    """A tenth of the local mean speed, along the jet against the north axis."""
    state = running(5.0)
    state[WindState.along] = 2.0
    state[WindState.east_first] = 1.0
    state[WindState.down_second] = 1.0
    expected = [-5.0 - 1.0, 0.5 * math.sqrt(1.5), 0.5 * (1.0 - math.sqrt(3.0)) / math.sqrt(2.0)]
    assert air(state, 0.0, 0.0) == pytest.approx(expected, rel=1e-14)
    assert air(state, 0.6, 0.0) == pytest.approx(0.5 * np.array(expected), rel=1e-14)


@pytest.mark.parametrize("period", [0.0025, 0.01, 0.5])
def test_fan_follows_with_its_lag(period: float) -> None:
    state, normals = running(0.0), np.zeros(WIND_NORMALS)
    for _ in range(round(1.5 / period)):
        wind_advance(state, 6.0, normals, period, C)
    assert state[WindState.speed] == pytest.approx(6.0 * (1.0 - math.exp(-1.0)), rel=1e-12)
    for _ in range(round(3.0 / period)):
        wind_advance(state, 0.0, normals, period, C)
    assert state[WindState.speed] == pytest.approx(6.0 * (1.0 - math.exp(-1.0)) * math.exp(-2.0), rel=1e-12)


@pytest.mark.parametrize(
    ("command", "reached"), [(100.0, TOP), (-3.0, 0.0), (math.inf, TOP), (math.nan, 0.0), (TOP, TOP)]
)
def test_command_is_clipped(command: float, reached: float) -> None:
    state = running(0.0)
    wind_advance(state, command, np.zeros(WIND_NORMALS), 100.0, C)
    assert state[WindState.speed] == pytest.approx(reached, abs=1e-12)


def test_command_out_of_range_is_refused_with_value_and_range() -> None:
    assert [check_wind_command(speed) for speed in (0.0, 3, TOP)] == [0.0, 3.0, TOP]
    for speed in (8.001, -0.001, math.nan, math.inf):
        with pytest.raises(ValueError, match=r"allowed: 0 \.\. 8 m/s") as caught:
            check_wind_command(speed)
        assert repr(speed) in str(caught.value)
    assert check_wind_command(9.0, WindParameters(largest_speed=10.0)) == 9.0


def test_fan_at_rest_gives_still_air_and_keeps_its_field() -> None:
    state = running(0.0)
    state[1:] = 1.0, -2.0, 3.0, 4.0, 5.0
    kept = state.copy()
    wind_advance(state, 0.0, np.array([9.0, 9.0, 9.0]), 0.0025, C)
    assert state.tolist() == kept.tolist()
    assert np.abs(air(state, 0.0, 0.0)).tolist() == [0.0, 0.0, 0.0]


@settings(deadline=None, max_examples=50)
@given(st.floats(-330.0, 0.0), st.floats(0.0, 8.0))
def test_no_singularity_towards_rest(exponent: float, command: float) -> None:
    state = running(10.0**exponent)
    wind_advance(state, command, np.array([1.0, -1.0, 2.0]), 0.0025, C)
    assert np.isfinite(state).all()
    assert np.abs(state[1:]).max() <= 0.6  # h <= 0.02 at 8 m/s: sqrt(2 h) of each number at most


def test_spin_up_travels_the_way_of_the_lag() -> None:
    """One long step and many short ones forget the same share of the field: exp(-distance / L)."""
    distance = 6.0 * (0.9 - 1.5 * (1.0 - math.exp(-0.6)))
    for steps in (1, 7, 360):
        state = running(0.0)
        state[WindState.along] = 1.0
        for _ in range(steps):
            wind_advance(state, 6.0, np.zeros(WIND_NORMALS), 0.9 / steps, C)
        assert state[WindState.along] == pytest.approx(math.exp(-distance), rel=1e-10)


def response(speed: float, period: float, c: WindConstants = C) -> Array:
    """(n, 3) answer to a unit number in the first step, over the standard deviation."""
    normals = np.zeros((math.ceil(30.0 * c.length / (speed * period)), WIND_NORMALS))
    normals[0] = 1.0
    out = np.empty((len(normals), 3))
    blow(running(speed), speed, normals, period, c, out)
    return (out + [speed, 0.0, 0.0]) / (c.intensity * speed)


@pytest.mark.parametrize("speed", [0.5, 8.0])
@pytest.mark.parametrize("period", [0.0025, 0.01])
@pytest.mark.parametrize("component", [0, 1, 2])
def test_correlation_is_drydens_without_chance(speed: float, period: float, component: int) -> None:
    """The numbers being white, the answer to one of them holds the whole autocorrelation."""
    answer = response(speed, period)[:, component]
    h = speed * period / C.length
    for lag in (0, 1, 2, round(0.5 / h), round(1.0 / h), round(2.0 / h), round(3.0 / h)):
        found = float(answer[: len(answer) - lag] @ answer[lag:])
        expected = float(correlation(np.array(lag * h), component))
        assert found == pytest.approx(expected, abs=max(h**2 / 40.0, 1e-10))


def test_a_longer_field_is_the_same_field_stretched() -> None:
    longer = wind_constants(WindParameters(length=2.0))
    assert response(4.0, 0.005, longer) == pytest.approx(response(2.0, 0.005), abs=1e-12)


@pytest.mark.parametrize("component", [0, 1, 2])
def test_spectrum_is_drydens_without_chance(component: int) -> None:
    """Transfer function of the recursion against the analytic spectrum, up to 10 rad per length."""
    h = TOP * 0.0025 / C.length
    transfer = np.fft.rfft(response(TOP, 0.0025)[:, component], n=2**16)
    w = frequencies(2**16, h)
    band = (w > 0.01) & (w < 10.0)
    found = np.abs(transfer[band]) ** 2 * h / math.pi
    # sampling folds the tail back: 2 C / w_s^2 zeta(2) for a tail C / w^2, w_s = 2 pi / h
    folded = (2.0 if component == 0 else 3.0) / math.pi * 2.0 * (h / (2.0 * math.pi)) ** 2 * math.pi**2 / 6.0
    assert found == pytest.approx(spectrum(w[band], component) + folded, rel=2e-3)


@pytest.mark.parametrize(("speed", "period"), [(8.0, 0.0025), (8.0, 0.01), (2.0, 0.01)])
def test_variance_is_a_tenth_of_the_speed_squared_at_any_step(speed: float, period: float) -> None:
    """Chi-square; samples count as independent in the number N / sum(correlation^2)."""
    rng = np.random.default_rng([1, round(speed), round(period * 1e4)])
    found = gusts(speed, period, rng.standard_normal((200_000, WIND_NORMALS)))
    lags = speed * period * np.arange(-2000, 2001)
    for component in range(3):
        independent = len(found) / np.sum(correlation(np.abs(lags), component) ** 2)
        squares = independent * np.mean(found[:, component] ** 2)
        low, high = chi2.ppf([RARE / 2.0, 1.0 - RARE / 2.0], independent)
        assert low < squares < high
        assert high < 1.25 * low  # the bound itself is sharp enough to tell 1 from a wrong filter
    cross = np.corrcoef(found.T)[np.triu_indices(3, 1)]
    assert np.abs(cross).max() < 5.0 / math.sqrt(independent)


def test_spectrum_of_a_long_record_is_drydens() -> None:
    """Mean ratio of periodogram to spectrum in bands: chi-square with two per frequency."""
    steps, h = 2**18, TOP * 0.0025 / C.length
    warm = math.ceil(20.0 / h)
    normals = np.random.default_rng(7).standard_normal((steps + warm, WIND_NORMALS))
    found = gusts(TOP, 0.0025, normals)
    assert len(found) == steps
    w = frequencies(steps, h)
    for component in range(3):
        power = np.abs(np.fft.rfft(found[:, component])) ** 2 * h / (math.pi * steps)
        for low, high in ((0.05, 0.3), (0.3, 0.8), (0.8, 1.5), (1.5, 3.0), (3.0, 5.0)):
            band = (w >= low) & (w < high)
            ratio = 2.0 * np.sum(power[band] / spectrum(w[band], component))
            freedom = 2 * int(np.count_nonzero(band))
            assert chi2.ppf(RARE / 2.0, freedom) < ratio < chi2.ppf(1.0 - RARE / 2.0, freedom)


@settings(deadline=None, max_examples=100)
@given(
    st.floats(0.0, 3.0),
    st.floats(-math.pi, math.pi),
    st.floats(-math.pi, math.pi),
    st.floats(0.0, 8.0),
    st.lists(st.floats(-3.0, 3.0), min_size=5, max_size=5),
)
def test_jet_is_round_and_falls_off(
    radius: float, one: float, other: float, speed: float, field: list[float]
) -> None:
    state = np.array([speed, *field])
    here = air(state, radius * math.cos(one), radius * math.sin(one))
    there = air(state, radius * math.cos(other), radius * math.sin(other))
    assert here == pytest.approx(there, rel=1e-12, abs=1e-300)
    further = air(state, 1.1 * radius * math.cos(one), 1.1 * radius * math.sin(one))
    assert (np.abs(further) <= np.abs(here) * (1.0 + 1e-14)).all()
    assert air(state, radius, 0.0, CALM).tolist()[1:] == [0.0, 0.0]


def test_same_numbers_same_air() -> None:
    normals = np.random.default_rng(3).standard_normal((4000, WIND_NORMALS))
    first, second = gusts(8.0, 0.01, normals), gusts(8.0, 0.01, normals.copy())
    assert first.tobytes() == second.tobytes()
    other = gusts(8.0, 0.01, np.random.default_rng(4).standard_normal((4000, WIND_NORMALS)))
    assert first.tobytes() != other.tobytes()
