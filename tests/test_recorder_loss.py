"""The recorder is killed or its disk is full while a graph flies: the bag is good up to a second before."""

import json
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from heli_flight.bag_reader import read_bag


def recorder_of(parent):
    """Process id of the recorder of a flight."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
            line = (stat.parent / "cmdline").read_bytes()
        except OSError:
            continue
        if int(fields[1]) == parent and b"recorder_node" in line:
            return int(stat.parent.name)
    raise AssertionError("no recorder")


def everybody_reads(folder):
    """Stamps in a bag by topic, the same for three readers."""
    bag = read_bag(folder)
    ours = {f"/{topic}": stamps for topic, stamps in bag.stamps.items() if stamps}
    theirs = {}
    with Reader(folder) as reader:
        for connection, stamp, _ in reader.messages():
            theirs.setdefault(connection.topic, []).append(stamp)
    assert theirs == {topic: sorted(stamps) for topic, stamps in ours.items()}
    for path in folder.glob("*.mcap"):
        theirs = {}
        with path.open("rb") as stream:
            for _, channel, message in make_reader(stream).iter_messages():
                theirs.setdefault(channel.topic, []).append(message.log_time)
        assert theirs == {topic: sorted(stamps) for topic, stamps in ours.items()}
    return bag


@pytest.mark.alone
@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_killed_recorder_leaves_all_but_the_last_second(heli, wait_for, storage):
    words = ("fly", "hover_steps", "--mode", "realtime", "--name", "b", "--no-report", "--storage", storage)
    process = heli.start(*words, "--no-real-time-scheduling")
    bag = heli.folder / "flights" / "b"

    def recorded():
        path = bag / "metadata.yaml"
        return path.exists() and read_bag(bag).stamps.get("encoders", [0])[-1:] > [2_000_000_000]

    wait_for(recorded, pause=0.2)
    before = max(read_bag(bag).stamps["encoders"])  # what another process sees while it is being recorded
    os.kill(recorder_of(process.pid), signal.SIGKILL)
    _, error = process.communicate(timeout=15)
    assert process.returncode == 3
    assert "recorder: killed by signal 9" in error
    found = everybody_reads(bag)
    assert found.problems == ("the recorder did not close it",) and not found.complete
    assert found.counts["encoders"] > 100
    ends = {topic: stamps[-1] for topic, stamps in found.stamps.items() if stamps and topic != "diagnostics"}
    assert min(ends.values()) >= before - 100_000_000
    jitter = json.loads(found.custom_data["jitter"])
    assert 0.0 < jitter["encoders"]["rms_ms"] <= jitter["encoders"]["max_ms"]
    shown = json.loads(heli("bag", "info", str(bag), "--json").stdout)
    assert {topic["topic"]: topic for topic in shown["topics"]}["encoders"]["rms_ms"] > 0.0
    assert heli("bag", "check", str(bag)).returncode == 1


@pytest.mark.parametrize("mode", ["lockstep", "inprocess"])
def test_a_full_disk_stops_the_flight_in_one_line(heli, mode):
    limit = 700_000

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    words = [sys.executable, "-m", "heli_flight.cli.main", "fly", "hover_steps"]
    flown = subprocess.run(
        [*words, "--mode", mode, "--name", "b", "--no-report"],
        cwd=heli.folder,
        env=heli.environment,
        preexec_fn=limited,
        capture_output=True,
        text=True,
        timeout=90,
        check=False,
    )
    assert flown.returncode == 3
    assert "File too large; the bag ends at" in flown.stderr
    assert "Traceback" not in flown.stderr
    bag = everybody_reads(heli.folder / "flights" / "b")
    assert not bag.complete
    ends_at = float(flown.stderr.rpartition("the bag ends at ")[2].split()[0])
    assert max(bag.stamps["encoders"]) == pytest.approx(ends_at * 1e9, abs=1e7)
    assert ends_at > 1.0
