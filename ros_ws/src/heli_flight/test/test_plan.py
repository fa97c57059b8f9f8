"""Plans: what is shipped flies inside the work space, and every mistake in a file is named in one line."""

from __future__ import annotations

from math import radians
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_flight.plan import (
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
)

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


def seconds(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda value: round(value, 3))


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
    take_off=st.builds(TakeOff, seconds(-0.4, 0.3), seconds(0.02, 0.5)),
)
def test_round_trip(about: str, seed: int, middle: list[Step | Hover], take_off: TakeOff) -> None:
    phases = (Home(9.0), RunUp(), take_off, *middle, Land(), RunDown(4.0))
    plan = Plan("round_trip", about, seed, "./some controller.yaml", phases)
    try:
        again = parse_plan(plan.to_yaml())
    except InputError as error:
        assume("takes the reference" not in str(error))
        raise
    assert again == plan
