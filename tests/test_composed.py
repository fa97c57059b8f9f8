"""Nodes of one process hand each other their messages; others hear them, but are not heard in their place."""

import json
import sys
from itertools import pairwise

from brief import brief

from heli_common.timing import SENSOR_PERIOD_NS

STRANGER = """
import json, sys
import rclpy
from heli_common.nodes.inbox import Inbox
from heli_common.nodes.messages import message_class
from heli_common.nodes.qos import DATA
from heli_common.topics import TOPICS

rclpy.init()
node = rclpy.create_node("stranger")
inbox = Inbox(node, ("odometry", "imu"), ("imu",))
imu, odometry = (TOPICS[topic].layout for topic in ("imu", "odometry"))
publisher = node.create_publisher(message_class(odometry.ros_type), "odometry", DATA)
stamps, said = [], []

def hear(topic, data):
    if topic == "odometry":
        said.append(odometry.stamp(data))
        return
    stamps.append(imu.stamp(data))
    if stamps[-1] % 10_000_000 == 0:  # an answer to this very sample, from nowhere
        publisher.publish(odometry.pack(stamps[-1], [0.0] * len(odometry.fields)))

print("up", flush=True)
while (taken := inbox.take(hear)) or not stamps or inbox.publisher_count("imu"):
    if not taken:
        inbox.incomplete()
        rclpy.spin_once(node, timeout_sec=0.001)
json.dump([stamps, len(said)], sys.stdout)
"""


def test_a_stranger_hears_a_composed_flight_and_does_not_disturb_it(heli):
    # long enough for a stranger that has to wait for a core of its own
    (heli.folder / "plan.yaml").write_text(brief("hover: {duration: 20.0}"))
    words = ("fly", "plan.yaml", "--json", "--no-report")
    alone = json.loads(heli(*words, "--mode", "inprocess", "--name", "alone").stdout)
    stranger = heli.start_process(sys.executable, "-c", STRANGER)
    assert stranger.stdout.readline() == "up\n"
    ran = heli(*words, "--mode", "composed", "--name", "heard", "--no-real-time-scheduling")
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout)["sha256"] == alone["sha256"]
    out, error = stranger.communicate(timeout=60)
    assert stranger.returncode == 0, error
    stamps, odometries = json.loads(out)
    steps = [after - before for before, after in pairwise(stamps)]
    assert len(steps) > 400
    assert set(steps[:400]) == {SENSOR_PERIOD_NS}
    assert min(steps) > 0  # who hears more slowly than the flight goes loses some later on
    assert odometries > 1.5 * len(stamps) / 4  # the navigation's and its own
