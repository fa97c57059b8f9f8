"""A recorder that is killed, a disk that is full, a file that is cut: what was written before is readable."""

from __future__ import annotations

import ctypes
import errno
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from heli_common.errors import InputError
from heli_common.topics import TOPICS
from heli_flight.bag import STORAGES, BagWriter
from heli_flight.bag_check import bag_state, write_again
from heli_flight.bag_reader import read_bag
from heli_flight.cli.main import main
from heli_flight.mcap_file import CHUNK_BYTES

SENSOR, CONTROL, SECOND = 2_500_000, 10_000_000, 1_000_000_000
STORED = ("mcap", "sqlite3")

WRITING = """
import os, random, resource, signal, sys
from pathlib import Path
from heli_common.topics import TOPICS
from heli_flight.bag import BagWriter
folder, storage, ticks, limit = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
writer = BagWriter(Path(folder), {"plan": "name: lost", "seed": "7"}, storage)
layout, rng = TOPICS["encoders"].layout, random.Random(1)
writer.add_topic("encoders", layout.ros_type)
try:
    for k in range(ticks):
        stamp = k * 2_500_000
        writer.write("encoders", stamp, layout.pack(stamp, [rng.random() for _ in range(18)]))
except OSError as error:
    print(f"{k}|{error}", flush=True)
    writer.write("encoders", stamp, layout.pack(stamp, [0.0] * 18))
    writer.close({"result": "lost"})
    sys.exit(3)
os.kill(os.getpid(), signal.SIGKILL)
"""


def run(folder: Path, storage: str, ticks: int, limit: int = 0) -> subprocess.CompletedProcess[str]:
    """A process that writes a bag until it kills itself or cannot write any more."""
    words = [sys.executable, "-c", WRITING, str(folder), storage, str(ticks), str(limit)]
    return subprocess.run(words, check=False, capture_output=True, text=True)


def stamps_of_rosbags(folder: Path) -> list[int]:
    with Reader(folder) as reader:
        return [stamp for _, stamp, _ in reader.messages()]


def stamps_of_mcap(folder: Path) -> list[int]:
    (path,) = folder.glob("*.mcap")
    with path.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        stamps = [message.log_time for _, _, message in reader.iter_messages()]
        assert summary.statistics.message_count == len(stamps)
        return stamps


@pytest.mark.parametrize("storage", STORED)
def test_a_killed_recorder_leaves_a_bag_for_everybody(tmp_path: Path, storage: str) -> None:
    folder = tmp_path / "flight"
    assert run(folder, storage, 2001).returncode == -signal.SIGKILL
    bag = read_bag(folder)
    stamps = bag.stamps["encoders"]
    assert stamps == [k * SENSOR for k in range(len(stamps))]
    assert stamps[-1] >= 2000 * SENSOR - SECOND // 2
    assert bag.problems == ("the recorder did not close it",)
    assert (bag.custom_data["plan"], bag.custom_data["seed"]) == ("name: lost", "7")
    assert json.loads(bag.custom_data["losses"]) == {}
    assert stamps_of_rosbags(folder) == stamps
    if storage == "mcap":
        assert stamps_of_mcap(folder) == stamps
    assert bag_state(bag, folder).readers == {"rosbags": "", **({"mcap": ""} if storage == "mcap" else {})}


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path | None]:
    """A folder with room for 2 MB, or None where nothing may be mounted."""
    folder = tmp_path / "disk"
    folder.mkdir()
    libc = ctypes.CDLL(None)
    if libc.mount(b"tmpfs", str(folder).encode(), b"tmpfs", 0, b"size=2m"):
        yield None
        return
    yield folder
    libc.umount2(str(folder).encode(), 2)


