"""`heli identify` and `heli chain` on data that bear nothing: one line, exit code 2."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from heli_common.flight_state import FlightState, flight_state_values
from heli_common.rotations import Euler
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_common.vehicle_state import VehicleState, odometry_values
from heli_flight.bag import BagWriter
from heli_flight.cli.main import main

Motion = Callable[[int], tuple[float, float]]


def moving(tick: int) -> tuple[float, float]:
    """Motion and input that differ from axis to axis."""
    return math.sin(0.05 * tick), math.sin(0.03 * tick + 1.0)


def bag(
    folder: Path, motion: Motion = moving, inputs: Motion = moving, count: int = 700, every: int = 1
) -> Path:
    """A made-up flight; motion and inputs by tick, a message every so many control periods."""
    writer = BagWriter(folder, {"plan": "", "seed": "1", "mode": "inprocess", "controller": "lq"})
    for topic in DATA_TOPICS:
        writer.add_topic(topic, TOPICS[topic].layout.ros_type)
    for tick in range(0, count * every, every):
        stamp = tick * CONTROL_PERIOD_NS
        ahead, right = motion(tick)
        first, second = inputs(tick)
        state = VehicleState(
            (0.0, 0.0, 0.0),
            Euler(0.1 * ahead, 0.02 * ahead, 0.03 * right),
            (0.1 * ahead, 0.1 * right, 0.1 * right),
            (0.3 * ahead, 0.3 * right, 0.1 * ahead),
        )
        values = {
            "odometry": odometry_values(state, [1e-6] * 6, [1e-4] * 6),
            "actuator_state": (0.01 * first, 0.01 * second, 0.1, 0.2, *(0.0,) * 11),
            "servo_command": (0.01 * first, 0.01 * second, 0.1, 0.2, *(0.0,) * 8),
            "flight_state": flight_state_values(FlightState.FLYING, 163.0),
            "rotor": (0.0, 163.0, 0.0),
            "motor_command": (0.0, 0.0, 5.5),
        }
        for topic, numbers in values.items():
            writer.write(topic, stamp, TOPICS[topic].layout.pack(stamp, [float(n) for n in numbers]))
    writer.close({})
    return folder


@pytest.mark.parametrize(
    ("case", "words"),
    [
        ({"motion": lambda _: (0.0, 0.0)}, "output theta is constant (allowed: a signal that moves)"),
        ({"inputs": lambda _: (0.5, 0.5)}, "input B_1s is constant (allowed: a signal that moves)"),
        ({"inputs": lambda t: (1e-3 * math.sin(t), 1.0)}, "input A_1s is constant"),
        ({"inputs": lambda t: (1e-3 * math.sin(t), math.cos(t))}, "input B_1s is not excited"),
        ({"count": 0}, "no actuator signal B_1s"),
        ({"count": 600}, "too short for 18 coefficients (allowed: at least 2.0 s)"),
        ({"every": 2}, "samples come every 20 ms (allowed: every 10 ms)"),
    ],
    ids=["constant output", "constant inputs", "one constant input", "unexcited", "empty", "short", "rate"],
)
def test_data_that_bear_no_estimate_are_refused(
    case: dict[str, object], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flown, out = bag(tmp_path / "flight", **case), tmp_path / "never.yaml"  # type: ignore[arg-type]
    begin = "5-6" if case == {"count": 600} else "0-6.9"
    assert main(["identify", str(flown), "--estimate", begin, "--out", str(out)]) == 2
    told = capsys.readouterr()
    assert words in told.err and told.err.startswith("heli identify: ")
    assert len(told.err.splitlines()) == 1 and told.out == ""
    assert not out.exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--seeds", "0"], "--seeds: 0 (allowed: 1 or more)"),
        (["--first", "-1"], "--first: -1 (allowed: 0 .. 2147483647)"),
        (["--workers", "0"], "--workers: 0 (allowed: 1 .. 64)"),
        (["--plan", "short_hover"], "short_hover: does not excite B_1s, A_1s"),
        (["--plan", "nowhere"], "nowhere"),
        (["--hover", "nowhere"], "nowhere"),
    ],
)
def test_the_chain_refuses_before_anything_flies(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "chain"
    assert main(["chain", "--out", str(out), *words]) == 2
    told = capsys.readouterr()
    assert message in told.err and len(told.err.splitlines()) == 1 and told.out == ""
    assert not out.exists()


def test_the_chain_does_not_write_over_anything(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    assert main(["chain", "--out", str(tmp_path)]) == 2
    assert f"{tmp_path}: --out: is not empty" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
