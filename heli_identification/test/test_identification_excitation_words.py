"""Excitations read, refused and written, and what their samples promise."""

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_identification.excitation import (
    CHANNELS,
    COMMAND_CHANNELS,
    HELD,
    REFERENCE_CHANNELS,
    SIGNALS,
    TOGETHER,
    Excitation,
    samples,
)
from heli_identification.excitation_words import excitation_from_text, excitation_mapping, read_excitation

PRBS = {"signal": "prbs", "channel": "B_1s", "amplitude_deg": 0.5, "band_rad_s": [0.5, 12], "duration": 60.0}


@st.composite
def words(draw: st.DrawFn) -> dict[str, object]:
    """A mapping that is allowed."""
    signal = draw(st.sampled_from(SIGNALS))
    group = draw(st.sampled_from((COMMAND_CHANNELS, REFERENCE_CHANNELS[:3], ("r",))))
    most = len(group) if signal in TOGETHER else 1
    channels = draw(st.lists(st.sampled_from(group), min_size=1, max_size=most, unique=True))
    key = {"B": "amplitude_deg", "u": "amplitude_m_s", "r": "amplitude_deg_s"}[group[0][0]]
    mapping: dict[str, object] = {"signal": signal, "channels": channels}
    mapping[key] = draw(st.floats(0.01, 0.3))
    mapping["duration"] = draw(st.floats(25.0, 60.0))
    mapping["seed"] = draw(st.integers(0, 1000))
    mapping["fade"] = draw(st.floats(0.0, 5.0))
    if signal in HELD:
        mapping["hold"] = draw(st.floats(0.05, 1.0))
    else:
        low = draw(st.floats(0.5, 3.0))
        mapping["band_rad_s"] = [low, draw(st.floats(max(8.0, 4.5 * low), 40.0))]
    return mapping


def test_a_whole_one_by_hand() -> None:
    assert read_excitation(PRBS) == Excitation(
        signal="prbs",
        channels=("B_1s",),
        amplitude=np.radians(0.5),
        band=(0.5, 12.0),
        duration=60.0,
        fade=1.0,
        seed=1,
    )


@settings(max_examples=60, deadline=None)
@given(words())
def test_every_excitation_is_bounded_repeatable_and_reads_back(mapping: dict[str, object]) -> None:
    excitation = read_excitation(mapping)
    assert read_excitation(yaml.safe_load(yaml.safe_dump(excitation_mapping(excitation)))) == excitation
    table = samples(excitation)
    assert table.shape == (excitation.count, len(CHANNELS))
    assert np.max(np.abs(table)) <= excitation.amplitude
    used = [CHANNELS.index(channel) for channel in excitation.channels]
    assert np.all(np.any(table[:, used] != 0.0, axis=0))
    assert np.all(np.delete(table, used, axis=1) == 0.0)
    samples.cache_clear()
    assert np.array_equal(samples(excitation), table)


def test_fading_in_and_out_leaves_the_power_in_the_band() -> None:
    table = samples(read_excitation(PRBS | {"signal": "noise"}))
    power = np.abs(np.fft.rfft(table[:, 0])) ** 2
    frequency = 2.0 * np.pi * np.fft.rfftfreq(len(table), 0.01)
    assert power[(frequency > 0.4) & (frequency < 12.2)].sum() / power.sum() > 0.999
    assert abs(table[0, 0]) < 1e-5 and abs(table[-1, 0]) < 1e-5


@pytest.mark.parametrize("signal", ["prbs", "noise"])
def test_channels_and_seeds_are_independent(signal: str) -> None:
    settings_ = PRBS | {"signal": signal, "channels": ["B_1s", "A_1s"]}
    del settings_["channel"]
    one, other = samples(read_excitation(settings_)), samples(read_excitation(settings_ | {"seed": 2}))
    for first, second in ((one[:, 0], one[:, 1]), (one[:, 0], other[:, 0]), (one[:, 1], other[:, 1])):
        assert abs(np.corrcoef(first, second)[0, 1]) < 0.35


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"signal": "square"}, "signal: 'square' is no signal (allowed: steps,"),
        ({"channel": "B_2s"}, "channel: 'B_2s' is no channel (allowed: B_1s,"),
        ({"channels": ["B_1s"]}, "channels: ['B_1s'] names no channels"),
        ({"amplitude_deg": 6.1}, "amplitude_deg: 6.1 is out of range (allowed: 0.001 .. 6 deg)"),
        ({"channel": "theta_0", "amplitude_deg": 2.0}, "amplitude_deg: 2.0 is out of range"),
        ({"amplitude_m_s": 0.1}, "amplitude_m_s: does not fit prbs on B_1s (allowed: signal,"),
        ({"hold": 1.0}, "hold: does not fit prbs on B_1s"),
        ({"band_rad_s": [0.5]}, "band_rad_s: [0.5] is no band (allowed: [lowest, highest] in rad/s)"),
        ({"band_rad_s": [12, 0.5]}, "band_rad_s: [12, 0.5] is empty"),
        ({"band_rad_s": [0.5, 400]}, "band_rad_s: 400 is out of range (allowed: 0.1 .. 314.15 rad/s)"),
        ({"band_rad_s": [1, 2]}, "band_rad_s: [1.0, 2.0] is too narrow"),
        ({"signal": "multisine", "band_rad_s": [1.0, 1.1]}, "band_rad_s: [1.0, 1.1] holds too few lines"),
        ({"duration": 0.5}, "duration: 0.5 is out of range"),
        ({"duration": "long"}, "duration: 'long' is not a number"),
        ({"fade": 40.0}, "fade: 40.0 is out of range"),
        ({"fade": 10.0, "duration": 15.0}, "fade: 10 is too long (allowed: at most half of the duration)"),
        ({"seed": -1}, "seed: -1 is not allowed"),
        ({"loud": True}, "loud: unknown key (allowed: signal, channel,"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(change: dict[str, object], said: str) -> None:
    with pytest.raises(InputError) as error:
        read_excitation(PRBS | change, file="p.yaml", key="phases[3].excite")
    assert str(error.value).startswith(f"p.yaml: phases[3].excite.{said}")
    assert "\n" not in str(error.value)


def test_half_a_pattern_and_several_equal_channels_are_refused() -> None:
    steps = {"signal": "steps", "channel": "u", "amplitude_m_s": 0.1, "hold": 2.0, "duration": 7.0}
    with pytest.raises(InputError, match=r"duration: 7 is less than one pattern of steps .*at least 8 s"):
        read_excitation(steps)
    both = {k: v for k, v in steps.items() if k != "channel"} | {"channels": ["u", "v"]}
    with pytest.raises(InputError, match="steps would do the same on each of them"):
        read_excitation(both)
    with pytest.raises(InputError, match="amplitudes of different units"):
        read_excitation(both | {"channels": ["u", "B_1s"]})


@pytest.mark.parametrize("text", ["", "prbs", "[1, 2]", "{signal: [}", "x" * 500])
def test_a_request_that_is_no_mapping_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"^excite: "):
        excitation_from_text(text)


def test_a_request_in_words() -> None:
    text = "{signal: doublets, channel: r, amplitude_deg_s: 10, hold: 0.5, duration: 4, fade: 0}"
    excitation = excitation_from_text(text)
    assert excitation.amplitude == np.radians(10.0)
    assert np.isclose(samples(excitation)[0, CHANNELS.index("r")], np.radians(10.0))
