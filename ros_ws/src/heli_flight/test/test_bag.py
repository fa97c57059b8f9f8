"""Bags: readable by others, by us after a kill or a cut, and refused where they would overwrite."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from heli_common.errors import InputError
from heli_common.topics import TOPICS
from heli_flight.bag import BagWriter
from heli_flight.bag_metadata import (
    RecordedTopic,
    bag_information,
    dump_yaml,
    metadata_text,
    qos_profile,
    with_topics,
)
from heli_flight.bag_reader import read_bag, topic_name
from heli_flight.flight_hash import bag_hash, count_check

STORE = get_typestore(Stores.ROS2_JAZZY)
CONTROL, SENSOR = 10_000_000, 2_500_000
NOTES = {"plan": "name: a\nabout: two words\n", "seed": "1"}


def write(
    folder: Path, ticks: int = 300, skip: Callable[[int], bool] | None = None, storage: str = "mcap"
) -> BagWriter:
    """A bag with encoders at 400 Hz and rotor at 100 Hz; `skip(k)` leaves rotor messages out."""
    writer = BagWriter(folder, NOTES, storage)
    for topic in ("encoders", "rotor"):
        writer.add_topic(topic, TOPICS[topic].layout.ros_type)
    for k in range(ticks):
        stamp = k * SENSOR
        writer.write("encoders", stamp, TOPICS["encoders"].layout.pack(stamp, [0.1 * k] * 18))
        if stamp % CONTROL == 0 and not (skip and skip(k // 4)):
            writer.write("rotor", stamp, TOPICS["rotor"].layout.pack(stamp, [1.0, 2.0, 0.3 * k]))
    writer.close({"late_commands": "0"})
    return writer


def test_rosbags_reads_it(tmp_path: Path) -> None:
    write(tmp_path / "flight")
    with AnyReader([tmp_path / "flight"]) as reader:
        connections = {connection.topic: connection for connection in reader.connections}
        assert set(connections) == {"/encoders", "/rotor"}
        assert connections["/encoders"].msgcount == 300
        assert connections["/rotor"].digest == STORE.hash_rihs01("sensor_msgs/msg/JointState")
        qos = connections["/rotor"].ext.offered_qos_profiles[0]
        assert (qos.depth, qos.reliability) == (1000, QosReliability.RELIABLE)
        connection, stamp, data = list(reader.messages())[-1]
        message = reader.deserialize(data, connection.msgtype)
        assert message.header.stamp.nanosec == stamp == 299 * SENSOR
        assert message.name == ["arm_1", "arm_2", "arm_3", "yaw", "pitch", "roll"]


def test_mcap_reads_it(tmp_path: Path) -> None:
    write(tmp_path / "flight")
    with (tmp_path / "flight" / "flight_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        assert summary.statistics.message_count == 375
        schemas = {schema.encoding for schema in summary.schemas.values()}
        assert schemas == {"ros2msg"}
        for _, channel, message in reader.iter_messages(topics="/rotor"):
            assert channel.message_encoding == "cdr"
            assert message.log_time == message.publish_time
        names = {record.name for record in reader.iter_metadata()}
        assert names == {"heli_flight", "rosbag2"}


def test_own_reader_gives_everything_back(tmp_path: Path) -> None:
    writer = write(tmp_path / "flight")
    bag = read_bag(tmp_path / "flight")
    assert bag.complete and bag.counts == writer.counts == {"encoders": 300, "rotor": 75}
    assert bag.types["rotor"] == "sensor_msgs/msg/JointState"
    assert bag.custom_data["plan"] == NOTES["plan"]
    assert json.loads(bag.custom_data["counts"]) == writer.counts
    assert json.loads(bag.custom_data["losses"]) == {}
    assert bag.custom_data["late_commands"] == "0"
    assert bag.messages["rotor"][3] == TOPICS["rotor"].layout.pack(3 * CONTROL, [1.0, 2.0, 0.3 * 12])
    assert bag.stamps["rotor"] == [k * CONTROL for k in range(75)]
    file = read_bag(tmp_path / "flight" / "flight_0.mcap")
    assert file.messages == bag.messages


def test_metadata_is_version_9(tmp_path: Path) -> None:
    write(tmp_path / "flight")
    document = yaml.safe_load((tmp_path / "flight" / "metadata.yaml").read_text())
    information = document["rosbag2_bagfile_information"]
    assert (information["version"], information["storage_identifier"]) == (9, "mcap")
    assert information["duration"]["nanoseconds"] == 299 * SENSOR
    assert information["relative_file_paths"] == ["flight_0.mcap"]
    assert all(isinstance(text, str) for text in information["custom_data"].values())
    profile = information["topics_with_message_count"][0]["topic_metadata"]["offered_qos_profiles"][0]
    assert profile["durability"] == "volatile"


def test_the_text_of_metadata_says_what_a_dump_of_them_says() -> None:
    topics = [
        RecordedTopic("/rotor", "sensor_msgs/msg/JointState", "RIHS01_a", qos_profile(1000, False)),
        RecordedTopic("/state", "std_msgs/msg/String", "RIHS01_b", qos_profile(1, True), count=7),
    ]
    for listed in (topics, []):
        about = bag_information("f_0.mcap", "mcap", listed, 5, 9, {"plan": "a: 1\nb: 2\n", "seed": "1"})
        text = metadata_text(about, listed)
        assert yaml.safe_load(text) == {"rosbag2_bagfile_information": with_topics(about, listed)}
        assert "&" not in text
    topics[1].count = 8
    assert "message_count: 8" in metadata_text(about, topics)


def test_metadata_is_there_from_the_start_and_renewed(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / "flight", NOTES)
    writer.add_topic("rotor", "sensor_msgs/msg/JointState")
    path = tmp_path / "flight" / "metadata.yaml"

    def count() -> int:
        return int(yaml.safe_load(path.read_text())["rosbag2_bagfile_information"]["message_count"])

    assert count() == 0
    for k in range(350):
        writer.write("rotor", k * CONTROL, TOPICS["rotor"].layout.pack(k * CONTROL, [0.0] * 3))
        assert k - count() <= 100
    assert [item.name for item in path.parent.iterdir() if item.name.startswith(".")] == []
    writer.close()
    writer.close()
    assert count() == 350


def test_an_empty_bag_is_readable(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "flight") as writer:
        writer.add_topic("rotor", "sensor_msgs/msg/JointState")
    bag = read_bag(tmp_path / "flight")
    assert bag.complete and bag.counts == {"rotor": 0} and bag.types
    with AnyReader([tmp_path / "flight"]) as reader:
        assert reader.message_count == 0


def test_other_messages_are_kept_raw(tmp_path: Path) -> None:
    types = STORE.types
    status = types["diagnostic_msgs/msg/DiagnosticStatus"](0, "bench", "ok", "", [])
    head = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](1, 2), "")
    array = types["diagnostic_msgs/msg/DiagnosticArray"](head, [status])
    data = bytes(STORE.serialize_cdr(array, "diagnostic_msgs/msg/DiagnosticArray"))
    with BagWriter(tmp_path / "flight") as writer:
        writer.add_topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", depth=10)
        writer.add_topic("/rosout", "rcl_interfaces/msg/Log", transient_local=True)
        writer.write("/diagnostics", 1_000_000_002, data)
    assert read_bag(tmp_path / "flight").messages == {"diagnostics": [data], "rosout": []}
    with AnyReader([tmp_path / "flight"]) as reader:
        ((connection, _, raw),) = reader.messages()
        assert reader.deserialize(raw, connection.msgtype).status[0].name == "bench"
        rosout = next(c for c in reader.connections if c.topic == "/rosout")
        assert rosout.ext.offered_qos_profiles[0].durability == QosDurability.TRANSIENT_LOCAL


def test_a_folder_with_content_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    BagWriter(tmp_path / "empty").close()
    with pytest.raises(InputError, match="exists already"):
        BagWriter(tmp_path / "empty")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="exists already"):
        BagWriter(tmp_path / "file")


def test_misuse_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not text"):
        BagWriter(tmp_path / "a", {"seed": 1})  # type: ignore[dict-item]
    assert not (tmp_path / "a").exists()
    writer = BagWriter(tmp_path / "b")
    with pytest.raises(ValueError, match="no_such"):
        writer.add_topic("x", "no_such/msg/Type")
    writer.add_topic("rotor", "sensor_msgs/msg/JointState")
    with pytest.raises(ValueError, match="announced already"):
        writer.add_topic("rotor", "sensor_msgs/msg/JointState")
    with pytest.raises(ValueError, match="not announced"):
        writer.write("encoders", 0, b"")
    writer.close()


def test_losses_are_counted(tmp_path: Path) -> None:
    writer = write(tmp_path / "flight", skip=lambda k: k in (10, 11, 40))
    assert writer.losses == {"rotor": {"lost": 3, "gaps": 2}}
    bag = read_bag(tmp_path / "flight")
    assert json.loads(bag.custom_data["losses"]) == writer.losses
    counts = {count.topic: count for count in count_check(bag)}
    rotor = counts["rotor"]
    assert (rotor.messages, rotor.expected, rotor.lost, rotor.gaps) == (72, 75, 3, 2)
    assert rotor.first_gap_ns == 10 * CONTROL
    assert counts["encoders"].lost == 0


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, dict[str, list[bytes]]]:
    folder = tmp_path_factory.mktemp("whole") / "flight"
    write(folder, 1500)
    return (folder / "flight_0.mcap").read_bytes(), read_bag(folder).messages


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(share=st.floats(0.0, 1.0))
def test_cut_anywhere_gives_the_beginning(
    whole: tuple[bytes, dict[str, list[bytes]]], tmp_path: Path, share: float
) -> None:
    content, messages = whole
    path = tmp_path / "cut.mcap"
    path.write_bytes(content[: int(share * (len(content) - 1))])
    bag = read_bag(path)
    for topic, found in bag.messages.items():
        assert found == messages[topic][: len(found)]


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(data=st.data())
def test_damage_is_reported_and_never_gives_a_wrong_message(
    whole: tuple[bytes, dict[str, list[bytes]]], tmp_path: Path, data: st.DataObject
) -> None:
    content, messages = bytearray(whole[0]), whole[1]
    place = data.draw(st.integers(400, len(content) - 200))
    content[place] ^= data.draw(st.integers(1, 255))
    path = tmp_path / "damaged.mcap"
    path.write_bytes(content)
    try:
        bag = read_bag(path)
    except InputError:
        return
    for topic, found in bag.messages.items():
        known = set(messages.get(topic, []))
        assert all(message in known for message in found)


def test_missing_metadata_is_made_up_for(tmp_path: Path) -> None:
    write(tmp_path / "flight")
    (tmp_path / "flight" / "metadata.yaml").unlink()
    bag = read_bag(tmp_path / "flight")
    assert bag.custom_data == NOTES
    assert bag.problems[0] == "metadata.yaml is missing"
    (tmp_path / "flight" / "metadata.yaml").write_text("{")
    assert read_bag(tmp_path / "flight").problems[0] == "metadata.yaml is unreadable"


def test_metadata_that_promises_more_is_noticed(tmp_path: Path) -> None:
    write(tmp_path / "flight")
    path = tmp_path / "flight" / "metadata.yaml"
    path.write_text(path.read_text().replace("message_count: 375", "message_count: 376"))
    assert "376" in read_bag(tmp_path / "flight").problems[0]


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such bag"):
        read_bag(tmp_path / "nothing")
    with pytest.raises(InputError, match="holds no MCAP file"):
        read_bag(tmp_path)
    (tmp_path / "wrong.mcap").write_text("this is text, not a bag")
    with pytest.raises(InputError, match="is no MCAP file"):
        read_bag(tmp_path)


def test_a_bag_of_another_recorder_in_a_namespace(tmp_path: Path) -> None:
    own = write(tmp_path / "own")
    messages = read_bag(own.folder).messages
    with Writer(tmp_path / "other", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic in ("rotor", "encoders"):
            kind = TOPICS[topic].layout.ros_type
            connection = writer.add_connection(f"/bench_2/{topic}", kind, typestore=STORE)
            for number, data in enumerate(messages[topic]):
                writer.write(connection, 1_700_000_000_000_000_000 + number, data)
    bag = read_bag(tmp_path / "other")
    assert bag.complete and bag.messages == messages
    assert bag_hash(bag) == bag_hash(read_bag(own.folder))


def test_topic_names() -> None:
    assert topic_name("/bench_1/rotor") == topic_name("rotor") == "rotor"
    assert topic_name("/bench_1/camera") == "bench_1/camera"


def test_yaml_texts_stay_legible() -> None:
    text = dump_yaml({"plan": "a: 1\nb: 2\n", "seed": "1"})
    assert text == "plan: |\n  a: 1\n  b: 2\nseed: '1'\n"
