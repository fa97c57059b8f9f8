"""A flight on the graph ends safely and in order: interrupted, a node lost, a command that is no number."""

import os
import signal
import sys
from pathlib import Path
from time import monotonic

import pytest

from heli_flight.bag_reader import read_bag

ROGUE = """
import rclpy
from heli_common.nodes.messages import message_class
from heli_common.nodes.qos import DATA
from heli_common.topics import TOPICS
rclpy.init()
node = rclpy.create_node("rogue")
layout = TOPICS["servo_command"].layout
publisher = node.create_publisher(message_class(layout.ros_type), "servo_command", DATA)
while publisher.get_subscription_count() < 2:
    rclpy.spin_once(node, timeout_sec=0.05)
publisher.publish(layout.pack(0, [float("nan")] + [0.0] * 11))
publisher.wait_for_all_acked()
node.destroy_node()
rclpy.try_shutdown()
"""


def children(parent):
    """Process ids of the living children of a process, with their command lines."""
    found = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
            line = (stat.parent / "cmdline").read_bytes().decode().replace("\0", " ")
        except OSError:
            continue
        if int(fields[1]) == parent and fields[0] != "Z":
            found[int(stat.parent.name)] = line
    return found


def patient(heli):
    """Parameters of a bench that bears with late commands, because other programs load beside the flight."""
    file = heli.folder / "patient.yaml"
    file.write_text("bench_sim:\n  ros__parameters:\n    watch:\n      silence: 5.0\n")
    return file


def messages(bag):
    return sum(read_bag(bag).counts.values())


def flying(folder):
    """Whether the recorder has written messages: a bag with nothing but its definitions is smaller."""
    return any(path.stat().st_size > 150_000 for path in folder.glob("flights/*/*.mcap"))


def test_interrupted_while_loading(heli, wait_for):
    process = heli.start("fly", "hover_steps", "--mode", "inprocess", "--name", "b")
    # the interpreter itself is up when it has mapped the project's first compiled dependency
    wait_for(lambda: "numpy" in Path(f"/proc/{process.pid}/maps").read_text(), pause=0.005)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=10)
    assert process.returncode == 130
    assert "Traceback" not in error


@pytest.mark.alone
def test_interrupted_in_the_background_of_a_shell(heli, wait_for):
    """A shell starts what it puts into the background with SIGINT ignored."""
    script = (
        f"'{sys.executable}' -m heli_flight.cli.main fly hover_steps --name b --no-report & echo $!; wait $!"
    )
    shell = heli.start_process("sh", "-c", script)
    pid = int(shell.stdout.readline())
    wait_for(lambda: flying(heli.folder))
    os.kill(pid, signal.SIGINT)
    shell.communicate(timeout=10)
    assert shell.returncode == 130
    assert read_bag(heli.folder / "flights" / "b").complete


@pytest.mark.alone
@pytest.mark.parametrize("moment", ["starting", "flying"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_at_any_moment(heli, wait_for, moment, number):
    process = heli.start("fly", "hover_steps", "--mode", "realtime", "--name", "b", "--no-report")
    wait_for(lambda: len(children(process.pid)) == 7)
    if moment == "flying":
        wait_for(lambda: flying(heli.folder))
    nodes = children(process.pid)
    process.send_signal(number)
    asked = monotonic()
    process.wait(10.0)
    assert monotonic() - asked < 3.0
    assert process.returncode == 130
    for pid in nodes:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
    if moment == "flying":
        bag = read_bag(heli.folder / "flights" / "b")
        assert bag.complete
        assert bag.counts["encoders"] > 100


@pytest.mark.alone
@pytest.mark.parametrize("node", ["navigation", "attitude_controller"])
def test_a_killed_node_stops_the_flight_by_name(heli, wait_for, node):
    """The recorder's loss: `test_recorder_loss.py`."""
    process = heli.start("fly", "hover_steps", "--mode", "realtime", "--name", "b", "--no-report")
    wait_for(lambda: flying(heli.folder))
    (victim,) = [pid for pid, line in children(process.pid).items() if f"{node}_node" in line]
    os.kill(victim, signal.SIGKILL)
    _, error = process.communicate(timeout=15)
    assert process.returncode == 3
    assert f"{node}: killed by signal 9" in error
    bag = read_bag(heli.folder / "flights" / "b")
    assert bag.counts["encoders"] > 100
    assert bag.complete


@pytest.mark.alone
def test_a_command_that_is_no_number_stops_the_motor(heli, wait_for):
    words = ["--mode", "realtime", "--name", "b", "--params-file", str(patient(heli)), "--no-report"]
    process = heli.start("fly", "short_hover", *words)
    wait_for(lambda: flying(heli.folder))
    rogue = heli.start_process(sys.executable, "-c", ROGUE)
    _, error = process.communicate(timeout=30)
    rogue.wait(10)
    assert process.returncode == 3
    said = "bench_sim: servo_command: position.B_1s is nan at 0.00 s; motor switched off"
    assert said in error
    assert read_bag(heli.folder / "flights" / "b").custom_data["result"] == said


@pytest.mark.alone
def test_a_second_bench_on_the_same_graph_is_refused(heli, wait_for):
    words = ["--mode", "realtime", "--name", "first", "--params-file", str(patient(heli)), "--no-report"]
    # a flight long enough for the nodes of the second to load
    first = heli.start("fly", "short_hover", *words, "--json")
    wait_for(lambda: flying(heli.folder))
    second = heli("fly", "short_hover", "--mode", "lockstep", "--name", "second", "--no-report")
    assert second.returncode == 2
    assert "already runs on this graph" in second.stderr
    assert "Traceback" not in second.stderr
    out, error = first.communicate(timeout=60)
    assert first.returncode == 0, error
    assert '"lost_messages": 0' in out
