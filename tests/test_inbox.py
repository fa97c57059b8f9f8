"""A node that was kept from running finds several bursts: the real middleware, in a process of its own."""

import json
import sys

BURSTS = 40
PROGRAM = f"""
import json, sys, time
import rclpy
from heli_common.nodes.inbox import Inbox
from heli_common.nodes.messages import message_class
from heli_common.nodes.qos import DATA
from heli_common.topics import TOPICS

rclpy.init()
node = rclpy.create_node("late")
inbox = Inbox(node, ("rotor", "encoders", "imu"), ("imu",))
layouts = {{topic: TOPICS[topic].layout for topic in ("rotor", "encoders", "imu")}}
publish = {{
    topic: node.create_publisher(message_class(layout.ros_type), topic, DATA).publish
    for topic, layout in layouts.items()
}}
deadline = time.monotonic() + 30.0
while not all(inbox.publisher_count(topic) for topic in layouts):
    assert time.monotonic() < deadline

def burst(number):
    for topic, layout in layouts.items():
        if topic != "rotor" or number % 4 == 0:
            publish[topic](layout.pack(2_500_000 * number, [0.0] * len(layout.fields)))

heard, looks = [], []
def hear(topic, data):
    heard.append((layouts[topic].stamp(data) // 2_500_000, topic))

def look(until):
    while len(heard) < until:
        assert time.monotonic() < deadline, heard
        if count := inbox.take(hear):
            looks.append(count)
        else:
            inbox.incomplete()

burst(0)
look(3)
for number in range(1, {BURSTS}):
    burst(number)
look(3 + 2 * ({BURSTS} - 1) + ({BURSTS} - 1) // 4)
json.dump([heard, looks], sys.stdout)
rclpy.shutdown()
"""


def test_what_piled_up_is_delivered_burst_by_burst(heli):
    process = heli.start_process(sys.executable, "-c", PROGRAM)
    out, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    heard, looks = json.loads(out)
    assert looks[0] == 3
    assert len(looks) < BURSTS / 2  # they really had piled up
    assert [stamp for stamp, _ in heard] == sorted(stamp for stamp, _ in heard)
    for number in range(BURSTS):
        mine = [topic for stamp, topic in heard if stamp == number]
        assert mine[-1] == "imu"
        assert sorted(mine[:-1]) == (["encoders", "rotor"] if number % 4 == 0 else ["encoders"])
