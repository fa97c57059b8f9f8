"""Calibration of the gusts: on a made-up room, its file, and what it refuses."""

from math import radians
from pathlib import Path

import pytest

from heli_bench_sim.room_air import RoomAirParameters
from heli_common import topics
from heli_common.errors import InputError, SafetyStop
from heli_flight.cli.main import main
from heli_flight.gust_calibration import (
    STRENGTHS,
    Four,
    calibrate,
    parameter_text,
    require_gusty,
    rounded,
    start_strengths,
)
from heli_flight.parameter_file import NodeValues, read_parameters
from heli_flight.plan import load_plan
from heli_flight.published_flights import LQ_HOVER

TARGET: Four = (0.05, 0.06, 0.10, 0.14)
START: Four = (1.0, 1.0, 0.3, 0.3)


def made_up(strengths: Four, seed: int) -> Four:
    """Powers 1.8, 1.7, 1.4 and 0.9 of the strengths, y and z a little with x, scattered by the seed."""
    x, y, z, yaw = strengths
    scatter = 1.0 + 0.1 * (seed % 3 - 1)
    return (
        0.014 * scatter * x**1.8,
        0.024 * x**0.1 * y**1.7,
        0.35 * z**1.4 * (1.0 + 0.05 * x),
        0.12 * scatter * yaw**0.9,
    )


def test_finds_the_strengths_of_a_made_up_room() -> None:
    found = calibrate(made_up, TARGET, START, (1, 2, 3), tolerance=0.03)
    assert found.ratios == pytest.approx((1.0,) * 4, abs=0.03)
    means = [
        sum(column) / 3 for column in zip(*(made_up(found.strengths, s) for s in (1, 2, 3)), strict=True)
    ]
    assert means == pytest.approx(TARGET, rel=0.03)
    assert found.strengths == rounded(found.strengths)
    assert len(found.rounds) <= 8


def test_a_lost_round_is_taken_back() -> None:
    def fragile(strengths: Four, seed: int) -> Four:
        if strengths[0] > 2.1:
            raise SafetyStop("too far")
        return made_up(strengths, seed)

    found = calibrate(fragile, TARGET, START, (2,), tolerance=0.05)
    lost = [entry.failure for entry in found.rounds if entry.sigmas is None]
    assert lost and lost[0] == "seed 2: too far"
    assert found.strengths[0] <= 2.1


def test_what_cannot_be_met_is_said() -> None:
    with pytest.raises(InputError, match="not within 3 % after 2 rounds"):
        calibrate(lambda *_: (1e-3,) * 4, TARGET, START, (1,), most_rounds=2)
    with pytest.raises(InputError, match="0 seeds"):
        calibrate(made_up, TARGET, START, ())
    with pytest.raises(InputError, match="positive numbers"):
        calibrate(made_up, (0.0, 1.0, 1.0, 1.0), START, (1,))


def test_the_file_reads_back_and_says_how(tmp_path: Path) -> None:
    found = calibrate(made_up, TARGET, START, (1, 2), tolerance=0.05)
    path = tmp_path / "room.yaml"
    path.write_text(parameter_text(found, load_plan("hover"), "heli calibrate gusts"))
    assert start_strengths(read_parameters(path)) == found.strengths
    text = path.read_text()
    assert "heli calibrate gusts" in text and "seeds 1, 2" in text
    assert text.count("from ") == len(found.rounds)


def test_plans_in_still_air_are_refused() -> None:
    assert require_gusty(load_plan("hover")).name == "hover"
    with pytest.raises(InputError, match="still"):
        require_gusty(load_plan("hover_steps"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--seeds", "0"], "--seeds"),
        (["--tolerance", "0"], "--tolerance"),
        (["--plan", "hover_steps"], "room: gusty"),
        (["--workers", "0"], "--workers"),
    ],
)
def test_refusals(words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "room.yaml"
    assert main(["calibrate", "gusts", "--out", str(out), *words]) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()


def test_the_target_is_the_lq_row() -> None:
    assert pytest.approx((0.0461, 0.0647, 0.1049, radians(8.17))) == LQ_HOVER


def test_changed_values_keep_the_others() -> None:
    values = NodeValues({topics.BENCH_SIM: {"room.strength_x": 2.0, "wind.lag": 2.0}})
    changed = values.changed(topics.BENCH_SIM, {"room.strength_x": 3.0})
    found = changed.build(topics.BENCH_SIM, RoomAirParameters, "room.")
    assert (found.strength_x, found.strength_y) == (3.0, RoomAirParameters().strength_y)
    assert start_strengths(values)[0] == 2.0
    assert {f"room.{name}" for name in STRENGTHS} >= {"room.strength_x"}
