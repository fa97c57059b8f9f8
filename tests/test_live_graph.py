"""`heli topic`, `node`, `param` and `service` on the real middleware: the words and numbers of ros2cli."""

import re
import shlex
import signal
import sys

import pytest

TALKER = """
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger
from heli_common.errors import InputError
from heli_common.nodes.parameters import declare_parameters, declare_request
from heli_common.nodes.qos import DATA, LATCHED
from heli_common.rig_geometry import RigGeometry

def refuse(value):
    if value == "none":
        raise InputError("no such controller", allowed="lq")

def answer(request, response):
    response.success, response.message = getattr(request, "data", True), "done"
    return response

rclpy.init()
node = rclpy.create_node("talker", namespace="left")
declare_parameters(node, RigGeometry, "rig.")
declare_request(node, "controller", "lq", "name of a controller", refuse)
node.create_service(Trigger, "home", answer)
node.create_service(SetBool, "set", answer)
joints = JointState(name=["a", "b"], position=[1.0, 0.5])
joints.header.frame_id = "rig"
publisher = node.create_publisher(JointState, "joints", DATA)
node.create_timer(0.01, lambda: publisher.publish(joints))
said = node.create_publisher(DiagnosticArray, "said", LATCHED)
said.publish(DiagnosticArray(status=[DiagnosticStatus(name="talker", message="ready")]))
node.create_subscription(JointState, "joints", lambda _: None, DATA)
print("up", flush=True)
rclpy.spin(node)
"""


REPORTS = 30
"""Of `heli topic hz`, one a second, after which the rate must have been right once."""


@pytest.fixture
def talker(heli):
    process = heli.start_process(sys.executable, "-c", TALKER)
    assert process.stdout.readline() == "up\n"
    return process


def said(heli, *commands):
    """What each command printed; all of them run at the same time and must succeed."""
    ran = [heli.start(*shlex.split(command)) for command in commands]
    answers = [(*process.communicate(timeout=60), process.returncode) for process in ran]
    assert [answer[1:] for answer in answers] == [("", 0)] * len(commands), answers
    return [answer[0] for answer in answers]


def refused(heli, *commands):
    """The one line with which each command refused."""
    ran = [heli.start(*shlex.split(command)) for command in commands]
    answers = [(*process.communicate(timeout=60), process.returncode) for process in ran]
    assert [(out, code) for out, _, code in answers] == [("", 2)] * len(commands), answers
    assert all(error.count("\n") == 1 for _, error, _ in answers)
    return [error for _, error, _ in answers]


def test_topics(heli, talker):
    names, typed, info, ends, joints, part, status = said(
        heli,
        "topic list",
        "topic list -t",
        "topic info left/joints",
        "topic info /left/joints -v",
        "topic echo /left/joints --once",
        "topic echo /left/joints --once --field header.frame_id",
        "topic echo /left/said --once",
    )
    assert names.split() == ["/left/joints", "/left/said", "/parameter_events", "/rosout"]
    assert "/left/joints [sensor_msgs/msg/JointState]\n" in typed
    assert re.match(r"Type: sensor_msgs/msg/JointState\nPublisher count: 1\nSubscription count: \d\n$", info)
    assert "\n\nPublisher count: 1\n\nNode name: talker\nNode namespace: /left\n" in ends
    assert "\n  Reliability: RELIABLE\n" in ends and "\nEndpoint type: SUBSCRIPTION\n" in ends
    assert joints == (
        "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: rig\nname:\n- a\n- b\n"
        "position:\n- 1.0\n- 0.5\nvelocity: []\neffort: []\n---\n"
    )
    assert part == "rig\n---\n"
    assert '- level: "\\0"\n  name: talker\n  message: ready\n' in status, "kept for those who come later"


