"""The hash of a flight, the first difference of two, and the count of what is missing."""

from __future__ import annotations

import hashlib
import random
import struct
from pathlib import Path

import numpy as np
import pytest
import synthetic_flight as synthetic

from heli_common.errors import InputError
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_flight.bag_reader import Bag, read_bag
from heli_flight.flight_hash import (
    FlightHash,
    bag_hash,
    canonical_messages,
    count_check,
    first_difference,
    hash_messages,
)

Messages = dict[str, list[bytes]]


def random_messages(ticks: int = 30, seed: int = 1) -> Messages:
    """Some messages of every topic of the table, those without a part in the hash included."""
    rng = np.random.default_rng(seed)
    return {
        name: [
            topic.layout.pack(k * topic.period_ns, rng.normal(size=len(topic.layout.fields)))
            for k in range(ticks)
        ]
        for name, topic in TOPICS.items()
    }


def bag_of(messages: Messages) -> Bag:
    types = {name: TOPICS[name].layout.ros_type for name in messages}
    stamps = {name: [TOPICS[name].layout.unpack(m)[0] for m in found] for name, found in messages.items()}
    return Bag(Path("memory"), types, stamps, messages, {}, ())


def test_it_is_the_hash_of_the_specification() -> None:
    messages = random_messages()
    rows = [
        (TOPICS[topic].layout.unpack(data)[0], topic, index, data)
        for topic in DATA_TOPICS
        for index, data in enumerate(messages[topic])
    ]
    digest = hashlib.sha256()
    for stamp, topic, _, data in sorted(rows):
        digest.update(topic.encode() + b"\x00" + struct.pack("<q", stamp) + struct.pack("<I", len(data)))
        digest.update(data)
    assert hash_messages(messages) == digest.hexdigest()


def test_the_order_between_topics_does_not_matter() -> None:
    messages = random_messages()
    one, other = FlightHash(), FlightHash()
    sequence = [(topic, data) for topic, found in messages.items() for data in found]
    for topic, data in sequence:
        one.add(topic, data)
    left = {topic: iter(found) for topic, found in messages.items()}
    names = [topic for topic, _ in sequence]
    random.Random(3).shuffle(names)
    for topic in names:
        other.add(topic, next(left[topic]))
    assert one.hexdigest() == other.hexdigest() == hash_messages(messages)


def test_clock_and_acknowledgements_do_not_matter() -> None:
    messages = random_messages()
    before = hash_messages(messages)
    messages["clock"], messages["recorder_ack"], messages["rosout"] = [], [], [b"anything"]
    assert hash_messages(messages) == before


def test_one_bit_matters() -> None:
    messages = random_messages()
    before = hash_messages(messages)
    changed = bytearray(messages["odometry"][7])
    changed[TOPICS["odometry"].layout.offsets[3]] ^= 1
    messages["odometry"][7] = bytes(changed)
    assert hash_messages(messages) != before


def test_padding_does_not_matter() -> None:
    messages = random_messages()
    layout = TOPICS["rotor"].layout
    constant = {layout.stamp_offset + k for k in range(8)} | {o + k for o in layout.offsets for k in range(8)}
    padding = [
        k
        for k in range(4, layout.size)
        if k not in constant and layout.template[k] == 0 and k >= layout.offsets[0] - 4
    ]
    assert padding, "the layout has padding between length and numbers"
    before = hash_messages(messages)
    dirty = bytearray(messages["rotor"][4])
    dirty[layout.offsets[0] - 1] = 0x55
    messages["rotor"][4] = bytes(dirty)
    assert hash_messages(messages) == before
    assert canonical_messages(layout, messages["rotor"])[4] != bytes(dirty)


def test_another_layout_is_refused() -> None:
    messages = random_messages()
    with pytest.raises(InputError, match="rotor"):
        hash_messages(messages | {"rotor": messages["encoders"]})
    renamed = messages["rotor"][0].replace(b"rotor\0", b"motor\0")
    with pytest.raises(InputError, match=r"memory: rotor: .*differ"):
        bag_hash(bag_of(messages | {"rotor": [renamed]}))


def test_a_bag_has_the_hash_of_what_was_written(tmp_path: Path) -> None:
    flight = FlightHash()
    for topic, _, data in synthetic.messages(synthetic.load_plan("short_hover")):
        flight.add(topic, data)
    synthetic.write_flight(tmp_path / "flight")
    bag = read_bag(tmp_path / "flight")
    assert bag_hash(bag) == flight.hexdigest()


def test_no_difference() -> None:
    assert first_difference(bag_of(random_messages()), bag_of(random_messages())) is None


def test_the_first_differing_number_is_named() -> None:
    one, other = random_messages(), random_messages()
    layout = TOPICS["ground_truth"].layout
    for index in (9, 5):
        stamp, values = layout.unpack(other["ground_truth"][index])
        changed = [*values[:2], 123.0, *values[3:]]
        other["ground_truth"][index] = layout.pack(stamp, changed)
    difference = first_difference(bag_of(one), bag_of(other))
    assert difference is not None
    assert (difference.topic, difference.index, difference.stamp_ns) == ("ground_truth", 5, 50_000_000)
    assert "position.z" in difference.what and "123.0 in the second" in str(difference)


def test_a_missing_message_is_a_difference() -> None:
    one, other = random_messages(), random_messages()
    del other["rotor"][-1]
    difference = first_difference(bag_of(one), bag_of(other))
    assert difference is not None and difference.topic == "rotor"
    assert difference.what == "only in the first flight"
    swapped = first_difference(bag_of(other), bag_of(one))
    assert swapped is not None and swapped.what == "only in the second flight"


def test_counts_of_a_bag_with_gaps_and_repetitions() -> None:
    messages = random_messages(20)
    reference = messages["reference"]
    messages["reference"] = reference[:5] + reference[5:6] * 2 + reference[8:]
    counts = {count.topic: count for count in count_check(bag_of(messages))}
    found = counts["reference"]
    assert (found.messages, found.expected, found.lost, found.gaps) == (19, 20, 2, 1)
    assert found.first_gap_ns == 60_000_000
    assert counts["clock"].expected is None
    assert counts["odometry"].lost == 0
