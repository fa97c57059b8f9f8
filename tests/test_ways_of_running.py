"""One plan and one seed give the same bytes in process, in lockstep and, if nothing is late, in real time."""

import json

PLAN = "short_hover"


def fly(heli, mode, name, *more):
    ran = heli("fly", PLAN, "--mode", mode, "--name", name, "--json", "--no-report", *more)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def test_in_process_and_lockstep_give_the_same_bytes_twice(heli):
    flights = [fly(heli, mode, f"{mode}_{turn}") for turn in (1, 2) for mode in ("inprocess", "lockstep")]
    assert len({flight["sha256"] for flight in flights}) == 1
    assert all(len(flight["sha256"]) == 64 for flight in flights)
    assert all(flight["lost_messages"] == 0 for flight in flights)
    assert all(set(flight["late_commands"].values()) <= {0} for flight in flights)
    assert flights[0]["metrics"] == {**flights[1]["metrics"], "flight": flights[0]["metrics"]["flight"]}


def test_real_time_loses_nothing_and_has_the_lockstep_hash_unless_late(heli):
    flight = fly(heli, "realtime", "r")
    assert flight["lost_messages"] == 0
    assert flight["wall_s"] >= flight["simulated_s"]
    assert set(flight["late_commands"]) == {"late_servo_command", "late_motor_command", "late_flight_state"}
    if not any(flight["late_commands"].values()):
        assert flight["sha256"] == fly(heli, "inprocess", "p")["sha256"]


def test_a_parameter_file_means_the_same_in_both_ways(heli):
    text = "/**/bench_sim: {ros__parameters: {helicopter.mass: 7.4}}\n"
    text += "/**/position_controller: {ros__parameters: {gain_x: 1.5}}\n"
    (heli.folder / "heavy.yaml").write_text(text)
    flights = [fly(heli, mode, mode, "--params-file", "heavy.yaml") for mode in ("inprocess", "lockstep")]
    flights.append(fly(heli, "inprocess", "plain"))
    assert flights[0]["sha256"] == flights[1]["sha256"] != flights[2]["sha256"]
