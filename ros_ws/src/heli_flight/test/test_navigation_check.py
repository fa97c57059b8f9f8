"""Judging the navigation: delays, rotations, normalised errors; replaying a flight into its nodes."""

import json
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from heli_control.controller_file import load_controller
from heli_flight.bag_reader import read_bag
from heli_flight.cli.main import main
from heli_flight.flight_record import FlightRecord
from heli_flight.fly_in_process import fly_in_process
from heli_flight.mode import Mode
from heli_flight.navigation_check import (
    _normalised,
    _rotation_between,
    delay,
    differentiated,
    errors,
    free_flight,
    nees,
)
from heli_flight.order import FlightOrder
from heli_flight.plan import load_plan, parse_plan
from heli_flight.replay_check import replay

PLAN = """
name: short
about: gusts
seed: 4
controller: lq
room: gusty
phases:
  - home: {}
  - run_up: {}
  - take_off: {height: 0.0, speed: 0.4}
  - hover: {duration: 12.0}
  - land: {speed: 0.3}
  - run_down: {duration: 0.5}
"""

JUMP = """
faults:
  - {kind: imu_bias_jump, axis: gyro_x, size_deg_s: 1.0, at_s: 24.0}
"""


def fly(plan, bag):
    """Fly a plan in process."""
    order = FlightOrder(plan, plan.name, Mode.INPROCESS, 4, load_controller("lq"), "lq", bag)
    assert fly_in_process(order, lambda _: None).exit_code == 0
    return bag


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """The flight that the navigation is judged by, in process, in a bag."""
    return fly(load_plan("navigation_trial"), tmp_path_factory.mktemp("flight") / "bag")


def test_a_delay_is_found_to_a_fraction_of_a_sample():
    time = np.arange(0.0, 10.0, 0.01)

    def true(at):
        return np.column_stack([np.sin(3.0 * at), np.cos(2.0 * at), np.sin(at)])

    for late in (0.0, 0.0137, 0.08):
        assert delay(time, true(time - late), time, true(time)) == pytest.approx(late, abs=1e-3)


def test_small_rotation_between_two_attitudes():
    rng = np.random.default_rng(3)
    for _ in range(20):
        true = rng.uniform((-3.0, -0.4, -0.4), (3.0, 0.4, 0.4))
        seen = true + 1e-5 * rng.normal(size=3)
        turn = Rotation.from_euler("ZYX", seen) * Rotation.from_euler("ZYX", true).inv()
        assert _rotation_between(seen, true) == pytest.approx(turn.as_rotvec(), abs=1e-9)


def test_normalised_error_of_known_noise_is_one():
    rng = np.random.default_rng(5)
    shape = rng.normal(size=(3, 3))
    covariance = shape @ shape.T + np.eye(3)
    error = rng.multivariate_normal(np.zeros(3), covariance, size=20_000)
    found = _normalised(error, np.broadcast_to(covariance, (len(error), 3, 3)))
    assert found.mean() == pytest.approx(1.0, abs=5.0 * math.sqrt(2.0 / 3.0 / len(error)))


def test_the_filter_is_precise_and_honest_in_gusts(flight):
    record = FlightRecord.load(flight)
    begin, end = free_flight(record)
    assert end - begin > 10.0
    found, honest = errors(record, record.estimate), nees(record)
    assert np.sqrt(np.mean(found.velocity**2)) < 0.015
    assert np.degrees(np.sqrt(np.mean(found.rates**2))) < 0.5
    assert np.degrees(np.sqrt(np.mean(found.attitude**2))) < 0.1
    assert abs(found.velocity_delay) < 0.005
    for name in ("position", "velocity", "attitude", "rates"):
        assert 0.5 < honest[name].mean() < 1.8, name  # one flight; the twenty of the benchmark: 0.6 .. 1.6
    plain = errors(record, differentiated(record.bag, 40.0))
    assert np.mean(plain.velocity**2) > 9.0 * np.mean(found.velocity**2)
    assert plain.velocity_delay > 0.025


def test_a_jump_of_a_gyro_s_bias_is_tracked(tmp_path):
    record = FlightRecord.load(fly(parse_plan(PLAN + JUMP), tmp_path / "bag"))
    seen, true = (record.series[topic].column("position.gyro_x") for topic in ("imu_bias", "bench_condition"))
    time = record.series["imu_bias"].time
    rows = min(len(seen), len(true))
    error = np.degrees(np.abs(seen[:rows] - true[:rows]))
    assert error[np.searchsorted(time, 23.9)] < 0.05
    assert error[np.searchsorted(time, 24.1)] > 0.5
    assert error[-1] < 0.1


@pytest.mark.parametrize(
    "node",
    ["navigation", "supervisor", "position_controller", "attitude_controller", "motor_controller"],
)
def test_a_replay_gives_every_byte_back(flight, node, capsys):
    assert main(["replay", str(flight), "--into", node, "--check", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["same"] is True
    assert said["topics"] and all(topic["recorded"] > 100 for topic in said["topics"])


def test_a_replay_finds_the_first_byte_that_differs(flight):
    bag = read_bag(flight)
    sent = list(bag.messages["odometry"])
    changed = bytearray(sent[2500])
    changed[60] ^= 1
    sent[2500] = bytes(changed)
    bag.messages["odometry"] = sent
    found = {topic.topic: topic for topic in replay(bag, "navigation")}
    assert found["odometry"].different == 25_000_000_000
    assert not found["odometry"].same
    assert found["odometry_imu"].same


def test_replay_refuses_what_it_cannot_feed(flight, capsys):
    assert main(["replay", str(flight), "--into", "coffee_machine"]) == 2
    assert "unknown node 'coffee_machine'" in capsys.readouterr().err


def test_navigation_command_prints_and_refuses(flight, tmp_path, capsys):
    assert main(["navigation", str(flight), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    ours, *plain = found["rows"]
    as_quick = [row["velocity"] for row in plain if row["velocity_delay"] < 0.02]
    assert len(as_quick) == 3
    assert 3.0 * ours["velocity"] < min(as_quick)
    assert main(["navigation", str(flight)]) == 0
    assert "Kalman filter, as flown" in capsys.readouterr().out
    assert main(["navigation", str(tmp_path)]) == 2
    assert load_plan("navigation_trial").room == "gusty"
