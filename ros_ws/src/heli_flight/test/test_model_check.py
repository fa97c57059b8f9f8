"""The model against the source's tables: what is met, what is not, and that the verdict can fail."""

import argparse
import dataclasses
import json
import math
import struct
from pathlib import Path

import pytest

from heli_bench_sim.arm_friction import NO_ARM_FRICTION
from heli_bench_sim.parameters import PARAMETER_SETS, thesis
from heli_bench_sim.reference_results import REFERENCES, SCALES, Departure, Reference
from heli_bench_sim.states import INPUT_NAMES, STATE_NAMES
from heli_common.errors import InputError
from heli_flight.cli import model_check as command
from heli_flight.model_check import (
    NOT_REPRODUCED,
    NOT_SCORED,
    REPRODUCED,
    ModelCheck,
    Row,
    check_model,
    judge,
)

CHECKS = {name: check_model(parameters(), name) for name, parameters in PARAMETER_SETS.items()}
FIGURES = {f"figure_2_{number}" for number in (12, 13, 14, 15, 16, 17)}


def row(check: ModelCheck, table: str, key: str) -> Row:
    (found,) = (each for each in check.rows if (each.table, each.key) == (table, key))
    return found


def run(*arguments: str) -> int:
    parser = argparse.ArgumentParser(prog="heli model")
    command.add_job(parser.add_subparsers(required=True))
    options = parser.parse_args(["check", *arguments])
    return int(options.func(options))


# Data ------------------------------------------------------------------------------------------------------


def test_every_reference_is_one_row_and_says_its_unit() -> None:
    keys = [(each.table, each.key) for each in REFERENCES]
    assert len(set(keys)) == len(keys)
    assert [each.table for each in REFERENCES] == sorted(each.table for each in REFERENCES)
    for each in REFERENCES:
        assert each.unit and each.text
        assert each.scored or each.note, f"{each.key} is not scored and does not say why"
        assert each.published is not None or each.rebuilt
        assert all(departure.up_to > (each.tolerance or 0.0) for departure in each.departures.values())


def test_everything_has_a_scale() -> None:
    assert set(SCALES) == {*STATE_NAMES, *INPUT_NAMES}


# Verdicts on the shipped sets ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", PARAMETER_SETS)
def test_nothing_is_missed_without_a_reason(name: str) -> None:
    check = CHECKS[name]
    assert check.unexplained == ()
    assert len(check.rows) == len(REFERENCES)
    for each in check.rows:
        assert math.isfinite(each.ours)
        assert each.verdict == REPRODUCED or each.reason


def test_the_thesis_set_meets_hover_fast_poles_and_derivatives() -> None:
    check = CHECKS["thesis"]
    for each in check.rows:
        if each.table == "2.3" or (each.table == "2.6" and each.verdict != NOT_SCORED):
            assert each.verdict == REPRODUCED, each
    for key in ("roll.real", "roll.imag", "pitch.real", "pitch.imag", "unstable_poles", "yaw"):
        assert row(check, "2.5", key).verdict == REPRODUCED
    assert row(check, "2.3", "theta_0").ours == pytest.approx(9.689, abs=5e-4)
    assert row(check, "2.6", "L_b").to_published == pytest.approx(-0.13, abs=0.01)


@pytest.mark.parametrize("name", PARAMETER_SETS)
def test_what_cannot_be_had_is_told(name: str) -> None:
    missed = {each.key: each.reason for each in CHECKS[name].rows if each.verdict == NOT_REPRODUCED}
    assert {"heave", "inflow_slow", "inflow_fast", "zeros", "damped.real"} <= set(missed)
    assert "0.15 and 0.10 s" in missed["inflow_slow"]
    assert "Y_v" in missed["damped.real"]
    if name == "thesis":
        assert set(missed) == {
            "heave",
            "inflow_slow",
            "inflow_fast",
            "zeros",
            "damped.real",
            "unstable.real",
        }


def test_drive_and_speed_derivatives_are_listed_only() -> None:
    check = CHECKS["thesis"]
    assert row(check, "2.2", "T_a").verdict == REPRODUCED
    for table, key, words in (
        ("2.2", "T_a_appendix", "conflict"),
        ("2.2", "k_a", "not printed"),
        ("2.6", "M_u", "scrambled"),
        ("2.6", "Y_v", "uncertain"),
        ("2.1", "plate_to_blade", "inside the measured range"),
    ):
        found = row(check, table, key)
        assert found.verdict == NOT_SCORED
        assert words in found.reason
    assert row(check, "2.2", "k_L").ours == pytest.approx(1.0, abs=1e-9)
    parameters = thesis()
    back = -(parameters.torque_constant**2) * parameters.motor_gear / parameters.armature_resistance
    assert row(check, "2.2", "k_Omega").ours == pytest.approx(back, rel=1e-6)


