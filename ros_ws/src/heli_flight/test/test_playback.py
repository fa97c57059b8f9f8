"""The time of a replay, by hand; keys of a terminal, through a pseudo-terminal; words of the command."""

from __future__ import annotations

import os
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_flight.nodes.keys import Keys
from heli_flight.nodes.replay_node import ros_arguments
from heli_flight.playback import Playback

SECOND = 1_000_000_000


def test_time_runs_rests_and_changes_its_rate() -> None:
    play = Playback(5 * SECOND, rate=2.0)
    assert play.position_ns(100.0) == 5 * SECOND and play.wait(5 * SECOND, 100.0) == inf
    play.begin(100.0)
    assert play.position_ns(101.0) == 7 * SECOND and play.wait(9 * SECOND, 101.0) == 1.0
    assert play.wait(6 * SECOND, 101.0) == 0.0
    play.pause(102.0)
    assert play.paused and play.position_ns(110.0) == 9 * SECOND and play.wait(9 * SECOND, 110.0) == inf
    play.set_rate(0.5, 111.0)
    play.resume(120.0)
    play.resume(121.0)
    assert play.position_ns(122.0) == 10 * SECOND and play.wait(11 * SECOND, 122.0) == 2.0
    play.skip_to(20 * SECOND, 123.0)
    assert play.position_ns(125.0) == 21 * SECOND
    play.begin(200.0)
    assert play.position_ns(125.0) == 21 * SECOND


@given(st.lists(st.tuples(st.sampled_from(("pause", "resume", "slower")), st.floats(0.01, 5.0)), max_size=20))
def test_time_never_jumps(steps: list[tuple[str, float]]) -> None:
    play, now = Playback(0, 1.0), 0.0
    play.begin(now)
    for what, length in steps:
        before = play.position_ns(now)
        if what == "slower":
            play.set_rate(max(0.01, play.rate / 2), now)
        else:
            getattr(play, what)(now)
        assert play.position_ns(now) == pytest.approx(before)
        now += length
        gone = 0.0 if play.paused else length * play.rate
        assert play.position_ns(now) == pytest.approx(before + gone * 1e9)


@pytest.mark.parametrize("rate", [0.0, -1.0, 101.0, float("nan"), True, "fast"])
def test_a_rate_out_of_range_is_refused(rate: float) -> None:
    with pytest.raises(InputError, match="rate"):
        Playback(0, rate)
    play = Playback(0)
    with pytest.raises(InputError, match="rate"):
        play.set_rate(rate, 1.0)
    assert play.rate == 1.0


def test_keys_of_a_terminal() -> None:
    ours, theirs = os.openpty()
    keys = Keys(theirs)
    assert keys.open and keys.pressed() == []
    os.write(ours, b" \x1b[C\x1b[Ax")
    assert keys.pressed() == [" ", "right", "up", "x"]
    keys.close()
    assert not keys.open and keys.pressed() == []
    os.close(ours)
    os.close(theirs)


def test_no_terminal_no_keys() -> None:
    read, write = os.pipe()
    assert not Keys(read).open
    os.close(read)
    os.close(write)


def test_words_become_parameters() -> None:
    words = [
        "bag",
        "--rate",
        "2",
        "--start-offset",
        "3.5",
        "--topics",
        "imu,rotor",
        "--start-paused",
        "--running",
        "navigation",
    ]
    found = ros_arguments([*words, "--running", "navigation", "--ros-args", "-r", "__ns:=/a"])
    given = dict(word.split(":=", 1) for word in found if ":=" in word)
    assert given == {
        "bag": "'bag'",
        "topics": "'imu,rotor'",
        "running": "'replay,navigation'",
        "rate": "2",
        "start_offset": "3.5",
        "start_paused": "true",
        "__ns": "/a",
    }
    assert ros_arguments([]) == []
    assert ros_arguments(["--ros-args", "-p", "bag:=x"]) == ["--ros-args", "-p", "bag:=x"]
    with pytest.raises(SystemExit):
        ros_arguments(["--speed", "1"])
