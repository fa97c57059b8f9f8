"""How punctual a flight in real time is: latency of commands, jitter of the bench's control period."""

import pytest

from heli_bench_sim.nodes import latency
from heli_bench_sim.nodes.latency import Jitter, Latency


@pytest.fixture
def clock(monkeypatch):
    """Wall time that the test sets [s]."""

    class Clock:
        now = 0.0

    monkeypatch.setattr(latency, "perf_counter", lambda: Clock.now)
    return Clock


def test_latency_is_from_sample_to_command_of_its_stamp(clock):
    found = Latency(["servo_command", "motor_command"])
    for stamp in range(1000):
        clock.now = 0.01 * stamp
        found.published(stamp)
        clock.now += 0.001
        found.arrived("servo_command", stamp)
        if stamp == 500:
            clock.now += 0.006
        found.arrived("motor_command", stamp)
    found.arrived("motor_command", 5000)  # answers nothing that was sent
    assert found.figures() == {
        "latency_servo_command_ms": "median 1.00, 99 % 1.00, 99.9 % 1.00, max 1.00",
        "latency_motor_command_ms": "median 1.00, 99 % 1.00, 99.9 % 1.01, max 7.00",
    }


def test_nothing_is_said_of_a_topic_that_never_came():
    found = Latency(["servo_command"])
    found.published(0)
    assert found.figures() == {}
    assert Jitter().figures() == {}


def test_jitter_is_how_late_periods_begin():
    found = Jitter()
    for late in (0.0001, 0.0002, 0.0003):
        found.began(late)
    assert found.figures() == {"period_jitter_ms": "median 0.20, 99 % 0.30, 99.9 % 0.30, max 0.30"}
