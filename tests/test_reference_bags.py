"""The committed flight: whole, of the hash that bags/README.md names, and what today's code makes of it.

Between processor types numbers differ in the last bits (spec 6.5): replayed navigation is compared to 1e-7.
"""

from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from heli_common.topics import TOPICS
from heli_flight.bag_reader import read_bag
from heli_flight.components import navigator
from heli_flight.flight_hash import bag_hash
from heli_flight.packed import read_layout

BAGS = Path(__file__).parents[1] / "bags"
NAMES = ("hover_steps",)
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


def test_rosbags_reads_them():
    with Reader(BAGS / "hover_steps") as reader:
        assert reader.message_count == sum(read_bag(BAGS / "hover_steps").counts.values())
        connection, _, data = next(iter(reader.messages()))
        assert len(data) == TOPICS[connection.topic.lstrip("/")].layout.size


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
