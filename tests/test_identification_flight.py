"""Flights with an identification: known excitation, loss in flight.

That they are the same in every way of running: `test_ways_of_running.py`.
"""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from brief import brief

from heli_common.topics import TOPICS, data_topics
from heli_flight.flight_record import FlightRecord
from heli_flight.plan import parse_plan
from heli_flight.process_table import processes
from heli_flight.replay_check import replay
from heli_identification.excitation import CHANNELS, samples

EXCITED = brief(
    "excite: {signal: prbs, channels: [B_1s, A_1s], amplitude_deg: 0.8, band_rad_s: [2, 12], duration: 4.0}",
    "excite: {signal: doublets, channel: v, amplitude_m_s: 0.2, hold: 0.5, duration: 2.5, fade: 0.2}",
    seed=4,
)
"""Cyclic and reference excited one after the other."""

CALM = """
name: calm
about: nothing but a hover, long enough to ask for something
seed: 4
controller: lq
phases:
  - home: {}  # long enough to be asked for something
  - run_up: {duration: 1.0}
  - take_off: {height: 0.0, speed: 0.15}  # slow: the guard stops what is asked for in a fast one
  - hover: {duration: 5.0}
  - land: {speed: 0.5}
  - run_down: {duration: 0.5}
"""

REQUEST = """
import sys
import rclpy
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
rclpy.init()
node = rclpy.create_node("somebody")
client = node.create_client(SetParameters, "identification/set_parameters")
assert client.wait_for_service(20.0)
value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=sys.argv[1])
request = SetParameters.Request(parameters=[Parameter(name="excite", value=value)])
future = client.call_async(request)
rclpy.spin_until_future_complete(node, future, timeout_sec=20.0)
result = future.result().results[0]
print(result.successful, result.reason, flush=True)
node.destroy_node()
rclpy.try_shutdown()
"""


def fly(heli, plan, mode, name, *more):
    (heli.folder / "plan.yaml").write_text(plan)
    words = ("--mode", mode, "--name", name, "--json", "--no-report")
    ran = heli("fly", "plan.yaml", *words, *more)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def read(heli, name):
    return FlightRecord.load(heli.folder / "flights" / name)


def table(record, topic):
    stamps, values = TOPICS[topic].layout.read(record.bag.messages[topic])
    return stamps, values


def test_an_excitation_of_a_plan_is_known_exactly(heli):
    assert fly(heli, EXCITED, "inprocess", "b")["lost_messages"] == 0
    record = read(heli, "b")
    first, second = parse_plan(EXCITED).excitations
    stamps, commands = table(record, "excitation")
    state_stamps, states = table(record, "flight_state")
    number = states[:, TOPICS["flight_state"].layout.fields.index("effort.flight_state")]
    begun = [state_stamps[np.flatnonzero(number == n)[0]] for n in (1, 2)]
    at = np.searchsorted(stamps, begun)
    assert np.array_equal(commands[at[0] : at[0] + first.count, :4], samples(first)[:, :4])
    assert np.count_nonzero(commands[:, :4].any(axis=1)) <= first.count
    _, twists = table(record, "reference_excitation")
    right = -twists[at[1] : at[1] + second.count, 1]  # y to the left in messages
    assert np.array_equal(right, samples(second)[:, CHANNELS.index("v")])
    # the servos follow the sum: what the blades do differs from the command by the excitation
    _, servo = table(record, "servo_command")
    _, blades = table(record, "actuator_state")
    span = slice(at[0] + 50, at[0] + first.count - 50)
    later = slice(span.start + 4, span.stop + 4)
    moved = (blades[later, 0] - servo[span, 0]) - (blades[later, 0] - servo[span, 0]).mean()
    assert np.corrcoef(moved, commands[span, 0])[0, 1] > 0.8
    # and the estimate has learnt from it
    stamps, estimate = table(record, "estimate")
    assert np.all(np.diff(stamps) == TOPICS["estimate"].period_ns)
    names = TOPICS["estimate"].layout.fields
    m_1, sigma = (estimate[-1, names.index(f"{part}.M_1")] for part in ("position", "effort"))
    assert m_1 > 5.0 * sigma > 0.0
    for node in ("identification", "position_controller"):
        assert all(topic.same for topic in replay(record.bag, node))


def test_an_idle_identification_changes_no_byte_of_the_others(heli):
    plan = brief("hover: {duration: 2.0}", seed=4)
    fly(heli, plan, "inprocess", "with", "--with", "identification")
    fly(heli, plan, "inprocess", "without")
    one, other = read(heli, "with").bag, read(heli, "without").bag
    assert set(one.messages) - set(other.messages) == {
        *("excitation", "reference_excitation", "motor_excitation", "estimate")
    }
    for topic in data_topics():
        assert one.messages[topic] == other.messages[topic], topic
    assert not table(read(heli, "with"), "excitation")[1].any()


def ask(heli, text):
    ran = subprocess.run(
        [sys.executable, "-c", REQUEST, text],
        env=heli.environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return ran.stdout.strip()


def processes_of(parent):
    """Living children of a process by the last word of their module."""
    found = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent_id = int(stat.read_text().rpartition(")")[2].split()[1])
            words = (stat.parent / "cmdline").read_bytes().decode().split("\0")
        except OSError:
            continue
        if parent_id == parent and len(words) > 2:
            found[words[2].rpartition(".")[2]] = int(stat.parent.name)
    return found


@pytest.mark.alone
def test_a_request_in_flight_and_the_loss_of_the_node_in_real_time(heli, wait_for):
    (heli.folder / "plan.yaml").write_text(CALM)
    words = ("--mode", "realtime", "--name", "b", "--no-report", "--with", "identification")
    flight = heli.start("fly", "plan.yaml", *words)
    wait_for(lambda: any(path.stat().st_size > 150_000 for path in heli.folder.glob("flights/*/*.mcap")))
    nodes = processes_of(flight.pid)
    assert len(nodes) == len(processes(identified=True))
    request = "{signal: noise, channel: A_1s, amplitude_deg: 0.5, band_rad_s: [1, 12], duration: 60}"
    assert ask(heli, request).startswith("False excite: not possible while homing (allowed: while flying)")
    wait_for(lambda: ask(heli, request) == "True")
    assert ask(heli, request).startswith("False excite: an excitation acts already")
    bag = heli.folder / "flights" / "b"
    before = sum(path.stat().st_size for path in bag.glob("*.mcap"))
    wait_for(lambda: sum(path.stat().st_size for path in bag.glob("*.mcap")) > before + 600_000)
    os.kill(nodes["identification_node"], signal.SIGKILL)
    out, error = flight.communicate(timeout=90)
    assert flight.returncode == 0, error
    assert "identification: killed by signal 9; the flight goes on without it" in error
    assert out.startswith("flown: ")
    record = read(heli, "b")
    _, commands = table(record, "excitation")
    assert np.count_nonzero(commands[:, 1]) > 50
    assert not commands[:, [0, 2, 3]].any()
    stamps, _ = table(record, "excitation")
    flown, _ = table(record, "flight_state")
    assert stamps[-1] < flown[-1]
    assert record.bag.complete
    assert int(record.custom_data["late_excitation"]) > 100
