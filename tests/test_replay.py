"""A recorded bag, played into a live node, gives the recorded outputs back byte by byte."""

import json
import sys

import pytest
from brief import brief

from heli_flight.bag_reader import read_bag
from heli_flight.process_table import NODE_NAMES
from heli_flight.replay_check import replay
from heli_flight.replay_components import requests_of

LISTENER = """
import sys
from heli_common.nodes.runner import ComponentProgram, run_node

class Listener:
    name, inputs, outputs, heard = "supervisor", ("odometry", "rotor_state"), (), 0

class Program(ComponentProgram):
    def on_message(self, topic, data):
        if topic == "odometry":
            print(data.hex(), flush=True)
            self.component.heard += 1
            self.finished = self.component.heard == int(sys.argv[1])

sys.exit(run_node("supervisor", lambda *_: Program(Listener()), sys.argv[2:]))
"""


@pytest.fixture(scope="module")
def flown(shared_heli):
    """Folder of the bag that is played."""
    (shared_heli.folder / "plan.yaml").write_text(brief("hover: {duration: 2.0}"))
    ran = shared_heli("fly", "plan.yaml", "--mode", "inprocess", "--name", "b", "--no-report")
    assert ran.returncode == 0, ran.stderr
    return shared_heli.folder / "flights/b"


def test_navigation_repeats_its_odometry(heli, flown):
    bag = read_bag(flown)
    expected = bag.messages["odometry"]
    running = ("--ros-args", "-p", "running:=replay,navigation,supervisor")
    listener = heli.start_process(sys.executable, "-c", LISTENER, str(len(expected)), *running)
    heli.start_process(sys.executable, "-m", "heli_navigation.nodes.navigation_node", *running)
    player = heli.start_process(
        *(sys.executable, "-m", "heli_flight.nodes.replay_node", str(flown), *running),
        *("-p", "topics:=encoders,imu,rotor", "-p", "rate:=2.0"),
    )
    out, _ = listener.communicate(timeout=60)
    heard = [bytes.fromhex(line) for line in out.split()]
    assert heard == expected
    assert player.wait(10) == 0


def test_replay_refuses_what_is_not_there(heli):
    for words, said in (
        (["nowhere"], "nowhere"),
        (["--ros-args", "-p", "bag:=nowhere", "-p", "rate:=-1.0"], "rate"),
        ([], "no folder given"),
    ):
        player = heli.start_process(sys.executable, "-m", "heli_flight.nodes.replay_node", *words)
        _, error = player.communicate(timeout=30)
        assert player.returncode == 2
        assert said in error
        assert len(error.strip().splitlines()) == 1


PANEL = """
import sys
import rclpy
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("panel")
clock = []
node.create_subscription(Clock, "clock", lambda m: clock.append(m.clock.sec + 1e-9 * m.clock.nanosec), 1000)

def ask(kind, name, request):
    client = node.create_client(kind, name)
    assert client.wait_for_service(30.0), name
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=10.0)
    return future.result()

def press(name):
    return ask(Trigger, f"replay/{name}", Trigger.Request())

def rate(value):
    request = SetParameters.Request(parameters=[Parameter("rate", value=value).to_parameter_msg()])
    return ask(SetParameters, "replay/set_parameters", request).results[0]

def listen(seconds):
    end = node.get_clock().now().nanoseconds + int(seconds * 1e9)
    while node.get_clock().now().nanoseconds < end:
        rclpy.spin_once(node, timeout_sec=0.05)

assert press("is_paused").success
assert not clock
while not press("play_next").success:  # the player looks for another one of its name first
    listen(0.05)
assert press("play_next").success
listen(0.3)
assert [round(seconds, 4) for seconds in clock] == [10.0, 10.01], clock
assert press("resume").success
assert not press("is_paused").success and not press("play_next").success
assert not rate(1000.0).successful and "0.01 .. 100" in rate(1000.0).reason
assert rate(0.5).successful
listen(1.0)
assert press("toggle_paused").success
listen(0.3)
count = len(clock)
listen(0.5)
assert len(clock) == count > 10
assert 10.1 < clock[-1] < 11.5, clock[-1]
assert rate(20.0).successful and press("resume").success
listen(3.0)
assert abs(clock[-1] - 13.0) < 1e-9, clock[-1]
assert all(b > a for a, b in zip(clock, clock[1:]))
print("as asked")
node.destroy_node()
rclpy.try_shutdown()
"""

ASKING = """
import sys
import rclpy
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("asking")
now = [0.0]
node.create_subscription(
    JointState, "flight_state", lambda m: now.append(m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec), 100
)
clients = {
    name: node.create_client(SetParameters, f"{name}/set_parameters")
    for name in ("attitude_controller", "bench_sim", "identification")
}
land = node.create_client(Trigger, "land")
for client in (*clients.values(), land):
    assert client.wait_for_service(60.0)

def until(seconds):
    while now[-1] < seconds:
        rclpy.spin_once(node, timeout_sec=0.1)

def ask(name, key, value):
    request = SetParameters.Request(parameters=[Parameter(key, value=value).to_parameter_msg()])
    future = clients[name].call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=20.0)
    result = future.result().results[0]
    assert result.successful, result.reason

until(13.0)
ask("attitude_controller", "controller", "gst2")
ask("identification", "excite", "{signal: prbs, channel: B_1s, amplitude_deg: 0.3, "
    "band_rad_s: [0.5, 12], duration: 5.0}")
ask("bench_sim", "fault", "supply_sag voltage_fraction=0.95 for_s=1")
until(15.0)
ask("identification", "excite", "")
future = land.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, future, timeout_sec=20.0)
assert future.result().success
print("asked")
node.destroy_node()
rclpy.try_shutdown()
"""


def test_replay_pauses_steps_and_changes_its_rate(heli, flown):
    part = "--start-offset 10 --duration 3 --topics rotor,reference"
    words = [str(flown), "--start-paused", *part.split()]
    player = heli.start_process(sys.executable, "-m", "heli_flight.nodes.replay_node", *words)
    panel = heli.start_process(sys.executable, "-c", PANEL)
    said, error = panel.communicate(timeout=80)
    assert said == "as asked\n", error
    assert player.wait(20) == 0
    assert "paused at 10.010 s" in player.stdout.read()


def test_a_flight_in_which_everything_was_asked_for_is_repeated(heli):
    (heli.folder / "plan.yaml").write_text(brief("hover: {duration: 20.0}"))
    words = ("--mode", "lockstep", "--name", "b", "--no-report", "--with", "identification")
    # ordinary scheduling: else the flight would be over before a program of that priority has asked
    flight = heli.start("fly", "plan.yaml", *words, "--json", "--no-real-time-scheduling")
    asking = heli.start_process(sys.executable, "-c", ASKING)
    said, error = asking.communicate(timeout=80)
    assert said == "asked\n", error
    out, error = flight.communicate(timeout=80)
    assert flight.returncode == 0, error
    about = json.loads(out)
    assert about["simulated_s"] < 25.0  # landed when asked to
    assert about["lost_messages"] == 0 and set(about["late_commands"].values()) == {0}
    bag = read_bag(heli.folder / "flights" / "b")
    asked = {node: len(requests_of(bag, node)) for node in NODE_NAMES}
    assert {node: count for node, count in asked.items() if count} == {
        "attitude_controller": 1,
        "bench_sim": 1,
        "identification": 2,
        "supervisor": 1,
    }
    for node in NODE_NAMES:
        if node != "recorder":
            assert all(topic.same for topic in replay(bag, node)), node
