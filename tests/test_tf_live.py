"""The helicopter's frame on `tf`, live: 20 times a second what `ground_truth` says, as a TFMessage."""

import json
import sys

from rosbags.typesys import Stores, get_typestore

SAMPLES = 81
"""200 ms of the bench."""

PROBE = """
import json, sys
from time import monotonic
from types import ModuleType

import rclpy
from visualization_msgs.msg import MarkerArray

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # the middleware carries serialized messages of any type
    TFMessage = MarkerArray
    sys.modules["tf2_msgs"] = sys.modules["tf2_msgs.msg"] = ModuleType("tf2_msgs")
    sys.modules["tf2_msgs"].TFMessage = TFMessage

from heli_bench_sim.bench import Bench
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.nodes.rig_display import RigDisplay
from heli_bench_sim.simulator import BenchSimulator
from heli_common.topics import TOPICS

rclpy.init()
node = rclpy.create_node("bench_sim", namespace="left")
display = RigDisplay(node, BenchParameters())
heard = []
node.create_subscription(TFMessage, "/left/tf", heard.append, 50, raw=True)

def until(done):
    deadline = monotonic() + 20.0
    while not done() and monotonic() < deadline:
        rclpy.spin_once(node, timeout_sec=0.01)

until(lambda: node.count_publishers("/left/tf") and node.count_subscribers("/left/tf"))
bench, truth = BenchSimulator(Bench(BenchParameters(), 1)), {}
for _ in range(int(sys.argv[1])):
    messages = bench.tick()
    display.show(bench.stamp_ns, messages)
    truth |= {m.stamp_ns: TOPICS[m.topic].layout.pack(m.stamp_ns, m.values).hex()
              for m in messages if m.topic == "ground_truth"}
until(lambda: len(heard) == 5)
print(json.dumps([[data.hex() for data in heard], truth]))
"""


def test_the_frame_is_shown_while_somebody_looks(heli):
    probe = heli.start_process(sys.executable, "-c", PROBE, str(SAMPLES))
    out, error = probe.communicate(timeout=60)
    assert probe.returncode == 0, error
    heard, truth = json.loads(out)
    store = get_typestore(Stores.ROS2_JAZZY)
    stamps = []
    for data in heard:
        (frame,) = store.deserialize_cdr(bytes.fromhex(data), "tf2_msgs/msg/TFMessage").transforms
        stamps.append(frame.header.stamp.nanosec)
        said = store.deserialize_cdr(bytes.fromhex(truth[str(stamps[-1])]), "nav_msgs/msg/Odometry").pose.pose
        moved = frame.transform.translation
        assert (moved.x, moved.y, moved.z) == (said.position.x, said.position.y, said.position.z)
        assert frame.transform.rotation == said.orientation
        assert (frame.header.frame_id, frame.child_frame_id) == ("world", "base_link")
    assert stamps == list(range(0, 200_000_001, 50_000_000))