def test_rig_friction_makes_the_identified_speed_damping() -> None:
    assert row(CHECKS["thesis"], "2.6", "X_u.rig").to_published == pytest.approx(0.0, abs=5e-3)
    bare = check_model(thesis(), "thesis", NO_ARM_FRICTION)
    assert row(bare, "2.6", "X_u.rig").ours == row(bare, "2.6", "X_u").ours


# The verdict can fail --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "missed"),
    [
        ({"mass": 7.4}, {"theta_0", "V_i"}),
        ({"inertia_yy": 0.24}, {"M_q", "M_a", "pitch.real"}),
        ({"lift_slope": 5.1}, {"theta_0"}),
        ({"speed_flapping": 0.6}, {"unstable.real"}),
        ({"inflow_time": 0.16}, {"inflow_slow"}),
        ({"bar_to_blade": 0.56}, {"bar_to_blade", "M_a", "L_b"}),
        ({"tail_x": -0.9}, {"theta_t", "M_A"}),
    ],
)
def test_another_helicopter_is_told(change: dict[str, float], missed: set[str]) -> None:
    check = check_model(dataclasses.replace(thesis(), **change), "thesis")
    found = {each.key for each in check.unexplained}
    assert missed <= found, found
    for each in check.unexplained:
        assert "is missed by" in each.reason


def test_the_wrong_name_for_a_set_is_told() -> None:
    assert check_model(PARAMETER_SETS["physical_tail"](), "thesis").unexplained


NUMBER = Reference(
    "9.9",
    "n",
    "a number",
    "m",
    10.0,
    1.0,
    {"thesis": 12.0},
    0.5,
    departures={"thesis": Departure("known", 2.4)},
)


@pytest.mark.parametrize(
    ("reference", "ours", "verdict", "explained", "words"),
    [
        (NUMBER, 12.1, NOT_REPRODUCED, True, "known"),
        (NUMBER, 12.45, NOT_REPRODUCED, False, "print is missed by 2.45 m, reason unknown"),
        (NUMBER, 10.0, NOT_REPRODUCED, False, "the rebuilt value is missed by -2 m"),
        (dataclasses.replace(NUMBER, departures={}), 12.0, NOT_REPRODUCED, False, "print is missed by 2 m"),
        (dataclasses.replace(NUMBER, rebuilt={}), 10.9, REPRODUCED, True, ""),
        (dataclasses.replace(NUMBER, rebuilt={"thesis": 10.5}), 10.9, REPRODUCED, True, ""),
        (dataclasses.replace(NUMBER, tolerance=None, note="why"), 12.0, NOT_SCORED, True, "why"),
        (dataclasses.replace(NUMBER, tolerance=None, note="why"), 14.0, NOT_SCORED, False, "rebuilt value"),
        (dataclasses.replace(NUMBER, published=None, note="why"), 12.0, NOT_SCORED, True, "why"),
        (NUMBER, math.nan, NOT_REPRODUCED, False, "missed"),
    ],
)
def test_verdict(reference: Reference, ours: float, verdict: str, explained: bool, words: str) -> None:
    found = judge(reference, ours, "thesis")
    assert (found.verdict, found.explained) == (verdict, explained)
    assert words in found.reason
    assert bool(found.reason) == bool(words)


# The command -----------------------------------------------------------------------------------------------


def test_json_and_figures_the_same_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "deep" / "figures"
    assert run("--json", "--parameters", "physical_tail", "--out", str(folder)) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["parameters"] == "physical_tail"
    assert told["unexplained"] == []
    counted = told["reproduced"] + told["not_reproduced"] + told["not_scored"]
    assert counted == len(told["rows"]) == len(REFERENCES)
    assert {field.name for field in dataclasses.fields(Row)} == set(told["rows"][0])
    paths = [Path(path) for path in told["figures"]]
    assert {path.name[:11] for path in paths} == FIGURES
    for path in paths:
        content = path.read_bytes()
        width, height = struct.unpack(">II", content[16:24])
        assert content.startswith(b"\x89PNG") and width > 1000 and height > 400
        assert len(content) > 20_000
    run("--json", "--parameters", "physical_tail", "--out", str(tmp_path / "again"))
    for path in paths:
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes()


def test_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run() == 0
    text = capsys.readouterr().out
    for words in ("Table 2.1", "Table 2.6", "M_q [1/s]", "609.11", "608.98", "not reproduced, ", "listed, "):
        assert words in text
    assert "0 missed without a known reason" in text
    assert "…" not in text, "a number was cut off"


def test_a_missed_number_is_an_exit_code(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    heavy = {"thesis": lambda: dataclasses.replace(thesis(), mass=7.4)}
    monkeypatch.setattr(command, "PARAMETER_SETS", heavy)
    assert run() == command.EXIT_UNEXPLAINED
    assert "MISSED" in capsys.readouterr().out


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write figures"):
        run("--json", "--out", str(tmp_path / "file" / "figures"))
