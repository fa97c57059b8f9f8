"""Flights compared with each other: which are flown, what is said of one that differs."""

import json

import pytest

from heli_flight import verification
from heli_flight.cli.main import main
from heli_flight.mode import Mode
from heli_flight.order import FlightEnd
from heli_flight.verification import REPRODUCIBLE, Flown, Run, differences, runs

PLAN = """
name: brief
about: As short as a flight can be.
seed: 1
controller: lq
phases:
  - home: {duration: 8.0}
  - run_up: {duration: 2.0}
  - take_off: {height: -0.35, speed: 0.3}
  - land: {speed: 0.3}
  - run_down: {duration: 0.5}
"""


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "brief.yaml"
    path.write_text(PLAN)
    return path


def test_each_way_is_flown_so_many_times_and_once_more_under_load():
    assert Mode.REALTIME not in REPRODUCIBLE
    assert len(REPRODUCIBLE) == 3
    ways = [Mode.LOCKSTEP, Mode.INPROCESS]
    assert [str(run) for run in runs(ways, 1, True)] == [
        "lockstep 1",
        "inprocess 1",
        "lockstep 2 under load",
        "inprocess 2 under load",
    ]
    assert not any(run.loaded for run in runs(ways, 3, False))


def test_flights_that_are_the_same_are_said_to_be_and_kept_where_asked(plan, tmp_path, capsys):
    kept = tmp_path / "kept"
    words = ["verify", str(plan), "--modes", "inprocess", "--times", "2", "--no-load", "--json"]
    assert main([*words, "--out", str(kept)]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["same"]
    assert said["differences"] == []
    assert len({flight["sha256"] for flight in said["flights"]}) == 1
    assert {path.name for path in kept.iterdir()} == {"inprocess_1", "inprocess_2"}


def test_the_first_message_that_differs_is_named(plan, tmp_path, capsys):
    flown = []
    for number in (1, 2):
        words = ["fly", str(plan), "--mode", "inprocess", "--seed", str(number), "--no-report", "--json"]
        assert main([*words, "--out", str(tmp_path), "--name", f"b{number}"]) == 0
        said = json.loads(capsys.readouterr().out)
        run = Run(Mode.INPROCESS, number, False)
        flown.append(
            Flown(run, said["simulated_s"], said["wall_s"], said["sha256"], "", tmp_path / f"b{number}")
        )
    assert differences(flown[:1]) == []
    ((other, difference),) = differences(flown)
    assert other is flown[1]
    assert str(difference).startswith("bench_condition at 0.0000 s (message 0): position.gyro_x is -0.0")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--modes", "realtime"], "--modes: 'realtime'"),
        (["--modes", ","], "--modes: none given"),
        (["--times", "0"], "--times: 0"),
        (["--seed", "-1"], "--seed: -1"),
    ],
)
def test_what_cannot_be_verified_is_refused(plan, words, said, capsys):
    assert main(["verify", str(plan), *words]) == 2
    assert said in capsys.readouterr().err


def test_what_a_node_refuses_is_bad_input(plan, monkeypatch, capsys):
    said = "navigation: rotor_bandwidth: -1.0 is out of range (allowed: 5 .. 1000 rad/s)"
    monkeypatch.setattr(verification, "fly", lambda *_: FlightEnd(2, said, 0.0, 1.0))
    assert main(["verify", str(plan), "--modes", "lockstep", "--no-load"]) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert error.splitlines()[-1] == f"heli verify: {said}"


def test_a_flight_that_leaves_no_bag_is_no_bad_input(plan, monkeypatch, capsys):
    monkeypatch.setattr(verification, "fly", lambda *_: FlightEnd(3, "navigation: killed", 0.0, 1.0))
    assert main(["verify", str(plan), "--modes", "lockstep", "--no-load"]) == 3
    assert "lockstep 1: navigation: killed" in capsys.readouterr().err
