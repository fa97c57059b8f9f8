"""What the bench says of its punctuality, as numbers."""

from heli_flight.punctuality import PERIOD, punctuality


def test_the_words_of_the_bench_become_numbers():
    remarks = {
        "latency_servo_command_ms": "median 1.30, 99 % 1.90, 99.9 % 2.70, max 13.90",
        "period_jitter_ms": "median 0.07, 99 % 0.20, 99.9 % 0.50, max 0.90",
        "late_servo_command": "0",
        "jitter": "{}",
        "paused_s": "0.000",
    }
    assert punctuality(remarks) == {
        "latency_servo_command": {"median_ms": 1.3, "p99_ms": 1.9, "p99_9_ms": 2.7, "max_ms": 13.9},
        PERIOD: {"median_ms": 0.07, "p99_ms": 0.2, "p99_9_ms": 0.5, "max_ms": 0.9},
    }


def test_older_bags_have_fewer_figures():
    remarks = {"latency_servo_command_ms": "median 1.30, 99.9 % 2.70, max 3.90"}
    assert punctuality(remarks)["latency_servo_command"] == {
        "median_ms": 1.3,
        "p99_9_ms": 2.7,
        "max_ms": 3.9,
    }
    assert punctuality({}) == {}