def test_rates_and_sizes_until_interrupted(heli, talker):
    rate = heli.start("topic", "hz", "/left/joints", "--window", "50")
    size = heli.start("topic", "bw", "/left/joints")
    seen = 0.0
    for _ in range(REPORTS):  # messages that waited come in a burst, and the first windows are full of them
        lines = [rate.stdout.readline(), rate.stdout.readline()]
        found = re.match(r"average rate: (\d+\.\d{3})\n$", lines[0])
        assert found and re.match(
            r"\tmin: 0\.\d{3}s max: \d\.\d{3}s std dev: 0\.\d{5}s window: \d+\n$", lines[1]
        )
        seen = float(found[1])
        if 80.0 < seen < 120.0:
            break
    assert 80.0 < seen < 120.0, "100 messages a second are sent"
    assert size.stdout.readline() == "Subscribed to [/left/joints]\n"
    assert re.match(r"\d+\.\d\d KB/s from \d+ messages\n$", size.stdout.readline())
    assert re.match(
        r"\tMessage size mean: 0\.\d\d KB min: 0\.\d\d KB max: 0\.\d\d KB\n$", size.stdout.readline()
    )
    for process in (rate, size):
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0


def test_nodes_parameters_and_services(heli, talker):
    nodes, info, every, own, about, value, home, answer, services = said(
        heli,
        "node list",
        "node info /left/talker",
        "param list",
        "param list /left/talker",
        "param describe left/talker rig.forearm controller",
        "param get /left/talker rig.forearm",
        "service call /left/home std_srvs/srv/Trigger",
        "service call /left/set std_srvs/SetBool '{data: true}'",
        "service list -t",
    )
    assert nodes == "/left/talker\n"
    blocks = ["Subscribers", "Publishers", "Service Servers", "Service Clients", "Action Servers"]
    assert re.findall(r"^  (\w.*):$", info, re.MULTILINE) == [*blocks, "Action Clients"]
    assert "  Publishers:\n    /left/joints: sensor_msgs/msg/JointState\n    /left/said: " in info
    assert "    /left/home: std_srvs/srv/Trigger\n" in info
    assert every == "/left/talker:\n" + own
    assert own.startswith("  controller\n  rig.base_radius\n")
    assert about.startswith(
        "Parameter name: rig.forearm\n  Type: double\n  Description: length of a parallelogram forearm [m], "
    )
    assert "\n  Constraints:\n    Read only: true\n    Additional constraints: 0.01 .. 5\n" in about
    assert about.endswith("Type: string\n  Description: name of a controller\n  Constraints:\n")
    assert value == "Double value is: 0.9\n"
    assert home == (
        "requester: making request: std_srvs.srv.Trigger_Request()\n\n"
        "response:\nstd_srvs.srv.Trigger_Response(success=True, message='done')\n\n"
    )
    assert "making request: std_srvs.srv.SetBool_Request(data=True)\n" in answer
    assert "SetBool_Response(success=True" in answer
    assert "/left/home [std_srvs/srv/Trigger]\n" in services

    assert said(heli, "param set /left/talker controller hinf") == ["Set parameter successful\n"]
    assert said(heli, "param get /left/talker controller") == ["String value is: hinf\n"]


def test_what_is_not_there_is_refused_in_one_line(heli, talker):
    lines = refused(
        heli,
        "topic echo /left/joint --once",
        "topic echo /left/joints --field head --once",
        "node info /nobody",
        "param get /left/talker rig.fore",
        "param set /left/talker controller none",
        "param set /left/talker rig.forearm 0.8",
        "service call /left/go std_srvs/srv/Trigger",
        "service call /left/home std_srvs/srv/Trigge",
    )
    expected = [
        "heli topic: Unknown topic '/left/joint' (allowed: /left/joints",
        "heli topic: head: no field 'head' in JointState (allowed: header, name, position, velocity, effort)",
        "heli node: Unable to find node '/nobody'",
        "heli param: Parameter not set: 'rig.fore'",
        "heli param: Setting parameter failed: no such controller (allowed: lq)",
        "heli param: Setting parameter failed: ",
        "heli service: Unknown service '/left/go'",
        "heli service: type 'std_srvs/srv/Trigge' is not known here",
    ]
    assert [line[: len(start)] for line, start in zip(lines, expected, strict=True)] == expected


def test_no_graph_is_said(heli):
    lines = refused(heli, "topic list", "node list", "topic echo /imu --once")
    domain = heli.environment["ROS_DOMAIN_ID"]
    assert [line.split(" ", 2)[2] for line in lines] == [
        f"no node found in ROS_DOMAIN_ID {domain} (allowed: a running graph)\n"
    ] * 3
