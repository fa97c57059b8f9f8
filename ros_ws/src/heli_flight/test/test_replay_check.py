"""Every node, fed from a bag, sends what it sent; what the bag cannot tell is refused by name."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest
from rosbags.typesys import Stores, get_typestore

from heli_common.errors import InputError
from heli_common.topics import TOPICS
from heli_control.controller_file import load_controller
from heli_flight.bag_reader import Bag, read_bag
from heli_flight.cli.main import main
from heli_flight.fly_in_process import fly_in_process
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import parse_plan
from heli_flight.process_table import NODE_NAMES
from heli_flight.replay_check import replay
from heli_flight.replay_components import requests_of

PLAN = """
name: short
about: Up, excited and down.
seed: 3
controller: lq
phases:
  - home: {duration: 8.0}
  - run_up: {duration: 6.0}
  - take_off: {height: 0.0, speed: 0.3}
  - excite: {signal: prbs, channels: [B_1s], amplitude_deg: 0.5, band_rad_s: [0.5, 12], duration: 2.0}
  - land: {speed: 0.3}
  - run_down: {duration: 1.0}
"""
REPLAYED = tuple(name for name in NODE_NAMES if name != "recorder")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("replay") / "flight"
    plan, controller = parse_plan(PLAN, "test"), load_controller("lq")
    end = fly_in_process(FlightOrder(plan, "", Mode.INPROCESS, 3, controller, "lq", path), lambda _: None)
    assert end.exit_code == 0, end.reason
    return path


@pytest.fixture(scope="module")
def bag(folder: Path) -> Bag:
    return read_bag(folder)


@pytest.mark.parametrize("node", REPLAYED)
def test_every_node_sends_what_it_sent(bag: Bag, node: str) -> None:
    found = replay(bag, node)
    assert found and all(topic.same and topic.whole for topic in found), found
    assert all(topic.recorded == bag.counts[topic.topic] > 100 for topic in found)


@pytest.mark.parametrize("node", REPLAYED)
def test_a_bag_that_was_cut_is_compared_as_far_as_it_goes(bag: Bag, node: str) -> None:
    until = {topic: 10_000_000_000 + 7_500_000 * number for number, topic in enumerate(bag.types)}
    messages = {
        topic: [data for data in found if TOPICS[topic].layout.stamp(data) <= until[topic]]
        for topic, found in bag.messages.items()
        if topic in TOPICS
    }
    found = replay(dataclasses.replace(bag, messages=messages, problems=("cut off",)), node)
    assert all(topic.same and not topic.whole for topic in found), found
    assert all(10_000_000_000 <= topic.until_ns < 10_300_000_000 for topic in found)


def test_a_changed_number_is_found(bag: Bag) -> None:
    layout = TOPICS["imu"].layout
    changed = list(bag.messages["imu"])
    stamp, values = layout.unpack(changed[4000])
    changed[4000] = layout.pack(stamp, [value + 1e-9 for value in values])
    other = dataclasses.replace(bag, messages={**bag.messages, "imu": changed})
    by_topic = {topic.topic: topic for topic in replay(other, "navigation")}
    assert by_topic["odometry_imu"].different == stamp == 10_000_000_000
    assert {topic.topic: topic.different for topic in replay(other, "bench_sim")}["imu"] == stamp


def test_what_the_bag_cannot_tell_is_refused(bag: Bag, folder: Path) -> None:
    with pytest.raises(InputError, match="unknown node"):
        replay(bag, "recorder")
    late = dataclasses.replace(bag, custom_data=bag.custom_data | {"late_servo_command": "3"})
    with pytest.raises(InputError, match="late_servo_command: 3: when a late command came is not in the bag"):
        replay(late, "bench_sim")
    odd = dataclasses.replace(bag, custom_data=bag.custom_data | {"seed": "-"})
    with pytest.raises(InputError, match="seed"):
        replay(odd, "bench_sim")
    without = dataclasses.replace(bag, messages={**bag.messages, "imu": []})
    with pytest.raises(InputError, match="imu"):
        replay(without, "navigation")
    assert main(["replay", str(folder), "--into", "nobody"]) == 2


def asked(bag: Bag, stamp_ns: int, node: str, text: str) -> Bag:
    """The bag with a request in its diagnostics."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types = store.types
    pair = types["diagnostic_msgs/msg/KeyValue"]("request", text)
    status = types["diagnostic_msgs/msg/DiagnosticStatus"](0, node, "request", "", [pair])
    time = types["builtin_interfaces/msg/Time"](*divmod(stamp_ns, 1_000_000_000))
    array = types["diagnostic_msgs/msg/DiagnosticArray"](types["std_msgs/msg/Header"](time, ""), [status])
    data = bytes(store.serialize_cdr(array, "diagnostic_msgs/msg/DiagnosticArray"))
    return dataclasses.replace(bag, messages={**bag.messages, "diagnostics": [data]})


@pytest.mark.parametrize(
    ("node", "text", "topic"),
    [
        ("attitude_controller", load_controller("gst2").to_yaml(), "servo_command"),
        ("identification", "", "excitation"),
        ("supervisor", "land", "reference"),
        ("bench_sim", "encoder_stuck encoder=yaw for_s=2", "bench_condition"),
    ],
)
def test_a_request_acts_at_its_stamp(bag: Bag, node: str, text: str, topic: str) -> None:
    layout = TOPICS["excitation"].layout
    excited = next(layout.stamp(data) for data in bag.messages["excitation"] if any(layout.unpack(data)[1]))
    stamp_ns = excited + 500_000_000
    other = asked(bag, stamp_ns, node, text)
    assert requests_of(other, node) == ((stamp_ns, text),) and requests_of(other, "navigation") == ()
    different = {found.topic: found.different for found in replay(other, node)}[topic]
    assert different is not None and stamp_ns <= different <= stamp_ns + 100_000_000


def test_a_request_that_its_node_does_not_know_is_refused(bag: Bag) -> None:
    with pytest.raises(InputError, match="was asked for at 18"):
        replay(asked(bag, 18_500_000_000, "navigation", "more"), "navigation")


def test_the_command_prints_what_it_compared(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(folder), "--into", "bench_sim", "--check", "--json"]) == 0
    about = json.loads(capsys.readouterr().out)
    assert about["same"] and {"encoders", "ground_truth"} <= {topic["topic"] for topic in about["topics"]}
