"""Which controller flies: said by the plan, by a parameter while flying, or a node of one's own."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from brief import brief

from heli_common.model_file import ModelFile
from heli_control.controller_file import load_controller
from heli_control.lq import LqWeights, design_lq
from heli_flight.flight_record import FlightRecord, motion_of

ROOT = Path(__file__).resolve().parents[1]
MODEL = ModelFile.read(ROOT / "heli_control/test/data/hover_model.yaml")
TEMPLATE = ROOT / "docs/templates/my_controller_node.py"

SWITCH = brief(
    "hover: {duration: 4.0}",
    "hover: {duration: 2.0, controller: stiff.yaml}",
    "hover: {duration: 2.0, controller: lq}",
)
STEP = brief("step: {axis: x, amplitude: 0.10, duration: 3.0}")

REQUEST = """
import sys
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from std_msgs.msg import String
from heli_common.nodes.qos import LATCHED
rclpy.init()
node = rclpy.create_node("somebody")
said, stage = [], []
node.create_subscription(String, "state", lambda message: stage.append(message.data), LATCHED)
def hear(message):
    stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
    said.extend((stamp, status.message) for status in message.status if status.name == "attitude_controller")
node.create_subscription(DiagnosticArray, "diagnostics", hear, 100)
client = node.create_client(SetParameters, "attitude_controller/set_parameters")
assert client.wait_for_service(20.0)
while "flying" not in stage:
    rclpy.spin_once(node, timeout_sec=1.0)
for text in sys.argv[1:]:
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
    request = SetParameters.Request(parameters=[Parameter(name="controller", value=value)])
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=20.0)
    result = future.result().results[0]
    print(result.successful, result.reason, flush=True)
while not said:
    rclpy.spin_once(node, timeout_sec=1.0)
print(*said[0], flush=True)
node.destroy_node()
rclpy.try_shutdown()
"""


def stiff(folder, **changes):
    weights = replace(LqWeights(), u=3.0, v=1.5, w=0.4)
    replace(design_lq(MODEL, weights), name="stiff", **changes).write(folder / "stiff.yaml")


def fly(heli, plan, mode, name, *more):
    ran = heli("fly", plan, "--mode", mode, "--name", name, "--json", "--no-report", *more)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def read(heli, name):
    return FlightRecord.load(heli.folder / "flights" / name)


def test_controllers_of_a_plan_fly_and_move_the_helicopter_little(heli):
    stiff(heli.folder)
    (heli.folder / "switch.yaml").write_text(SWITCH)
    assert fly(heli, "switch.yaml", "inprocess", "b")["controller"] == "lq, stiff"
    record = read(heli, "b")
    origins = json.loads(record.custom_data["controllers"])
    assert [origin["name"] for origin in origins] == ["lq", "stiff"]
    assert origins[0]["sha256"] != origins[1]["sha256"]
    assert {origin["plant_hash"] for origin in origins} == {MODEL.plant_hash}
    series = record.series["flight_state"]
    number = series.column("position.controller")
    changes = series.stamps[1:][np.diff(number) != 0.0]
    assert len(changes) == 2
    motion = motion_of(record.series["ground_truth"])
    hover = (motion.stamps >= changes[0]) & (motion.stamps < changes[0] + 4_000_000_000)
    moved = np.linalg.norm(motion.position[hover] - motion.position[hover][0], axis=1)
    assert moved.max() < 0.02
    for node in ("attitude_controller", "motor_controller"):
        again = heli("replay", str(heli.folder / "flights/b"), "--into", node)
        assert again.returncode == 0, again.stdout + again.stderr


@pytest.mark.alone
def test_another_controller_by_service_while_flying(heli):
    stiff(heli.folder)
    (heli.folder / "worse.yaml").write_text(load_controller("lq").to_yaml().replace("[w, r,", "[w, z,"))
    other = replace(load_controller("lq"), plant_hash="0" * 64)
    other.write(heli.folder / "other.yaml")
    model = heli.folder / "model.yaml"
    MODEL.write(model)
    words = ["--mode", "realtime", "--name", "b", "--no-report", "--json", "--plant", str(model)]
    (heli.folder / "step.yaml").write_text(STEP)
    first = heli.start("fly", "step.yaml", *words)
    paths = [str(heli.folder / name) for name in ("worse.yaml", "other.yaml", "stiff.yaml")]
    asked = subprocess.run(
        [sys.executable, "-c", REQUEST, "autopilot", *paths],
        env=heli.environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    unknown, worse, another, taken, told = asked.stdout.strip().splitlines()
    assert unknown.startswith(
        "False controller: 'autopilot' is no controller (allowed: a file, or one of gst"
    )
    assert worse.startswith(f"False {paths[0]}: axes.vertical.inputs[1]: unknown signal 'z'")
    expected = f"False {paths[1]}: plant.hash: '{'0' * 64}' is another plant (thesis_linearized) (allowed: "
    assert another.startswith(expected + MODEL.plant_hash)
    assert taken.strip() == "True"
    stamp, *words = told.split()
    assert words == ["controller", "stiff", "flies"]
    assert int(stamp) % 10_000_000 == 0 < int(stamp)
    out, error = first.communicate(timeout=90)
    assert first.returncode == 0, error
    assert json.loads(out)["ended"] == "flown"


def test_a_node_of_ones_own_flies(heli):
    assert len(TEMPLATE.read_text().splitlines()) <= 60
    (heli.folder / "step.yaml").write_text(STEP)
    flight = fly(heli, "step.yaml", "lockstep", "mine", "--replace", f"attitude_controller={TEMPLATE}")
    assert flight["lost_messages"] == 0
    (step,) = flight["metrics"]["steps"]
    assert step["rise_time_s"] < 2.0
    assert abs(step["final_error_m"]) < 0.01
    assert step["overshoot_percent"] < 10.0
    # it is another program that flew, with rounded gains
    assert flight["sha256"] != fly(heli, "step.yaml", "inprocess", "ours")["sha256"]


def test_a_program_in_place_of_a_node_is_refused_by_name(heli):
    for mode, word, said in (
        ("lockstep", "autopilot=x.py", "--replace: 'autopilot' is no node (allowed: bench_sim, navigation"),
        ("lockstep", "navigation=absent.py", "--replace navigation: 'absent.py' is no file (allowed: NODE=P"),
        ("inprocess", f"navigation={TEMPLATE}", "--replace: in mode inprocess (allowed: realtime, lockstep"),
    ):
        ran = heli("fly", "short_hover", "--mode", mode, "--replace", word)
        assert ran.returncode == 2
        assert said in ran.stderr
        assert len(ran.stderr.splitlines()) == 1
    assert not (heli.folder / "flights").exists()
