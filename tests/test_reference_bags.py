"""The committed flights: whole, of the hashes that bags/README.md names, and what today's code makes of them.

Between processor types numbers differ in the last bits (spec 6.5): replayed navigation is compared to 1e-7.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from heli_common.topics import TOPICS
from heli_flight.bag_reader import read_bag
from heli_flight.cli.main import main
from heli_flight.components import navigator
from heli_flight.flight_hash import bag_hash
from heli_flight.packed import read_layout

BAGS = Path(__file__).parents[1] / "bags"
NAMES = ("hover_steps", "identification")
SECONDS = 20
LARGEST_BYTES = 12_000_000


@pytest.fixture(scope="module", params=NAMES)
def bag(request):
    return read_bag(BAGS / request.param)


def test_they_are_whole_and_of_the_documented_hash(bag):
    assert bag.complete and len(bag.messages["encoders"]) > 20_000
    assert f"| {bag_hash(bag)} |" in (BAGS / "README.md").read_text()
    assert bag.custom_data["seed"] == "1" and bag.custom_data["mode"] == "inprocess"


def test_they_stay_small():
    assert sum(path.stat().st_size for path in BAGS.rglob("*") if path.is_file()) < LARGEST_BYTES
    assert sorted(path.name for path in BAGS.iterdir() if path.is_dir()) == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_rosbags_reads_them(name):
    with Reader(BAGS / name) as reader:
        assert reader.message_count == sum(read_bag(BAGS / name).counts.values())
        connections = [each for each in reader.connections if each.topic.strip("/") == "encoders"]
        _, _, data = next(reader.messages(connections))
        assert len(data) == TOPICS["encoders"].layout.size


def test_navigation_of_today_finds_the_same_motion(bag):
    component = navigator()
    heard = sorted(
        (TOPICS[topic].layout.stamp(data), order, topic, data)
        for order, topic in enumerate(component.inputs)
        for data in bag.messages[topic]
        if TOPICS[topic].layout.stamp(data) < SECONDS * 1_000_000_000
    )
    sent = {topic: [] for topic in component.outputs}
    for stamp_ns, _, topic, data in heard:
        for message in component.receive(topic, stamp_ns, TOPICS[topic].layout.unpack(data)[1]):
            sent[message.topic].append(np.array(message.values))
    compared = [topic for topic in component.outputs if bag.messages.get(topic)]
    assert "rotor_state" in compared
    for topic in compared:
        _, recorded = read_layout(TOPICS[topic].layout, bag.messages[topic])
        count = len(sent[topic])
        assert count == SECONDS * 100
        np.testing.assert_allclose(np.array(sent[topic]), recorded[:count], rtol=1e-7, atol=1e-7)


def test_the_plant_is_identified_from_the_second(tmp_path, capsys):
    words = ["identify", str(BAGS / "identification"), "--structure", "servo_rotor"]
    assert main([*words, "--out", str(tmp_path / "model.yaml"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["converged"]
    assert min(found["validation_fit_percent"].values()) > 80.0
    # pitch and roll damping: of fifty flights of this bench, docs/identification.md
    for name, mean in (("M_q", -14.13), ("L_p", -33.75)):
        assert found["parameters"][name]["value"] == pytest.approx(mean, rel=0.03)
        assert found["parameters"][name]["standard_error"] < 0.01 * abs(mean)
