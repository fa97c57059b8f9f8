"""Plans: what is shipped flies inside the work space, and every mistake in a file is named in one line."""

from __future__ import annotations

import math
from dataclasses import replace
from math import radians
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heli_bench_sim.faults import EncoderStuck, Fault, ImuBiasJump, LinkDelay
from heli_common.errors import InputError
from heli_flight.plan import (
    Excite,
    Home,
    Hover,
    Land,
    Plan,
    RunDown,
    RunUp,
    Step,
    TakeOff,
    load_plan,
    parse_plan,
    shipped_plans,
    wind_command,
)
from heli_identification.excitation_words import excitations_from_text

GOOD = """\
name: test
about: A plan for tests.
seed: 3
controller: lq
phases:
  - home: {}
  - run_up: {duration: 5}
  - take_off: {height: 0.1, speed: 0.2}
  - hover: {duration: 4.0}
  - step: {axis: x, amplitude: 0.3}
  - step: {axis: psi, amplitude_deg: -20, duration: 2.5}
  - land:
  - run_down: {}
"""


def test_a_good_plan() -> None:
    plan = parse_plan(GOOD)
    assert plan == Plan(
        "test",
        "A plan for tests.",
        3,
        "lq",
        (
            Home(8.0),
            RunUp(5.0),
            TakeOff(0.1, 0.2),
            Hover(4.0),
            Step("x", 0.3, 6.0),
            Step("psi", radians(-20.0), 2.5),
            Land(0.12),
            RunDown(3.0),
        ),
    )


def test_duration() -> None:
    climb, descent = 0.55 / 0.2 + 3.0, 0.55 / 0.12
    assert parse_plan(GOOD).duration == pytest.approx(8 + 5 + climb + 4 + 6 + 2.5 + descent + 3)
    lower = GOOD.replace("axis: x, amplitude: 0.3", "axis: z, amplitude: 0.2")
    assert parse_plan(lower).duration == pytest.approx(parse_plan(GOOD).duration - 0.2 / 0.12)


def test_shipped_plans() -> None:
    assert {"hover_steps", "short_hover"} <= set(shipped_plans())
    for name in shipped_plans():
        plan = load_plan(name)
        assert plan.name == name
        assert parse_plan(plan.to_yaml()) == plan
    steps = [p for p in load_plan("hover_steps").phases if isinstance(p, Step)]
    assert [(p.axis, p.amplitude, p.duration) for p in steps] == [
        ("x", 0.3, 6.0),
        ("x", -0.3, 6.0),
        ("y", 0.3, 6.0),
        ("y", -0.3, 6.0),
    ]
    assert load_plan("short_hover").duration < 40.0


