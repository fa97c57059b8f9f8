"""Test signals: hand-computed patterns, power inside the band, peaks, means."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.timing import CONTROL_PERIOD
from heli_identification import excitation_signals as signals

MINUTE = 6000


def share_inside(signal: np.ndarray, low: float, high: float) -> float:
    """Part of a signal's power at frequencies from low to high [rad/s], the mean left out."""
    power = np.abs(np.fft.rfft(signal)) ** 2
    frequency = 2.0 * np.pi * np.fft.rfftfreq(signal.size, CONTROL_PERIOD)
    inside = (frequency >= low - 1e-6) & (frequency <= high + 1e-6)
    return float(power[inside].sum() / power[1:].sum())


def rng(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_patterns_by_hand() -> None:
    assert signals.pattern(signals.PATTERNS["steps"], 9, 2).tolist() == [1, 1, 0, 0, -1, -1, 0, 0, 0]
    assert signals.pattern(signals.PATTERNS["doublets"], 4, 1).tolist() == [1, -1, 0, 0]
    once = signals.pattern(signals.PATTERNS["3-2-1-1"], 20, 1)
    assert once[:10].tolist() == [1, 1, 1, -1, -1, 1, -1, 0, 0, 0]
    assert once[10:].tolist() == (-once[:10]).tolist()


def test_ramps_by_hand() -> None:
    assert signals.ramps(10, 2).tolist() == [0, 0.5, 1, 0.5, 0, -0.5, -1, -0.5, 0, 0]


@given(name=st.sampled_from(sorted(signals.PATTERNS)), hold=st.integers(1, 50), count=st.integers(100, 3000))
def test_patterns_are_bounded_and_have_no_mean(name: str, hold: int, count: int) -> None:
    signal = signals.pattern(signals.PATTERNS[name], count, hold)
    assert np.all(np.abs(signal) <= 1.0)
    assert signal.sum() == 0.0


def test_the_chirp_sweeps_from_one_end_to_the_other() -> None:
    signal = signals.chirp(MINUTE, (0.5, 20.0))
    crossings = np.flatnonzero(np.diff(np.signbit(signal)))
    spacing = np.diff(crossings) * CONTROL_PERIOD
    assert np.isclose(np.pi / spacing[-1], 20.0, rtol=0.08)
    growth = np.log(40.0) / 60.0  # phase 0.5 (exp(growth t) - 1) / growth is pi at the first crossing
    assert np.isclose(crossings[0] * CONTROL_PERIOD, np.log1p(np.pi * growth / 0.5) / growth, atol=0.011)
    assert np.all(np.diff(crossings) <= np.diff(crossings)[0])
    assert share_inside(signal, 0.45, 21.0) > 0.96


@settings(max_examples=25, deadline=None)
@given(
    low=st.floats(0.3, 5.0),
    ratio=st.floats(2.0, 12.0),
    count=st.integers(1500, 8000),
    seed=st.integers(0, 99),
)
def test_noise_has_all_power_in_its_band(low: float, ratio: float, count: int, seed: int) -> None:
    signal = signals.noise(count, (low, ratio * low), rng(seed))
    assert np.isclose(np.max(np.abs(signal)), 1.0)
    assert abs(signal.mean()) < 1e-12
    assert share_inside(signal, low, ratio * low) > 1.0 - 1e-12


def test_noise_is_white_in_its_band() -> None:
    power = np.zeros(MINUTE // 2 + 1)
    for seed in range(200):
        signal = signals.noise(MINUTE, (1.0, 10.0), rng(seed))
        power += np.abs(np.fft.rfft(signal / np.std(signal))) ** 2
    lines = power[10:95]  # 2 pi / 60 s apart
    assert np.std(lines) / np.mean(lines) < 0.12
    assert abs(np.polyfit(np.arange(85), lines / np.mean(lines), 1)[0]) < 1.5e-3


@pytest.mark.parametrize("of", [1, 2, 4])
def test_a_multisine_is_flat_of_low_crest_and_shared_without_overlap(of: int) -> None:
    band = (0.5, 15.0)
    period = signals.multisine_period(MINUTE)
    assert period == 2000
    many = [signals.multisine(MINUTE, band, rng(3), place, of) for place in range(of)]
    for signal in many:
        assert np.isclose(np.max(np.abs(signal)), 1.0)
        assert abs(signal[:period].mean()) < 1e-12
        assert share_inside(signal[: 3 * period], *band) > 1.0 - 1e-12
        assert 1.0 / np.std(signal) < 2.1  # a single sine has 1.41, Gaussian noise about 3.5
        lines = np.abs(np.fft.rfft(signal[:period]))
        used = lines > 1e-9
        assert np.allclose(lines[used], lines[used][0])
    for i in range(of):
        for j in range(i):
            assert abs(many[i][:period] @ many[j][:period]) < 1e-9


@settings(max_examples=25, deadline=None)
@given(low=st.floats(0.3, 3.0), ratio=st.floats(4.0, 30.0), seed=st.integers(0, 999))
def test_a_prbs_has_two_levels_no_mean_and_the_spectrum_of_its_register(
    low: float, ratio: float, seed: int
) -> None:
    band = (low, ratio * low)
    length = 2 ** signals.prbs_bits(band) - 1
    period = length * signals.prbs_clock(band)
    signal = signals.prbs(2 * period, band, rng(seed))
    assert len(set(signal.tolist())) == 2
    assert np.max(np.abs(signal)) == 1.0
    assert abs(signal[:period].mean()) < 1e-12
    assert np.array_equal(signal[:period], signal[period:])
    assert 2.0 * np.pi / (period * CONTROL_PERIOD) >= low - 1e-9
    # greatest period: the autocorrelation is two-valued, so all lines below the clock are equally strong
    chips = signal[np.arange(period) // 1][:: signals.prbs_clock(band)]
    binary = np.where(chips > 0.0, 1.0, -1.0)
    correlation = np.array([binary @ np.roll(binary, lag) for lag in range(length)])
    assert correlation[0] == length
    assert np.all(correlation[1:] == -1.0)


def test_the_upper_end_of_a_prbs_is_its_half_power() -> None:
    band = (0.5, 12.0)
    clock = signals.prbs_clock(band)
    assert clock == 23
    sinc = np.sinc(band[1] * clock * CONTROL_PERIOD / (2.0 * np.pi)) ** 2
    assert np.isclose(sinc, 0.5, atol=0.01)
    assert signals.prbs_bits(band) == 5  # 31 clocks of 0.23 s: 0.88 rad/s; 63 would begin at 0.43 rad/s
    signal = signals.prbs(31 * clock * 8, band, rng())
    assert 0.68 < share_inside(signal, *band) < 0.85


def test_seeds_make_different_registers() -> None:
    assert len({signals.prbs(2000, (0.5, 12.0), rng(seed)).tobytes() for seed in range(20)}) > 17


def test_too_narrow_a_band_has_no_register() -> None:
    assert signals.prbs_bits((1.0, 2.0)) == 0


def test_fading_by_hand() -> None:
    assert np.allclose(signals.fade(5, 0), 1.0)
    quarter = 0.5 - 0.5 * np.cos(np.pi * 0.25)
    assert np.allclose(signals.fade(6, 2), [quarter, 1.0 - quarter, 1.0, 1.0, 1.0 - quarter, quarter])