@pytest.mark.parametrize("storage", STORED)
def test_a_full_disk_ends_in_one_line_and_a_whole_bag(
    tmp_path: Path, small_disk: Path | None, storage: str
) -> None:
    for folder, limit in ((tmp_path / "limited", 1_000_000), (small_disk and small_disk / "flight", 0)):
        if folder is None:
            continue
        ended = run(folder, storage, 40_000, limit)
        assert ended.returncode == 3, ended.stderr
        assert ended.stderr == ""
        last, said = ended.stdout.strip().split("|")
        assert "the bag ends at" in said and str(folder) in said
        assert any(words in said for words in ("No space left", "File too large", "full", "disk I/O"))
        bag = read_bag(folder)
        stamps = bag.stamps["encoders"]
        assert stamps == [k * SENSOR for k in range(len(stamps))]
        assert stamps[-1] >= int(last) * SENSOR - SECOND
        assert not bag.complete
        assert stamps_of_rosbags(folder) == stamps
        if storage == "mcap":
            assert stamps_of_mcap(folder) == stamps
        write_again(bag, tmp_path / f"{folder.name}_again")
        assert read_bag(tmp_path / f"{folder.name}_again").messages == bag.messages


def test_what_is_flushed_together_is_kept_or_lost_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A batch of more than a chunk finds the disk full: no topic of it is in the bag, long as it may be."""
    draw = np.random.default_rng(1)

    def batch(first: int, count: int) -> dict[str, tuple[list[int], list[bytes]]]:
        stamps = [k * SENSOR for k in range(first, first + count)]
        layouts = {topic: TOPICS[topic].layout for topic in ("encoders", "odometry_imu")}
        return {
            topic: (stamps, [layout.pack(at, draw.standard_normal(len(layout.fields))) for at in stamps])
            for topic, layout in layouts.items()
        }

    writer = BagWriter(tmp_path / "bag")
    for topic in ("encoders", "odometry_imu"):
        writer.add_topic(topic, TOPICS[topic].layout.ros_type)
    writer.write_all(batch(0, 4))
    room, pwrite = 4 * CHUNK_BYTES, os.pwrite  # for the encoders, not for the odometry

    def write(descriptor: int, data: bytes, position: int) -> int:
        if position + len(data) > room:
            raise OSError(errno.ENOSPC, "No space left on device")
        return pwrite(descriptor, data, position)

    monkeypatch.setattr(os, "pwrite", write)
    with pytest.raises(OSError, match=r"No space left on device; the bag ends at 0\.01 s"):
        writer.write_all(batch(4, 4000))
    stamps = read_bag(tmp_path / "bag").stamps
    assert stamps == {topic: [0, SENSOR, 2 * SENSOR, 3 * SENSOR] for topic in ("encoders", "odometry_imu")}


def test_a_disk_that_is_full_from_the_start_is_refused(tmp_path: Path) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
        with pytest.raises(InputError, match="cannot be written"):
            BagWriter(tmp_path / "flight", {"plan": "x" * 1000})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


def make(folder: Path, storage: str = "mcap", seconds: int = 4) -> dict[str, list[bytes]]:
    """A closed bag whose numbers do not compress; gives its messages back."""
    import numpy as np

    rng = np.random.default_rng(1)
    written: dict[str, list[bytes]] = {"encoders": [], "rotor": []}
    with BagWriter(folder, {"seed": "1"}, storage) as writer:
        for topic in written:
            writer.add_topic(topic, TOPICS[topic].layout.ros_type)
        for stamp in range(0, seconds * SECOND, SENSOR):
            for topic in written:
                if stamp % TOPICS[topic].period_ns == 0:
                    layout = TOPICS[topic].layout
                    data = layout.pack(stamp, rng.normal(size=len(layout.fields)))
                    writer.write(topic, stamp, data)
                    written[topic].append(data)
    return written


@pytest.mark.parametrize("storage", STORAGES)
def test_every_storage_gives_everything_back(tmp_path: Path, storage: str) -> None:
    written = make(tmp_path / "flight", storage)
    bag = read_bag(tmp_path / "flight")
    assert bag.complete and bag.messages == written
    assert main(["bag", "check", str(tmp_path / "flight")]) == 0
    if storage in ("mcap", "mcap_uncompressed"):
        assert len(stamps_of_mcap(tmp_path / "flight")) == sum(map(len, written.values()))
    assert len(stamps_of_rosbags(tmp_path / "flight")) == sum(map(len, written.values()))


@pytest.mark.parametrize("storage", ["mcap", "mcap_uncompressed"])
@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.5, 0.77, 0.9, 0.999])
def test_a_cut_file_gives_every_message_before_the_cut(tmp_path: Path, storage: str, share: float) -> None:
    written = make(tmp_path / "flight", storage)
    (path,) = (tmp_path / "flight").glob("*.mcap")
    content = path.read_bytes()
    cut = int(share * len(content))
    path.write_bytes(content[:cut])
    bag = read_bag(tmp_path / "flight")
    assert not bag.complete
    for topic, found in bag.messages.items():
        assert found == written[topic][: len(found)]
    if storage == "mcap_uncompressed":
        before = {topic: sum(data in content[:cut] for data in written[topic]) for topic in written}
        assert {topic: len(bag.messages.get(topic, [])) for topic in written} == before


def test_a_cut_database_gives_its_beginning(tmp_path: Path) -> None:
    written = make(tmp_path / "flight", "sqlite3")
    (path,) = (tmp_path / "flight").glob("*.db3")
    path.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size)])
    bag = read_bag(tmp_path / "flight")
    assert not bag.complete
    assert all(found == written[topic][: len(found)] for topic, found in bag.messages.items())
    assert len(bag.messages["encoders"]) > 100
    (tmp_path / "no.db3").write_bytes(b"SQLite format 2\0")
    with pytest.raises(InputError, match="no sqlite3 file"):
        read_bag(tmp_path / "no.db3")


def test_check_says_what_is_lost_and_repairs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written = make(tmp_path / "flight")
    path = tmp_path / "flight" / "flight_0.mcap"
    path.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size)])
    damaged = path.read_bytes()
    assert main(["bag", "check", str(tmp_path / "flight"), "--json"]) == 1
    about = json.loads(capsys.readouterr().out)
    held = sum(read_bag(tmp_path / "flight").counts.values())
    assert about["unwritten"] == sum(map(len, written.values())) - held > 0
    assert about["readers"]["rosbags"] and about["readers"]["mcap"]
    assert main(["bag", "check", str(tmp_path / "flight"), "--repair", str(tmp_path / "new")]) == 1
    said = capsys.readouterr().out
    assert "not whole" in said and "cut off" in said and "had been counted" in said
    assert path.read_bytes() == damaged
    assert main(["bag", "check", str(tmp_path / "new")]) == 0
    assert read_bag(tmp_path / "new").messages == read_bag(tmp_path / "flight").messages
    assert "cut off" in read_bag(tmp_path / "new").custom_data["repaired"]
    assert len(stamps_of_mcap(tmp_path / "new")) == len(stamps_of_rosbags(tmp_path / "new")) == held


def test_an_index_that_lies_is_not_believed(tmp_path: Path) -> None:
    written = make(tmp_path / "flight")
    path = tmp_path / "flight" / "flight_0.mcap"
    content = bytearray(path.read_bytes())
    # every message index of the rotor (channel 2) leads 16 bytes too far
    place = 8
    while place + 9 <= len(content):
        length = int.from_bytes(content[place + 1 : place + 9], "little")
        if content[place] == 7 and content[place + 9] == 2:
            content[place + 9 + 6 + 8] ^= 16
        place += 9 + length
    path.write_bytes(content)
    assert read_bag(tmp_path / "flight").messages == written


def test_a_bag_compressed_as_a_whole_or_by_message_is_read(tmp_path: Path) -> None:
    import zstandard

    written = make(tmp_path / "flight", "sqlite3")
    shutil.copytree(tmp_path / "flight", tmp_path / "packed")
    path = tmp_path / "packed" / "flight_0.db3"
    path.with_name("flight_0.db3.zstd").write_bytes(zstandard.compress(path.read_bytes()))
    path.unlink()
    about = tmp_path / "packed" / "metadata.yaml"
    text = about.read_text().replace("flight_0.db3", "flight_0.db3.zstd")
    about.write_text(text.replace("compression_mode: ''", "compression_mode: FILE"))
    assert read_bag(tmp_path / "packed").messages == written
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    writer = Writer(tmp_path / "by_message", version=9, storage_plugin=StoragePlugin.SQLITE3)
    writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
    with writer:
        store = get_typestore(Stores.ROS2_JAZZY)
        connection = writer.add_connection("/rotor", "sensor_msgs/msg/JointState", typestore=store)
        for number, data in enumerate(written["rotor"]):
            writer.write(connection, number, data)
    assert read_bag(tmp_path / "by_message").messages == {"rotor": written["rotor"]}
