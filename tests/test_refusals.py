"""Bad input is one clear line and exit code 2, before anything moves and with nothing half-written."""

import sys

import pytest

from heli_control.controller_file import load_controller


def refused(heli, *words):
    ran = heli(*words)
    assert ran.returncode == 2, ran.stdout + ran.stderr
    assert ran.stdout == ""
    assert "Traceback" not in ran.stderr
    lines = [line for line in ran.stderr.splitlines() if line]
    assert len(lines) == 1, lines
    assert not (heli.folder / "flights").exists()
    return lines[0]


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
