"""Every benchmark can be loaded: a name that has moved is noticed before somebody wants a figure."""

from __future__ import annotations

import ast
import importlib
from dataclasses import replace
from pathlib import Path

import pytest

from heli_flight.plan import parse_plan
from heli_flight.plan_phases import Hover

FOLDER = Path(__file__).parents[1] / "benchmarks"
GUESTS = {"identification_peers"}
"""Runs in an environment that has another project's package."""


@pytest.mark.parametrize("name", sorted({path.stem for path in FOLDER.glob("*.py")} - GUESTS))
def test_a_benchmark_loads(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    assert importlib.import_module(name).__doc__


def test_guests_are_benchmarks_that_exist() -> None:
    for name in GUESTS:
        ast.parse((FOLDER / f"{name}.py").read_text())


def test_real_time_is_judged_by_every_bound_of_its_issue(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    realtime = importlib.import_module("realtime")
    figures = {"median_ms": 0.1, "p99_ms": 0.2, "p99_9_ms": 0.9, "max_ms": 9.0}
    punctual = {"latency_servo_command": figures | {"p99_9_ms": 4.9}, "period_jitter": figures}
    good = realtime.Found(
        10.0, "", True, {"servo_command": 0}, 0, 0.0, punctual, {"navigation": 15.0}, figures, 0.0
    )
    scheduled, plain = realtime.CASES["fifo"], realtime.CASES["plain"]
    assert realtime.verdict(scheduled, good) == (True, "held: all bounds")
    for change, words in (
        ({"late": {"servo_command": 1}}, "1 late servo_command"),
        ({"lost": 2}, "2 messages lost"),
        ({"paused_s": 0.02}, "0.020 s"),
        ({"ended": "silent"}, "stopped: silent"),
        ({"punctuality": {"latency_motor_command": figures | {"p99_9_ms": 5.0}}}, "not below 5 ms"),
        ({"punctuality": {"period_jitter": figures | {"p99_9_ms": 1.0}}}, "not below 1 ms"),
        ({"scheduled": False}, "not permitted"),
    ):
        held, said = realtime.verdict(scheduled, replace(good, **change))
        assert not held
        assert words in said
    assert realtime.verdict(plain, replace(good, late={"servo_command": 1}, scheduled=False))[0]


def test_the_plan_of_real_time_hovers_as_long_as_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    realtime = importlib.import_module("realtime")
    plan = parse_plan(realtime.plan_text(10.0), "plan")
    assert [phase.duration for phase in plan.phases if isinstance(phase, Hover)] == [600.0]
