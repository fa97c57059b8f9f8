"""A sensor is lost in hover, for good: the flight goes on, and the navigation knows what it knows."""

import numpy as np
import pytest
from calm_room import CALM

from heli_control.controller_file import load_controller
from heli_flight.flight_record import FlightRecord
from heli_flight.fly_in_process import fly_in_process
from heli_flight.mode import Mode
from heli_flight.navigation_check import errors, nees
from heli_flight.order import FlightOrder
from heli_flight.plan import parse_plan

PLAN = """
name: loss
about: a sensor is lost in gusty hover
seed: 2
controller: lq
room: gusty
phases:
  - home: {{}}
  - run_up: {{}}
  - take_off: {{height: 0.0, speed: 0.4}}
  - hover: {{duration: 12.0}}
  - land: {{speed: 0.3}}
  - run_down: {{duration: 0.5}}
faults:
  - {{{fault}, at_s: 22.0}}
"""


@pytest.mark.parametrize(
    ("fault", "position_mm", "yaw_deg"),
    [
        ("kind: imu_dropout", 10.0, 0.5),
        ("kind: encoder_stuck, encoder: pitch", 5.0, 0.5),
        ("kind: encoder_stuck, encoder: roll", 5.0, 0.5),
        ("kind: encoder_lost_counts, encoder: arm_2, counts: 40", 100.0, 0.5),
        ("kind: encoder_lost_counts, encoder: yaw, counts: 60", 5.0, 12.0),
    ],
)
def test_the_flight_goes_on_without(tmp_path, fault, position_mm, yaw_deg):
    bag, room = tmp_path / "bag", tmp_path / "room.yaml"
    room.write_text(CALM)
    plan = parse_plan(PLAN.format(fault=fault))
    order = FlightOrder(plan, "loss", Mode.INPROCESS, plan.seed, load_controller("lq"), "lq", bag, room)
    end = fly_in_process(order, lambda _: None)
    assert end.exit_code == 0, end.reason
    record = FlightRecord.load(bag)
    found, honest = errors(record, record.estimate), nees(record)
    assert 1e3 * np.abs(found.position).max() < position_mm
    assert np.degrees(np.abs(found.attitude[:, :2]).max()) < 0.5
    assert np.degrees(np.abs(found.attitude[:, 2]).max()) < yaw_deg
    for name in ("position", "velocity", "attitude"):
        assert honest[name].mean() < 3.0, name