def test_a_plan_by_path(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(GOOD)
    assert load_plan(path) == load_plan(str(path)) == parse_plan(GOOD)


def test_an_unknown_plan_lists_the_shipped_ones(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'hover_step': unknown.*hover_steps"):
        load_plan("hover_step")
    with pytest.raises(InputError, match=r"no such file"):
        load_plan(tmp_path / "nothing.yaml")
    with pytest.raises(InputError, match=r"no such file"):
        load_plan(tmp_path)


MISTAKES = [
    ("seed: 3", "seed: 3\nsede: 4", "sede", "unknown key"),
    ("seed: 3", "seed: 3\nseed: 4", "", "line 4: key 'seed' stands twice"),
    ("seed: 3", "seed: -1", "seed", "-1"),
    ("seed: 3", "seed: 1.5", "seed", "1.5"),
    ("seed: 3", "seed: true", "seed", "True"),
    ("seed: 3\n", "", "seed", "None"),
    ("name: test", "name: ../test", "name", "../test"),
    ("name: test", "name: 5", "name", "5"),
    ("name: test\n", "", "name", "None"),
    ("about: A plan for tests.", "about: ''", "about", "''"),
    ("controller: lq", "controller: [lq]", "controller", "['lq']"),
    ("phases:", "phases: 5\nother:", "other", "unknown key"),
    ("  - home: {}\n", "", "phases", "home is missing"),
    ("  - land:\n", "", "phases", "land is missing"),
    ("  - home: {}\n", "  - home: {}\n  - home: {}\n", "phases", "home occurs 2 times"),
    ("  - home: {}\n  - run_up: {duration: 5}\n", "  - run_up: {}\n  - home: {}\n", "phases[0]", "run_up"),
    ("  - land:\n  - run_down: {}\n", "  - run_down: {}\n  - land: {}\n", "phases[6]", "run_down"),
    ("  - hover: {duration: 4.0}\n", "", None, None),
    ("hover: {duration: 4.0}", "hover: {duration: 4.0, height: 1}", "phases[3].hover.height", "unknown key"),
    ("hover: {duration: 4.0}", "hover: {duration: long}", "phases[3].hover.duration", "'long'"),
    ("hover: {duration: 4.0}", "hover: {duration: .inf}", "phases[3].hover.duration", "inf"),
    ("hover: {duration: 4.0}", "hover: {duration: .nan}", "phases[3].hover.duration", "nan"),
    ("hover: {duration: 4.0}", "hover: {duration: -4.0}", "phases[3].hover.duration", "-4.0"),
    ("hover: {duration: 4.0}", "hover: {duration: true}", "phases[3].hover.duration", "True"),
    ("hover: {duration: 4.0}", "hover: 4.0", "phases[3].hover", "4.0 is no mapping"),
    ("hover: {duration: 4.0}", "hover: {duration: 4.0, duration: 5.0}", "", "stands twice"),
    ("hover: {duration: 4.0}", "hoover: {duration: 4.0}", "phases[3]", "'hoover'"),
    ("- hover: {duration: 4.0}", "- hover", "phases[3]", "'hover' is no phase"),
    ("- hover: {duration: 4.0}", "- {hover: {}, land: {}}", "phases[3]", "is no phase"),
    ("height: 0.1", "height: 0.5", "phases[2].take_off.height", "0.5"),
    ("axis: x", "axis: w", "phases[4].step.axis", "'w'"),
    ("axis: x, ", "", "phases[4].step.axis", "None"),
    ("axis: x, amplitude: 0.3", "axis: x", "phases[4].step.amplitude", "None"),
    ("axis: x, amplitude: 0.3", "axis: x, amplitude_deg: 3", "phases[4].step.amplitude_deg", "unknown key"),
    ("amplitude: 0.3", "amplitude: 0.001", "phases[4].step.amplitude", "too small"),
    ("amplitude: 0.3", "amplitude: 0.46", "phases[4].step", "0.46 m from the axis"),
    ("axis: x, amplitude: 0.3", "axis: z, amplitude: -0.3", "phases[4].step", "height 0.40 m"),
    ("axis: x, amplitude: 0.3", "axis: z, amplitude: 0.6", "phases[4].step", "height -0.50 m"),
    ("amplitude_deg: -20", "amplitude_deg: -130", "phases[5].step", "-130.0 deg"),
    ("amplitude_deg: -20", "amplitude: -0.3", "phases[5].step.amplitude", "unknown key"),
    ("duration: 4.0", "duration: 4.0, wind_m_s: 9", "phases[3].hover.wind_m_s", "9 is out of range"),
    ("duration: 4.0", "duration: 4.0, wind_m_s: -1", "phases[3].hover.wind_m_s", "0 .. 8 m/s"),
    ("duration: 4.0", "duration: 4.0, wind_m_s: ", "phases[3].hover.wind_m_s", "None is not a number"),
    ("duration: 4.0", "wind_to_m_s: .inf", "phases[3].hover.wind_to_m_s", "inf"),
    ("duration: 4.0", "wind: 3", "phases[3].hover.wind", "duration, wind_m_s, wind_to_m_s"),
    ("speed: 0.2", "wind_to_m_s: 3", "phases[2].take_off.wind_to_m_s", "height, speed, wind_m_s"),
    ("axis: x", "axis: x, wind: 3", "phases[4].step.wind", "amplitude, duration, wind_m_s, wind_to_m_s"),
    ("axis: x", "axis: x, wind_m_s: 8.1", "phases[4].step.wind_m_s", "8.1 is out of range"),
    ("seed: 3", "seed: 3\nwind: 4", "wind", "unknown key"),
    ("seed: 3", "seed: 3\nroom: windy", "room", "'windy' is no room (allowed: still, gusty)"),
    ("seed: 3", "seed: 3\nroom: [still]", "room", "['still'] is no room"),
    ("seed: 3", "seed: 3\nroom:", "room", "None is no room"),
    ("seed: 3", "seed: 3\nfaults:", "faults", "None is no list of faults"),
    ("seed: 3", "seed: 3\nfaults: [imu_dropout]", "faults[0]", "'imu_dropout' is no fault"),
    ("seed: 3", "seed: 3\nfaults: [{kind: imu_drop, at_s: 1}]", "faults[0].kind", "'imu_drop' is unknown"),
    ("seed: 3", "seed: 3\nfaults: [{kind: imu_dropout, at: 1}]", "faults[0].at_s", "is missing"),
    (
        "seed: 3",
        "seed: 3\nfaults: [{kind: imu_dropout, at_s: 1}, {kind: imu_dropout, at_s: 400}]",
        "faults[1].at_s",
        "400 is after the flight",
    ),
    ("seed: 3", "seed: 3\nfaults: [{kind: imu_dropout, at_s: 1, at_s: 2}]", "", "stands twice"),
]


@pytest.mark.parametrize(("before", "after", "key", "words"), MISTAKES)
def test_a_mistake_is_named(before: str, after: str, key: str | None, words: str | None) -> None:
    assert before in GOOD
    text = GOOD.replace(before, after, 1)
    if key is None or words is None:
        parse_plan(text)
        return
    with pytest.raises(InputError) as caught:
        parse_plan(text, "my.yaml")
    message = str(caught.value)
    assert message.startswith(f"my.yaml: {key}: " if key else "my.yaml: ")
    assert words in message and "allowed" in message and "\n" not in message


@pytest.mark.parametrize(
    "text", ["", "# only a comment\n", "- a\n- b\n", "5", "a: [", "a: \x00", "? [a]\n: 1\n"]
)
def test_what_is_no_plan_at_all(text: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_plan(text, "my.yaml")
    assert str(caught.value).startswith("my.yaml: ") and "\n" not in str(caught.value)


def test_a_file_that_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "plan.yaml"
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InputError, match="is no text"):
        load_plan(path)


def test_steps_add_up_to_the_edge_of_the_work_space() -> None:
    step = "  - step: {axis: x, amplitude: 0.3}\n"
    back = "  - step: {axis: x, amplitude: -0.6}\n"
    aside = "  - step: {axis: y, amplitude: 0.4}\n"
    parse_plan(GOOD.replace(step, step + back))
    with pytest.raises(InputError, match=r"phases\[5\]\.step: takes the reference to 0\.50 m"):
        parse_plan(GOOD.replace(step, step + aside))


WINDY = GOOD.replace("duration: 4.0", "duration: 4.0, wind_m_s: 1, wind_to_m_s: 5").replace(
    "axis: x, amplitude: 0.3", "axis: x, amplitude: 0.3, wind_m_s: 2.5"
)


def test_controllers_of_phases() -> None:
    text = GOOD.replace("duration: 4.0", "duration: 4.0, controller: gst").replace(
        "land:", "land: {controller: lq}"
    )
    text = text.replace("amplitude: 0.3}", "amplitude: 0.3, controller: mine/a.yaml}")
    plan = parse_plan(text)
    assert plan.controllers == ("lq", "gst", "mine/a.yaml")
    assert [phase.controller for phase in plan.phases[3:7]] == ["gst", "mine/a.yaml", None, "lq"]
    assert parse_plan(plan.to_yaml()) == plan
    assert parse_plan(GOOD).controllers == ("lq",)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("duration: 4.0", "controller: 3", "phases[3].hover.controller: 3 is no text"),
        ("duration: 4.0", "controller: ''", "phases[3].hover.controller: '' is no text"),
        (
            "amplitude: 0.3",
            "amplitude: 0.3, controller: 'a,b'",
            "phases[4].step.controller: 'a,b' holds a comma",
        ),
        ("controller: lq", "controller: a,b", "controller: 'a,b' holds a comma (allowed: one controller)"),
    ],
)
def test_a_controller_that_is_none(before: str, after: str, words: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_plan(GOOD.replace(before, after))
    assert words in str(refused.value)


def test_wind() -> None:
    plan = parse_plan(WINDY)
    calm = parse_plan(GOOD)
    assert plan.phases[3] == Hover(4.0, wind=1.0, wind_to=5.0)
    assert plan.phases[4] == Step("x", 0.3, 6.0, wind=2.5)
    assert [phase.wind for phase in plan.phases] == [None, None, None, 1.0, 2.5, None, None, None]
    assert [phase.wind for phase in calm.phases] == [None] * 8
    assert plan.duration == calm.duration
    assert parse_plan(plan.to_yaml()) == plan
    assert "wind" not in calm.to_yaml() and "room" not in calm.to_yaml() and "faults" not in calm.to_yaml()


def test_wind_command_by_hand() -> None:
    assert wind_command(Hover(10.0), 3.0, 2.0) == 2.0
    assert wind_command(Land(), 3.0, 2.0) == 2.0
    assert wind_command(TakeOff(wind=4.0), 0.0, 2.0) == 4.0
    assert wind_command(Hover(10.0, wind=4.0), 9.0, 2.0) == 4.0
    up = Hover(10.0, wind_to=5.0)
    assert [wind_command(up, time, 1.0) for time in (0.0, 2.5, 5.0, 10.0, 12.0, math.inf)] == [
        1.0,
        2.0,
        3.0,
        5.0,
        5.0,
        5.0,
    ]
    jump = Step("x", 0.1, 4.0, wind=8.0, wind_to=0.0)
    assert [wind_command(jump, time, 1.0) for time in (0.0, 1.0, 4.0)] == [8.0, 6.0, 0.0]
    assert wind_command(Hover(math.inf), math.inf, 3.0) == 3.0


SPEED = st.floats(0.0, 8.0)


@given(st.none() | SPEED, SPEED, SPEED, st.floats(0.5, 600.0), st.lists(st.floats(0.0, 700.0), min_size=2))
def test_wind_ramps_run_one_way_between_their_ends(
    start: float | None, end: float, before: float, duration: float, times: list[float]
) -> None:
    phase = Hover(duration, wind=start, wind_to=end)
    first = before if start is None else start
    speeds = [wind_command(phase, time, before) for time in sorted(times)]
    assert all(min(first, end) <= speed <= max(first, end) for speed in speeds)
    assert speeds == sorted(speeds, reverse=end < first)


def test_a_room_and_faults() -> None:
    delay = "{kind: link_delay, delay_s: 0.1, at_s: 20}"
    stuck = "{kind: encoder_stuck, encoder: yaw, at_s: 3, for_s: 2}"
    plan = parse_plan(f"{GOOD}room: gusty\nfaults: [{delay}, {stuck}]\n")
    assert (plan.room, parse_plan(GOOD).room) == ("gusty", "still")
    assert plan.faults == (
        LinkDelay(start_ns=20_000_000_000, delay_ns=100_000_000),
        EncoderStuck(start_ns=3_000_000_000, end_ns=5_000_000_000, encoder="yaw"),
    )
    assert parse_plan(GOOD).faults == () == parse_plan(GOOD + "faults: []\n").faults
    assert parse_plan(plan.to_yaml()) == plan
    assert "  - {kind: encoder_stuck, encoder: yaw, at_s: 3.0, for_s: 2.0}\n" in plan.to_yaml()


def test_a_fault_must_begin_before_the_flight_is_over() -> None:
    end = parse_plan(GOOD).duration
    fault = f"{GOOD}faults: [{{kind: imu_dropout, at_s: %r}}]\n"
    assert len(parse_plan(fault % (end - 0.1)).faults) == 1
    with pytest.raises(InputError, match=rf"^my\.yaml: faults\[0\]\.at_s: .* below {end:.1f} s"):
        parse_plan(fault % (end + 0.1), "my.yaml")


def seconds(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda value: round(value, 3))


WIND = st.none() | seconds(0.0, 8.0)
FAULTS: st.SearchStrategy[tuple[Fault, ...]] = st.lists(
    st.sampled_from(
        [
            EncoderStuck(start_ns=0, encoder="roll"),
            LinkDelay(start_ns=7_000_000_001, end_ns=9_000_000_000, delay_ns=2_500_000),
            ImuBiasJump(start_ns=5, axis="gyro_x", size=radians(0.3)),
        ]
    ),
    max_size=3,
).map(tuple)
steps = st.one_of(
    st.builds(Step, st.sampled_from("xyz"), st.sampled_from([-0.2, -0.05, 0.1, 0.15]), seconds(0.5, 600)),
    st.builds(
        Step, st.just("psi"), st.integers(-40, 40).filter(lambda d: abs(d) > 1).map(radians), seconds(1, 9)
    ),
    st.builds(Hover, seconds(0.5, 3600)),
)


@given(
    about=st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=1),
    seed=st.integers(0, 2**32 - 1),
    middle=st.lists(steps, max_size=6),
    winds=st.lists(st.tuples(WIND, WIND), min_size=6, max_size=6),
    take_off=st.builds(TakeOff, seconds(-0.4, 0.3), seconds(0.02, 0.5), wind=WIND),
    room=st.sampled_from(["still", "gusty"]),
    faults=FAULTS,
)
def test_round_trip(
    about: str,
    seed: int,
    middle: list[Step | Hover],
    winds: list[tuple[float | None, float | None]],
    take_off: TakeOff,
    room: str,
    faults: tuple[Fault, ...],
) -> None:
    windy = [
        replace(phase, wind=first, wind_to=last) for phase, (first, last) in zip(middle, winds, strict=False)
    ]
    phases = (Home(9.0), RunUp(wind_to=1.5), take_off, *windy, Land(wind=0.5), RunDown(4.0, wind=0.0))
    plan = Plan("round_trip", about, seed, "./some controller.yaml", phases, room, faults)
    try:
        again = parse_plan(plan.to_yaml())
    except InputError as error:
        assume("takes the reference" not in str(error))
        raise
    assert again == plan


