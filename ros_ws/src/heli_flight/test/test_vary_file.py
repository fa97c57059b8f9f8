"""Vary files: what is read, what is refused, and that every flight is drawn from seed and number alone."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_common.quantities import Quantity
from heli_flight.campaign_draws import cell_values, check_campaign, draw
from heli_flight.distributions import Distribution, read_distribution
from heli_flight.parameter_file import read_parameters
from heli_flight.plan import load_plan, parse_plan
from heli_flight.vary_file import parse_vary

PLAN = load_plan("campaign_hover")
ALL = """
seed: 7
controller: {choice: [lq, ncf2]}
room: {choice: [still, gusty]}
wind_m_s: {uniform: [0.0, 3.0]}
parameters:
  bench_sim:
    helicopter.mass: {normal: [1.0, 0.03], times_default: true}
  position_controller:
    gain_x: {log_uniform: [1.5, 2.5]}
faults:
  - {kind: imu_dropout, at_s: 16.0, for_s: 0.2, probability: 0.3}
success: {max_xy_m: 0.3}
"""


def test_everything_is_drawn_within_its_range() -> None:
    vary = parse_vary(ALL)
    flights = [draw(PLAN, vary, number) for number in range(300)]
    assert vary.names == (
        "controller",
        "room",
        "wind_m_s",
        "bench_sim.helicopter.mass",
        "position_controller.gain_x",
    )
    winds = np.array([flight.varied["wind_m_s"] for flight in flights])
    assert 0.0 <= winds.min() < 0.1 and 2.9 < winds.max() <= 3.0
    assert all(flight.plan.phases[3].wind == flight.varied["wind_m_s"] for flight in flights)
    masses = np.array([flight.varied["bench_sim.helicopter.mass"] for flight in flights]) / 7.3
    assert np.mean(masses) == pytest.approx(1.0, abs=0.006) and np.std(masses) == pytest.approx(
        0.03, rel=0.15
    )
    gains = [flight.parameters["position_controller"]["gain_x"] for flight in flights]
    assert np.mean(np.log(gains)) == pytest.approx(0.5 * math.log(1.5 * 2.5), abs=0.05)
    assert 60 < sum(bool(flight.faults) for flight in flights) < 120
    assert {flight.plan.controller for flight in flights} == {"lq", "ncf2"}
    assert {flight.plan.room for flight in flights} == {"still", "gusty"}
    assert len({flight.plan.seed for flight in flights}) == 300


def test_one_more_name_changes_no_other_draw() -> None:
    vary = parse_vary(ALL)
    less = parse_vary(
        ALL.replace("    gain_x: {log_uniform: [1.5, 2.5]}\n", "    gain_y: {uniform: [1.5, 2.5]}\n")
    )
    for number in (0, 5):
        one, other = draw(PLAN, vary, number), draw(PLAN, less, number)
        assert one.plan == other.plan
        assert one.varied["bench_sim.helicopter.mass"] == other.varied["bench_sim.helicopter.mass"]


def test_a_grid_is_gone_through_with_the_same_draws() -> None:
    vary = parse_vary(
        "grid: {wind_m_s: [0.0, 2.0], controller: [lq, ncf2]}\nparameters: {bench_sim: "
        "{helicopter.mass: {uniform: [7.0, 8.0]}}}"
    )
    assert vary.cells == 4
    assert [cell_values(vary, cell) for cell in range(4)] == [
        {"wind_m_s": wind, "controller": name} for wind in (0.0, 2.0) for name in ("lq", "ncf2")
    ]
    flights = [draw(PLAN, vary, number) for number in range(8)]
    assert len({flight.plan.seed for flight in flights[:4]}) == 1
    assert len({flight.varied["bench_sim.helicopter.mass"] for flight in flights[4:]}) == 1
    assert flights[0].plan.seed != flights[4].plan.seed
    assert [flight.plan.controller for flight in flights[:4]] == ["lq", "ncf2"] * 2


def test_plan_and_parameters_of_a_flight_read_back_exactly(tmp_path) -> None:  # type: ignore[no-untyped-def]
    drawn = draw(PLAN, parse_vary(ALL), 3)
    assert parse_plan(drawn.plan.to_yaml()) == drawn.plan
    (tmp_path / "p.yaml").write_text(drawn.parameter_file)
    read = read_parameters(tmp_path / "p.yaml")
    from heli_control.position_control import PositionParameters

    built = read.build("position_controller", PositionParameters)
    assert built.gain_x == drawn.varied["position_controller.gain_x"]
    (tmp_path / "q.yaml").write_text(draw(PLAN, parse_vary("seed: 1"), 0).parameter_file)
    read_parameters(tmp_path / "q.yaml")


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from(["uniform", "log_uniform", "normal"]),
    st.floats(0.1, 5.0),
    st.floats(0.0, 5.0),
    st.integers(0, 1000),
)
def test_a_number_never_leaves_its_range(kind: str, first: float, more: float, seed: int) -> None:
    drawn = Distribution(kind, (first, first + more), 1.0, 0.5, 4.0)
    assert 0.5 <= drawn.draw(np.random.default_rng(seed)) <= 4.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("colour: red", "v.yaml: colour: unknown key"),
        ("seed: -1", "v.yaml: seed: -1 is not allowed (allowed: an integer 0"),
        ("wind_m_s: 3", "v.yaml: wind_m_s: 3 is no distribution (allowed: {uniform: [a, b]}"),
        (
            "wind_m_s: {uniform: [0, 9]}",
            "v.yaml: wind_m_s.uniform[1]: 9.0 is out of range (allowed: 0",
        ),
        (
            "wind_m_s: {uniform: [3, 1]}",
            "v.yaml: wind_m_s.uniform: [3.0, 1.0] (allowed: the lower number first)",
        ),
        ("wind_m_s: {uniform: [3]}", "v.yaml: wind_m_s.uniform: [3] (allowed: two numbers)"),
        ("wind_m_s: {gauss: [3, 1]}", "v.yaml: wind_m_s.gauss: unknown key (allowed: uniform"),
        ("wind_m_s: {normal: [3, -1]}", "v.yaml: wind_m_s.normal[1]: -1.0 (allowed: 0 or more)"),
        ("wind_m_s: {log_uniform: [0, 1]}", "v.yaml: wind_m_s.log_uniform[0]: 0.0 (allowed: above 0)"),
        ("room: {choice: [attic]}", "v.yaml: room.choice[0]: 'attic' is no room (allowed: still, gusty)"),
        ("controller: {choice: [nobody]}", "v.yaml: controller.choice[0]: "),
        ("controller: lq", "v.yaml: controller: 'lq' is no choice (allowed: {choice"),
        ("parameters: {cook: {}}", "v.yaml: parameters.cook: unknown key (allowed: bench_sim"),
        (
            "parameters: {bench_sim: {mass: {choice: [1]}}}",
            "v.yaml: parameters.bench_sim.mass: unknown parameter",
        ),
        ("faults: {}", "v.yaml: faults: {} is no list of faults"),
        (
            "faults: [{kind: imu_dropout, at_s: 1.0, probability: 2.0}]",
            "v.yaml: faults[0].probability: 2.0 is out of range (allowed: 0 .. 1)",
        ),
        ("grid: {wind_m_s: 3}", "v.yaml: grid.wind_m_s: 3 is no list of values"),
        ("grid: {wind_m_s: [3, 11]}", "v.yaml: grid.wind_m_s[1]: 11 is out of range"),
        ("grid: {wind_m_s: [1]}\nwind_m_s: {choice: [1]}", "v.yaml: grid.wind_m_s: is drawn, too"),
        ("success: {max_xy_m: -1}", "v.yaml: success.max_xy_m: -1 is out of range"),
    ],
)
def test_bad_files_are_refused_by_file_key_value_and_what_is_allowed(text: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        parse_vary(text, "v.yaml")
    assert str(error.value).startswith(said)


def test_what_does_not_fit_the_plan_is_refused() -> None:
    with pytest.raises(InputError, match=r"wind_m_s: varied, but plan .* has wind of its own"):
        check_campaign(load_plan("gusty_hover"), parse_vary("wind_m_s: {choice: [1.0]}"))
    with pytest.raises(InputError, match="controller: varied, but plan switching has 5"):
        check_campaign(load_plan("switching"), parse_vary("controller: {choice: [lq]}"))
    late = parse_vary("faults: [{kind: imu_dropout, at_s: 100.0}]")
    with pytest.raises(InputError, match="100 is after the flight"):
        check_campaign(replace(PLAN), late)


def test_a_factor_on_the_default_is_held_to_the_parameters_range() -> None:
    about = Quantity("kg", "D", "mass", 1.0, 10.0)
    found = read_distribution({"uniform": [0.5, 1.2], "times_default": True}, about, 8.0, None, "m")
    assert found.factor == 8.0
    with pytest.raises(InputError, match=r"m.uniform\[1\]: 10.4 is out of range"):
        read_distribution({"uniform": [0.5, 1.3], "times_default": True}, about, 8.0, None, "m")
