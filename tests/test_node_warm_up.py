"""Once a node has said that it is ready it opens, imports and compiles nothing: 7 ms of that cost a command.

Every node is built as for a flight, in a process of its own, and gets the messages of a recorded one.
"""

import json
import pickle
import subprocess
import sys
from dataclasses import replace

import pytest

from heli_common.topics import IDENTIFICATION, RECORDER, data_topics
from heli_flight.bag_reader import read_bag
from heli_flight.cli.planned import planned_order
from heli_flight.fly_graph import ros_arguments
from heli_flight.mode import Mode
from heli_flight.process_table import PROCESSES

PLAN = """
name: everything
about: A short flight with wind, gusts, a fault of each part, another controller and an excitation.
seed: 3
controller: gst2
room: gusty
faults:
  - {kind: encoder_stuck, encoder: arm_1, at_s: 11.0, for_s: 0.1}
  - {kind: imu_dropout, at_s: 11.2, for_s: 0.1}
  - {kind: servo_jam, servo: tail, at_s: 11.5, for_s: 0.02}
  - {kind: supply_sag, voltage_fraction: 0.9, at_s: 11.5, for_s: 0.02}
phases:
  - home: {duration: 8.0}
  - run_up: {duration: 2.0}
  - take_off: {height: -0.3, speed: 0.3}
  - excite: {signal: prbs, channel: B_1s, amplitude_deg: 0.5, band_rad_s: [0.5, 12], duration: 2.0}
  - hover: {duration: 1.0, wind_m_s: 3.0, controller: lq}
  - land: {speed: 0.3}
  - run_down: {duration: 2.0}
"""

PROBE = """
import json, os, pickle, sys
from importlib import import_module
from pathlib import Path
from time import monotonic
module = import_module(sys.argv[2])
import rclpy
from visualization_msgs.msg import MarkerArray
from heli_common.topics import TOPICS, data_topics

name, _, file, arguments, running = sys.argv[1:]
running = tuple(each for each in running.split(",") if each != "recorder")  # the bench would wait for it
sent = []

class Connection:
    '''Everybody is there, and nothing is heard.'''
    name, running = name, running
    inbox = type("Inbox", (), {"arrived_ns": 0})
    def absent(self): return []
    def publish(self, messages):
        for topic, stamp_ns, values in messages:
            sent.append(TOPICS[topic].layout.pack(stamp_ns, values))
    def diagnose(self, *_): pass

recorded = pickle.loads(Path(file).read_bytes())
rclpy.init()
node = rclpy.create_node(name, cli_args=json.loads(arguments), use_global_arguments=False)
program = module.build(node, running)
flown = sorted(
    (TOPICS[topic].layout.stamp(data), data_topics(running).index(topic), topic, data)
    for topic in program.inputs if topic in recorded for data in recorded[topic]
)
program.start(Connection())
if name == "bench_sim":
    node.create_subscription(MarkerArray, "markers", lambda _: None, 10)
    deadline = monotonic() + 20.0
    while not node.count_subscribers("markers") and monotonic() < deadline:
        rclpy.spin_once(node, timeout_sec=0.01)
did = []
watching = [True]
def watch(event, arguments):
    if not watching or event not in ("open", "import", "compile"):
        return
    if event != "open" or arguments[2] & os.O_ACCMODE == os.O_RDONLY:  # the recorder writes its bag
        did.append(f"{event} {arguments[0]}")
sys.addaudithook(watch)
program.turn()
for _, _, topic, data in flown:
    program.on_message(topic, data)
program.turn()
watching.clear()
print(json.dumps({"taken": len(flown), "sent": len(sent), "did": did}))
"""


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """Order of a flight and a file of its messages, which a node reads without loading anything else."""
    folder = tmp_path_factory.mktemp("flight")
    (folder / "plan.yaml").write_text(PLAN)
    words = ["fly", "plan.yaml", "--mode", "inprocess", "--out", ".", "--name", "bag", "--no-report"]
    heli = [sys.executable, "-m", "heli_flight.cli.main", *words]
    subprocess.run(heli, cwd=folder, check=True, capture_output=True, timeout=300)
    order = planned_order(str(folder / "plan.yaml"), None, None)
    messages = read_bag(folder / "bag").messages
    file = folder / "messages"
    file.write_bytes(pickle.dumps({topic: list(messages[topic]) for topic in data_topics(order.running)}))
    return replace(order, mode=Mode.LOCKSTEP), file


def test_the_plan_has_every_node(flight):
    order, _ = flight
    assert IDENTIFICATION in order.running


@pytest.mark.parametrize("process", PROCESSES, ids=lambda process: process.name)
def test_a_node_that_is_ready_loads_nothing_more(heli, flight, process):
    order, file = flight
    notes = heli.folder / "notes.json"
    notes.write_text(json.dumps(order.notes() | {"mode": "realtime"}))
    order = replace(order, bag=heli.folder / "written")
    words = ros_arguments(process, order, notes)
    command = [process.name, process.module, str(file), json.dumps(words), ",".join(order.running)]
    probe = heli.start_process(sys.executable, "-c", PROBE, *command)
    out, error = probe.communicate(timeout=120)
    assert probe.returncode == 0, error
    said = json.loads(out.splitlines()[-1])
    assert said["taken"] > 1000
    assert said["sent"] > (1000 if process.name != RECORDER else 0)
    assert not said["did"], "\n".join(said["did"])