EXCITED = GOOD.replace(
    "  - land:",
    """\
  - excite:
      {signal: prbs, channels: [B_1s, A_1s], amplitude_deg: 0.7, band_rad_s: [0.5, 12], duration: 30, seed: 4}
  - hover: {duration: 2.0}
  - excite: {signal: steps, channel: u, amplitude_m_s: 0.1, hold: 2.0, duration: 10.0, wind_to_m_s: 2.0}
  - land:""",
)


def test_excitations() -> None:
    plan = parse_plan(EXCITED)
    first, second = plan.excitations
    assert first.channels == ("B_1s", "A_1s")
    assert first.amplitude == radians(0.7)
    assert (second.signal, second.hold, second.seed) == ("steps", 2.0, 1)
    assert plan.duration == pytest.approx(parse_plan(GOOD).duration + 30.0 + 2.0 + 10.0)
    assert parse_plan(plan.to_yaml()) == plan
    assert excitations_from_text(plan.excitations_text) == plan.excitations
    assert parse_plan(GOOD).excitations == ()
    phase = plan.phases[-3]
    assert isinstance(phase, Excite)
    assert wind_command(phase, 5.0, 0.0) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("before", "after", "key", "words"),
    [
        ("signal: prbs", "signal: hum", "phases[6].excite.signal", "multisine"),
        ("amplitude_deg: 0.7", "amplitude_deg: 7", "phases[6].excite.amplitude_deg", "0.001 .. 6 deg"),
        ("wind_to_m_s: 2.0", "wind_to_m_s: 20", "phases[8].excite.wind_to_m_s", "0 .. 8 m/s"),
        ("hold: 2.0, ", "", "phases[8].excite.hold", "0.01 .. 60 s"),
        ("hold: 2.0", "hold: 2.0, loud: 1", "phases[8].excite.loud", "unknown key"),
    ],
)
def test_a_mistake_in_an_excitation_is_named(before: str, after: str, key: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_plan(EXCITED.replace(before, after), "p.yaml")
    assert str(caught.value).startswith(f"p.yaml: {key}: ")
    assert words in str(caught.value)


def test_the_identification_flight_has_other_data_for_validation() -> None:
    estimation, validation, *others = load_plan("identification").excitations
    assert estimation.channels == validation.channels == ("B_1s", "A_1s")
    assert estimation.duration == validation.duration == 60.0
    assert estimation.seed != validation.seed
    assert {channel for other in others for channel in other.channels} == {
        "theta_0",
        "theta_t",
        "u",
        "v",
        "motor",
    }
