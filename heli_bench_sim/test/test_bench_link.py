"""Serial link: dead time, order, nothing lost."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heli_bench_sim.link import CABLE, WIRELESS, DelayLine, LinkParameters

MS = 1_000_000
CONTROL = 10 * MS


def test_cable_and_wireless() -> None:
    assert (CABLE.dead_time_ns, WIRELESS.dead_time_ns) == (0, 100 * MS)
    assert LinkParameters() == CABLE
    assert LinkParameters(dead_time=0.0123).dead_time_ns == 12_300_000


def test_by_hand_without_dead_time() -> None:
    line = DelayLine()
    line.send(0, (1.0,))
    assert line.take(-1) is None
    assert line.take(0) == (1.0,)
    assert line.take(0) is None
    line.send(10, (2.0,))
    line.send(20, (3.0,))
    line.send(30, (4.0,))
    assert line.take(20) == (3.0,)
    assert line.take(30) == (4.0,)
    assert len(line) == 0


def test_by_hand_with_dead_time() -> None:
    line = DelayLine(100 * MS)
    for command in range(13):
        line.send(command * CONTROL, (float(command),))
    assert line.take(100 * MS - 1) is None
    assert line.take(100 * MS) == (0.0,)
    assert line.take(115 * MS) == (1.0,)
    assert line.take(10**9) == (12.0,)


def test_a_command_that_comes_too_late_is_superseded() -> None:
    line = DelayLine()
    line.send(20, (2.0,))
    assert line.take(20) == (2.0,)
    line.send(10, (1.0,))
    line.send(20, (2.5,))
    assert line.take(100) is None
    line.send(40, (4.0,))
    line.send(30, (3.0,))
    line.send(40, (4.5,))
    assert line.take(30) == (3.0,)
    assert line.take(40) == (4.5,)


def test_dead_time_that_rises_and_falls() -> None:
    line = DelayLine()
    line.send(0, (0.0,))
    assert line.take(0) == (0.0,)
    line.set_dead_time(50)
    line.send(10, (1.0,))
    line.send(20, (2.0,))
    assert line.take(59) is None
    assert line.take(60) == (1.0,)
    line.set_dead_time(0)
    assert line.take(60) == (2.0,)
    assert line.dead_time_ns == 0


def test_clear_forgets_what_is_under_way_and_nothing_older_comes_back() -> None:
    line = DelayLine(5)
    line.send(10, (1.0,))
    line.send(20, (2.0,))
    assert line.take(15) == (1.0,)
    line.clear()
    assert line.take(1000) is None
    line.send(10, (1.0,))
    assert len(line) == 0
    line.send(30, (3.0,))
    assert line.take(35) == (3.0,)


def test_negative_dead_time_is_refused() -> None:
    with pytest.raises(ValueError, match="-1 ns"):
        DelayLine(-1)


STAMPS = st.lists(st.integers(0, 200), unique=True, max_size=30).map(sorted)


@given(STAMPS, st.integers(0, 100))
def test_nothing_is_lost_and_order_is_kept(stamps: list[int], dead_time: int) -> None:
    """Asked at every instant, the line gives each command once, in order, the dead time after its stamp."""
    line, out = DelayLine(dead_time), []
    for instant in range(301):
        if instant in stamps:
            line.send(instant, (float(instant),))
        if (values := line.take(instant)) is not None:
            out.append((instant, values[0]))
    assert out == [(stamp + dead_time, stamp) for stamp in stamps]


@given(st.permutations(range(12)), st.integers(0, 30), st.lists(st.integers(0, 60), max_size=8).map(sorted))
def test_what_is_taken_depends_on_stamps_alone(order: list[int], dead_time: int, asked: list[int]) -> None:
    """In whatever order commands come, each question is answered by the newest command that was due."""
    line = DelayLine(dead_time)
    for stamp in order:
        line.send(stamp, (float(stamp),))
    newest = -1
    for due in asked:
        arrived = min(11, due - dead_time)
        expected = (float(arrived),) if arrived > newest else None
        newest = max(newest, arrived)
        assert line.take(due) == expected


CALLS = st.lists(
    st.one_of(
        st.tuples(st.just("send"), st.integers(0, 100)),
        st.tuples(st.just("take"), st.integers(0, 200)),
        st.tuples(st.just("dead"), st.integers(0, 100)),
    ),
    max_size=40,
)


@given(CALLS)
def test_whatever_happens_commands_never_go_back(calls: list[tuple[str, int]]) -> None:
    line, sent, last = DelayLine(), set(), -1
    for call, number in calls:
        if call == "send":
            line.send(number, (float(number),))
            sent.add(number)
        elif call == "dead":
            line.set_dead_time(number)
        else:
            waiting = {stamp for stamp in sent if last < stamp <= number - line.dead_time_ns}
            values = line.take(number)
            assert values == ((float(max(waiting)),) if waiting else None)
            if values is not None:
                last = int(values[0])
                sent = {stamp for stamp in sent if stamp > last}
