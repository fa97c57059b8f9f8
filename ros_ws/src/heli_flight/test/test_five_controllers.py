"""The five controllers of the thesis fly from their shipped files, and are exchanged in one hover."""

import numpy as np
import pytest
from calm_room import CALM

from heli_control.controller_file import load_controller
from heli_flight.flight_record import FlightRecord
from heli_flight.fly_in_process import fly_in_process
from heli_flight.metrics import flight_metrics
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import load_plan, parse_plan

FIVE = ("lq", "gst", "gst2", "ncf", "ncf2")

PLAN = """
name: step
about: a step in the room's own gusts
seed: 1
controller: lq
room: gusty
phases:
  - home: {}
  - run_up: {duration: 4.0}
  - take_off: {height: 0.0, speed: 0.4}
  - hover: {duration: 2.0}
  - step: {axis: x, amplitude: 0.20, duration: 5.0}
  - land: {speed: 0.4}
  - run_down: {duration: 0.5}
"""


@pytest.mark.parametrize("name", FIVE)
def test_each_flies_a_step_in_gusts(tmp_path, name):
    bag, room = tmp_path / "bag", tmp_path / "room.yaml"
    room.write_text(CALM)
    plan = parse_plan(PLAN)
    order = FlightOrder(plan, "step", Mode.INPROCESS, plan.seed, load_controller(name), name, bag, room)
    end = fly_in_process(order, lambda _: None)
    assert end.exit_code == 0, end.reason
    (step,) = flight_metrics(FlightRecord.load(bag))["steps"]
    assert 0.3 < step["rise_time_s"] < 2.0
    assert step["overshoot_percent"] < 25.0
    assert abs(step["final_error_m"]) < 0.04


def test_the_shipped_plan_goes_through_all_of_them_within_two_centimetres(tmp_path):
    plan, bag = load_plan("switching"), tmp_path / "bag"
    assert plan.controllers == FIVE
    files = [load_controller(name) for name in FIVE]
    order = FlightOrder(
        plan, "switching", Mode.INPROCESS, plan.seed, files[0], FIVE[0], bag,
        later=tuple(files[1:]), later_names=FIVE[1:],
    )  # fmt: skip
    end = fly_in_process(order, lambda _: None)
    assert end.exit_code == 0, end.reason
    record = FlightRecord.load(bag)
    flown = record.series["flight_state"]
    numbers = flown.column("position.controller")
    changes = flown.stamps[1:][np.diff(numbers) != 0.0]
    assert len(changes) == 5
    for stamp in changes:
        after = (record.truth.stamps >= stamp) & (record.truth.stamps < stamp + 5_000_000_000)
        moved = np.linalg.norm(record.truth.position[after] - record.truth.position[after][0], axis=1)
        assert moved.max() < 0.02
