"""Bad input is one clear line and exit code 2, before anything moves and with nothing half-written.

So is, with exit code 3, a node for which others do not come.
"""

import dataclasses
import re
import sys

import pytest

from heli_control.controller_file import load_controller
from heli_control.motor_controller_file import load_motor_controller
from heli_flight.plan import load_plan


@pytest.fixture(scope="module", autouse=True)
def lonely_bench(shared_heli):
    """Waits for its navigation, 20 s, while the others are tested."""
    words = ("-m", "heli_bench_sim.nodes.bench_sim_node", "--ros-args", "-p", "running:=bench_sim,navigation")
    return shared_heli.start_process(sys.executable, *words)


def refused(heli, *words):
    ran = heli(*words)
    assert ran.returncode == 2, ran.stdout + ran.stderr
    assert ran.stdout == ""
    assert "Traceback" not in ran.stderr
    lines = [line for line in ran.stderr.splitlines() if line]
    assert len(lines) == 1, lines
    assert not (heli.folder / "flights").exists()
    return lines[0]


def run_node(heli, name, *parameters):
    """The one line of a node that refuses its parameters."""
    words = [word for parameter in parameters for word in ("-p", parameter)]
    process = heli.start_process(
        sys.executable, "-m", f"heli_control.nodes.{name}_node", "--ros-args", *words
    )
    out, error = process.communicate(timeout=60)
    assert (process.returncode, out) == (2, "")
    assert len(error.splitlines()) == 1
    return error


def test_an_unknown_plan_names_those_there_are(heli):
    line = refused(heli, "fly", "loop_the_loop")
    assert "loop_the_loop" in line
    assert "hover_steps" in line


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "bad.yaml"),
        ("name: [", "bad.yaml"),
        ("name: x\nabout: y\nseed: 1\ncontroller: lq\nphases: [{fly: {}}]\n", "unknown phase 'fly'"),
        ("name: x\nabout: y\nseed: -1\ncontroller: lq\nphases: [{home: {}}]\n", "seed"),
    ],
)
def test_a_bad_plan_names_file_and_key(heli, text, words):
    (heli.folder / "bad.yaml").write_text(text)
    line = refused(heli, "fly", "bad.yaml", "--mode", "inprocess")
    assert words in line
    assert "bad.yaml" in line


def test_an_unknown_controller_names_those_there_are(heli):
    line = refused(heli, "fly", "short_hover", "--controller", "autopilot")
    assert "autopilot" in line
    assert "lq" in line


def test_a_missing_or_corrupt_controller_file(heli):
    assert "absent.yaml" in refused(heli, "fly", "short_hover", "--controller", "absent.yaml")
    good = load_controller("lq").to_yaml()
    for bad, words in (
        (good[: good.index("  vertical:")], "axes"),
        (good.replace("sample_time_s: 0.01", "sample_time_s: 0.02"), "sample_time_s"),
        (good.replace("B_1s", "B_1x"), "B_1x"),
    ):
        assert bad != good
        (heli.folder / "bad.yaml").write_text(bad)
        line = refused(heli, "fly", "short_hover", "--controller", "bad.yaml", "--mode", "lockstep")
        assert words in line


def test_a_controller_for_another_plant(heli):
    other = dataclasses.replace(load_controller("lq"), plant_hash="0" * 64)
    other.write(heli.folder / "other.yaml")
    assert heli("model", "linearize", "--out", "m.yaml").returncode == 0
    line = refused(heli, "fly", "short_hover", "--plant", "m.yaml", "--controller", "other.yaml")
    assert f"other.yaml: plant.hash: '{'0' * 64}' is another plant" in line
    assert load_controller("lq").plant_hash in line
    # a node of its own says the same
    ran = run_node(heli, "attitude_controller", "controller:=other.yaml", f"plant:='{'1' * 64}'")
    assert f"other.yaml: plant.hash: '{'0' * 64}' is another plant" in ran


def test_a_wrong_controller_of_a_later_phase_is_refused_before_anything_flies(heli):
    plan = (
        load_plan("short_hover").to_yaml().replace("duration: 3.0}", "duration: 3.0, controller: nosuch}", 1)
    )
    (heli.folder / "plan.yaml").write_text(plan)
    assert "'nosuch' is no controller" in refused(heli, "fly", "plan.yaml", "--mode", "inprocess")
    assert "'nosuch' is no controller" in run_node(heli, "attitude_controller", "plan_controllers:=lq,nosuch")


def test_a_missing_or_wrong_motor_controller_file(heli):
    assert "absent.yaml" in refused(heli, "fly", "short_hover", "--motor", "absent.yaml")
    good = load_motor_controller("motor").to_yaml()
    (heli.folder / "bad.yaml").write_text(re.sub(r"^gain: .*$", "gain: -0.1", good, flags=re.MULTILINE))
    line = refused(heli, "fly", "short_hover", "--motor", "bad.yaml", "--mode", "inprocess")
    assert "bad.yaml: gain: -0.1 is out of range (allowed: 0 .. 10 V s/rad)" in line
    assert "bad.yaml: gain: -0.1" in run_node(heli, "motor_controller", "controller:=bad.yaml")


def test_a_bag_that_exists_is_not_overwritten(heli):
    (heli.folder / "elsewhere" / "x").mkdir(parents=True)
    line = refused(heli, "fly", "short_hover", "--out", "elsewhere", "--name", "x", "--mode", "inprocess")
    assert "exists already" in line
    assert list((heli.folder / "elsewhere" / "x").iterdir()) == []


def test_a_model_file_that_is_none(heli):
    (heli.folder / "model.yaml").write_text("format: heli_model/1\n")
    line = refused(heli, "design", "lq", "--model", "model.yaml", "--out", "c.yaml")
    assert "model.yaml" in line
    assert not (heli.folder / "c.yaml").exists()


def test_a_bag_that_is_none(heli):
    assert "nowhere" in refused(heli, "bag", "info", "nowhere")
    assert "nowhere" in refused(heli, "report", "nowhere")


def test_a_wrong_node_parameter(heli):
    process = heli.start_process(
        sys.executable,
        "-m",
        "heli_navigation.nodes.navigation_node",
        "--ros-args",
        "-p",
        "rotor_bandwidth:=-1.0",
    )
    out, error = process.communicate(timeout=30)
    assert process.returncode == 2
    assert out == ""
    assert "rotor_bandwidth" in error
    assert "-1.0" in error
    assert "Traceback" not in error


def test_a_bench_alone_gives_up_by_name(lonely_bench):
    _, error = lonely_bench.communicate(timeout=60)
    assert lonely_bench.returncode == 3
    assert "navigation (encoders)" in error
    assert len(error.strip().splitlines()) == 1
