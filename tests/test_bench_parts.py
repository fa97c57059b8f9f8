"""Parts of the bench exchanged and broken: helicopters, IMU, wind, faults.

That wind, gusts, faults and parameter files are the same in every way of running: `test_ways_of_running.py`.
"""

import json
import subprocess
import sys

import numpy as np
import pytest
from brief import brief

from heli_bench_sim.bench import Bench
from heli_bench_sim.imu import ImuReading
from heli_bench_sim.simulator import BenchSimulator
from heli_common.topics import TOPICS
from heli_control.controller_file import load_controller
from heli_flight.components import controllers, supervisor
from heli_flight.flight_record import FlightRecord
from heli_flight.in_process import InProcessGraph
from heli_flight.plan import parse_plan

FAULTS = """
room: gusty
faults:
  - {kind: supply_sag, voltage_fraction: 0.3, at_s: 17.5, for_s: 0.35}
  - {kind: imu_bias_jump, axis: gyro_z, size_deg_s: 3.0, at_s: 18.5}
  - {kind: encoder_lost_counts, encoder: yaw, counts: 3, at_s: 19.5}
"""
DIP = brief("hover: {duration: 8.0, wind_m_s: 0.0, wind_to_m_s: 3.0}", home=7.5, seed=3, more=FAULTS)
"""The supply sags for a moment in hover, in wind from the front and with gusts."""

REQUEST = """
import sys
import rclpy
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
rclpy.init()
node = rclpy.create_node("somebody")
client = node.create_client(SetParameters, "bench_sim/set_parameters")
assert client.wait_for_service(20.0)
for text in sys.argv[1:]:
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
    request = SetParameters.Request(parameters=[Parameter(name="fault", value=value)])
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=20.0)
    result = future.result().results[0]
    print(result.successful, result.reason, flush=True)
node.destroy_node()
rclpy.try_shutdown()
"""


def fly(heli, plan, mode, name, *more):
    ran = heli("fly", plan, "--mode", mode, "--name", name, "--json", "--no-report", *more)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def read(heli, name):
    return FlightRecord.load(heli.folder / "flights" / name)


def series(record, topic, field):
    stamps, values = TOPICS[topic].layout.read(record.bag.messages[topic])
    return stamps * 1e-9, values[:, TOPICS[topic].layout.fields.index(field)]


def test_wind_gusts_and_faults_of_a_plan_are_visible(heli):
    (heli.folder / "dip.yaml").write_text(DIP)
    (heli.folder / "narrow.yaml").write_text(
        "bench_sim: {ros__parameters: {helicopter: {fade_fraction: 0.9}, room: {strength_x: 1.0, "
        "strength_y: 1.0, strength_z: 0.3, strength_yaw: 0.3}}}\n"  # calm enough to find the height
    )
    fly(heli, "dip.yaml", "inprocess", "dip", "--params-file", "narrow.yaml")
    record = read(heli, "dip")
    assert record.custom_data["regime_underspeed"].startswith("underspeed: rotor speed [rad/s] 14")
    time, sag = series(record, "bench_condition", "position.supply_sag")
    assert np.allclose(time[sag > 0.0][[0, -1]], [17.5, 17.84])
    time, bias = series(record, "bench_condition", "position.gyro_z")
    jump = bias[np.searchsorted(time, 18.6)] - bias[np.searchsorted(time, 18.4)]
    assert np.isclose(np.degrees(jump), -3.0, atol=0.1)  # to the left in messages
    _, lost = series(record, "bench_condition", "position.encoder_lost_counts")
    assert lost[0] == 0.0 and lost[-1] == 8.0
    _, fan = series(record, "bench_condition", "position.fan")
    assert 1.5 < fan.max() < 3.0
    _, north = series(record, "wind", "vector.y")
    assert north.min() < -1.0


@pytest.mark.alone
def test_a_fault_by_service_on_the_running_graph(heli, wait_for):
    (heli.folder / "plan.yaml").write_text(brief())
    first = heli.start("fly", "plan.yaml", "--mode", "realtime", "--name", "b", "--no-report", "--json")
    wait_for(lambda: any(path.stat().st_size > 150_000 for path in heli.folder.glob("flights/*/*.mcap")))
    asked = subprocess.run(
        [sys.executable, "-c", REQUEST, "coffee_spilled", "imu_dropout for_s=0.5"],
        env=heli.environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    refused, taken = asked.stdout.strip().splitlines()
    assert refused.startswith("False fault.kind: 'coffee_spilled' is unknown (allowed: encoder_stuck")
    assert taken == "True"
    _, error = first.communicate(timeout=90)
    assert first.returncode == 0, error
    _, dropped = series(read(heli, "b"), "bench_condition", "position.imu_dropout")
    assert np.isclose(np.count_nonzero(dropped) * 0.01, 0.5)
    _, validity = series(read(heli, "b"), "imu", "angular_velocity_covariance[0]")
    assert np.isclose(np.count_nonzero(validity < 0.0) * 0.0025, 0.5)


def test_two_helicopters_from_parameter_files_fly_the_same_plan(heli):
    text = "bench_sim: {{ros__parameters: {{helicopter: {{mass: {}, drag_area: {}}}}}}}\n"
    (heli.folder / "plan.yaml").write_text(brief("hover: {duration: 3.0}"))
    loads = {}
    for name, mass, drag in (("light", 7.2, 0.1), ("heavy", 7.4, 0.3)):
        (heli.folder / f"{name}.yaml").write_text(text.format(mass, drag))
        fly(heli, "plan.yaml", "inprocess", name, "--params-file", f"{name}.yaml")
        time, collective = series(read(heli, name), "actuator_state", "position.theta_0")
        hover = (time > 14.5) & (time < 16.5)
        loads[name] = np.degrees(collective[hover].mean())
    assert loads["heavy"] - loads["light"] > 0.08


class CalmImu:
    """A user's own IMU: no vibration, no bias, no noise."""

    def sample(self, truth):
        return ImuReading(truth.rates, truth.specific_force)


def test_a_flight_with_a_user_s_own_imu(tmp_path):
    plan, seen = parse_plan(brief("hover: {duration: 3.0}")), {"imu": [], "ground_truth": []}

    def look(topic, stamp_ns, data):
        if topic in seen:
            seen[topic].append((stamp_ns, TOPICS[topic].layout.unpack(data)[1]))

    bench = BenchSimulator(Bench(seed=plan.seed, imu=CalmImu()))
    leader = supervisor(plan)
    graph = InProcessGraph(bench, [leader, *controllers(load_controller(plan.controller))], look)
    while bench.ended_at is None:
        graph.advance()
    assert leader.reason == ""
    truth = dict(seen["ground_truth"])
    gyro = {stamp: values[13:16] for stamp, values in seen["imu"]}
    for stamp, values in truth.items():
        assert gyro[stamp] == values[46:49]
