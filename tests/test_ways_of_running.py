"""One plan and one seed give the same bytes in process, in lockstep and, if nothing is late, in real time."""

import json

import pytest
from brief import brief

from heli_control.controller_file import load_controller

FAULTS = """
room: gusty
faults:
  - {kind: encoder_lost_counts, encoder: yaw, counts: 3, at_s: 10.0}
  - {kind: imu_bias_jump, axis: gyro_z, size_deg_s: 3.0, at_s: 9.0}
  - {kind: supply_sag, voltage_fraction: 0.3, at_s: 8.2, for_s: 0.35}
  - {kind: encoder_stuck, encoder: arm_1, at_s: 11.6, for_s: 0.1}
"""
GUSTY = brief(
    "hover: {duration: 0.7, wind_m_s: 0.0, wind_to_m_s: 3.0}",
    "hover: {duration: 0.5, controller: own.yaml}",
    seed=3,
    controller="gst2",
    more=FAULTS,
)
"""In wind and gusts, with faults; in the end another controller flies, from a file."""
CALM = (
    "bench_sim: {ros__parameters: {helicopter: {fade_fraction: 0.9}, room: {strength_x: 1.0, "
    "strength_y: 1.0, strength_z: 0.3, strength_yaw: 0.3}}}\n"
)
EXCITED = brief(
    "excite: {signal: prbs, channels: [B_1s, A_1s], amplitude_deg: 0.5, band_rad_s: [1, 12], "
    "duration: 1.5, fade: 0.5}",
    "excite: {signal: doublets, channel: v, amplitude_m_s: 0.1, hold: 0.25, duration: 1.0, fade: 0.2}",
    seed=4,
)
"""With the identification: blade angles and the velocity reference are excited one after the other."""
STEP = brief("hover: {duration: 2.0}", "step: {axis: x, amplitude: 0.10, duration: 2.0}")


def fly(heli, mode, name, *more, plan=STEP):
    (heli.folder / "plan.yaml").write_text(plan)
    ran = heli("fly", "plan.yaml", "--mode", mode, "--name", name, "--json", "--no-report", *more)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def needed(heli):
    """Write the files that the gusty plan names; returns words for those it flies with."""
    load_controller("lq").write(heli.folder / "own.yaml")
    (heli.folder / "calm.yaml").write_text(CALM)
    return ("--params-file", "calm.yaml")


def verified(heli, text, *more):
    (heli.folder / "plan.yaml").write_text(text)
    ran = heli("verify", "plan.yaml", "--json", *more, patience=300.0)  # many flights, some under load
    assert ran.returncode == 0, ran.stderr + ran.stdout
    said = json.loads(ran.stdout)
    assert said["same"]
    assert len({flight["sha256"] for flight in said["flights"]}) == 1
    assert all(len(flight["sha256"]) == 64 for flight in said["flights"])
    assert {flight["way"] for flight in said["flights"]} == {"lockstep", "composed", "inprocess"}
    assert not any(flight["reason"] for flight in said["flights"])
    return said["flights"]


def test_a_gusty_flight_with_a_fault_is_the_same_in_every_way_twice_and_under_load(heli):
    flights = verified(heli, GUSTY, *needed(heli))
    assert [flight["loaded"] for flight in flights] == [False] * 6 + [True] * 3


def test_a_flight_that_excites_is_the_same_in_every_way_with_and_without_load(heli):
    assert len(verified(heli, EXCITED, "--times", "1")) == 6


@pytest.mark.parametrize("mode", [pytest.param("realtime", marks=pytest.mark.alone), "realtime_composed"])
def test_real_time_loses_nothing_and_has_the_lockstep_hash_unless_late(heli, mode):
    calm = needed(heli)
    flight = fly(heli, mode, "r", *calm, plan=GUSTY)
    assert flight["lost_messages"] == 0
    assert flight["wall_s"] >= flight["simulated_s"]
    assert set(flight["late_commands"]) == {"late_servo_command", "late_motor_command", "late_flight_state"}
    commands = {f"latency_{topic}" for topic in ("servo_command", "motor_command", "flight_state")}
    assert set(flight["punctuality"]) == {*commands, "period_jitter"}
    for figures in flight["punctuality"].values():
        assert 0.0 <= figures["median_ms"] <= figures["p99_ms"] <= figures["p99_9_ms"] <= figures["max_ms"]
    late = any(flight["late_commands"].values())
    assert not (late and mode == "realtime_composed")  # one thread answers a sample before it takes the next
    if not late:
        assert flight["sha256"] == fly(heli, "inprocess", "p", *calm, plan=GUSTY)["sha256"]


def test_a_parameter_file_means_the_same_in_both_ways(heli):
    text = "/**/bench_sim: {ros__parameters: {helicopter.mass: 7.4}}\n"
    text += "/**/position_controller: {ros__parameters: {gain_x: 1.5}}\n"
    (heli.folder / "heavy.yaml").write_text(text)
    flights = [fly(heli, mode, mode, "--params-file", "heavy.yaml") for mode in ("inprocess", "lockstep")]
    assert all(flight["lost_messages"] == 0 for flight in flights)
    assert all(flight["punctuality"] == {} for flight in flights)
    assert all(set(flight["late_commands"].values()) <= {0} for flight in flights)
    assert flights[0]["metrics"] == {**flights[1]["metrics"], "flight": flights[0]["metrics"]["flight"]}
    flights.append(fly(heli, "inprocess", "plain"))
    assert flights[0]["sha256"] == flights[1]["sha256"] != flights[2]["sha256"]
