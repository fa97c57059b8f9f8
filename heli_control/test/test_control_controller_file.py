from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from heli_common.errors import InputError
from heli_common.linear_model import OperatingPoint, StateSpace
from heli_control.controller_file import ControllerAxis, ControllerFile, load_controller, shipped_controllers

POINT = OperatingPoint(
    theta_0=0.169, theta_t=0.195, phi=-0.0944, theta=-0.0069, B_1s=0.0065, A_1s=0.0005, a_1p=0.0093,
    b_1p=0.0007, V_i=4.22, V_t=6.34, M_A=0.821, U_mot=5.54, I_motor=54.7, Omega=163.363,
)  # fmt: skip


def gain(inputs: tuple[str, ...], outputs: tuple[str, ...]) -> ControllerAxis:
    p, m = len(outputs), len(inputs)
    empty = (np.zeros((0, 0)), np.zeros((0, m)), np.zeros((p, 0)))
    return ControllerAxis(StateSpace((), inputs, outputs, *empty, np.full((p, m), 1 / 3)), np.zeros((0, p)))


def controller() -> ControllerFile:
    horizontal = gain(("theta", "phi", "u", "v", "u_ref", "v_ref"), ("B_1s", "A_1s"))
    lag = StateSpace(
        ("slow",), ("w", "w_ref", "r"), ("theta_0", "theta_t"),
        np.array([[0.9]]), np.array([[0.1, -0.1, 0.0]]), np.array([[1.0], [0.0]]), np.eye(2, 3),
    )  # fmt: skip
    vertical = ControllerAxis(lag, np.array([[0.1, 0.0]]))
    return ControllerFile(
        "mixed", "lq", "hover", "0" * 64, POINT, horizontal, vertical, {"by": "hand", "n": [1, 2]}
    )


def test_file_comes_back_bit_for_bit(tmp_path: Path) -> None:
    before = controller()
    before.write(tmp_path / "a.yaml")
    after = ControllerFile.read(tmp_path / "a.yaml")
    assert after.mapping() == before.mapping()
    assert after.horizontal.system.D.tobytes() == before.horizontal.system.D.tobytes()
    assert after.vertical.anti_windup.tobytes() == before.vertical.anti_windup.tobytes()
    assert after.horizontal.anti_windup.shape == (0, 2)
    assert after.to_yaml() == (tmp_path / "a.yaml").read_text()
    assert after.operating_point == POINT


def test_provenance_may_be_missing(tmp_path: Path) -> None:
    document = controller().mapping()
    del document["provenance"]
    (tmp_path / "a.yaml").write_text(yaml.safe_dump(document))
    assert ControllerFile.read(tmp_path / "a.yaml").provenance == {}


def _change(document: dict[str, Any], key: str, value: Any) -> None:
    *parents, last = key.split(".")
    for parent in parents:
        document = document[parent]
    if value is KeyError:
        del document[last]
    else:
        document[last] = value


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("format", "heli_controller/9", "format: 'heli_controller/9' is another format (allowed: heli_cont"),
        ("format", "heli_controller/1", "is another format (allowed: heli_controller/2)"),
        ("format", "heli_model/1", "is another format"),
        ("name", 3, "name: 3 is no name"),
        ("kind", "", "kind: '' is no name"),
        ("plant", "hover", "plant: 'hover' is no mapping"),
        ("plant.hash", KeyError, "plant.hash: is missing"),
        ("plant.colour", "red", "plant.colour: unknown key"),
        ("sample_time_s", 0.02, "sample_time_s: 0.02 (allowed: 0.01)"),
        ("sample_time_s", "0.01", "sample_time_s: '0.01' (allowed: 0.01)"),
        ("sample_time_s", KeyError, "sample_time_s: is missing"),
        ("operating_point.phi", math.nan, "operating_point.phi: nan is not finite"),
        ("axes", [], "axes: [] is no mapping"),
        ("axes.vertical", KeyError, "axes.vertical: is missing"),
        ("axes.sideways", {}, "axes.sideways: unknown key (allowed: horizontal, vertical)"),
        ("axes.vertical.D", KeyError, "axes.vertical.D: is missing"),
        ("axes.vertical.A", [[0.9, 0.0]], "axes.vertical.A[0]: holds 2 numbers (allowed: 1 rows of 1 numb"),
        ("axes.vertical.B", [[0.1, -0.1, math.inf]], "axes.vertical.B[0][2]: inf is not finite"),
        ("axes.vertical.anti_windup", KeyError, "axes.vertical.anti_windup: is missing"),
        ("axes.vertical.anti_windup", [[0.1]], "anti_windup[0]: holds 1 numbers (allowed: 1 rows of 2"),
        ("axes.vertical.anti_windup", [], "axes.vertical.anti_windup: holds 0 rows (allowed: 1 rows of 2"),
        ("axes.vertical.anti_windup", [[0.1, math.nan]], "vertical.anti_windup[0][1]: nan is not finite"),
        ("axes.horizontal.anti_windup", [[0.0, 0.0]], "anti_windup: holds 1 rows (allowed: 0 rows"),
        ("axes.vertical.E", [[0.1, 0.0]], "axes.vertical.E: unknown key"),
        ("axes.vertical.inputs", ["w", "w", "r"], "axes.vertical.inputs[1]: 'w' occurs twice"),
        ("axes.vertical.inputs", ["w", "W", "r"], "axes.vertical.inputs[1]: unknown signal 'W' (allowed: th"),
        ("axes.vertical.outputs", ["theta_0", "U_mot"], "axes.vertical.outputs[1]: unknown signal 'U_mot'"),
        ("axes.vertical.outputs", ["theta_0", "B_1s"], "axes.vertical.outputs[1]: 'B_1s' occurs twice"),
        ("provenance", 7, "provenance: 7 is no mapping"),
        ("comment", "x", "comment: unknown key"),
    ],
)
def test_bad_entry_is_named_with_file_key_and_value(tmp_path: Path, key: str, value: Any, words: str) -> None:
    path = tmp_path / "bad.yaml"
    document = controller().mapping()
    _change(document, key, value)
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(InputError) as caught:
        ControllerFile.read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", [None, "a: [1", "[]", "just words"])
def test_missing_and_corrupt_files_are_refused(tmp_path: Path, text: str | None) -> None:
    path = tmp_path / "corrupt.yaml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=r"corrupt\.yaml"):
        ControllerFile.read(path)


def test_every_command_is_given_once() -> None:
    with pytest.raises(InputError, match="axes: no axis gives 'theta_t'"):
        replace(controller(), vertical=gain(("w",), ("theta_0",)))
    with pytest.raises(InputError, match=r"axes\.vertical\.outputs\[0\]: 'A_1s' occurs twice"):
        replace(controller(), vertical=gain(("w",), ("A_1s",)))


def test_a_controller_for_another_plant_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    controller().write(path)
    assert load_controller(str(path), "0" * 64).name == "mixed"
    with pytest.raises(InputError) as refused:
        load_controller(str(path), "1" * 64)
    said = f"{path}: plant.hash: '{'0' * 64}' is another plant (hover) (allowed: {'1' * 64})"
    assert str(refused.value) == said


def test_controllers_are_found_by_name_or_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "lq" in shipped_controllers()
    assert load_controller("lq").kind == "lq"
    controller().write(tmp_path / "lq")
    assert load_controller(str(tmp_path / "lq")).name == "mixed"
    monkeypatch.chdir(tmp_path)
    assert load_controller("lq").name == "mixed"
    with pytest.raises(
        InputError, match=r"'nosuch' is no controller \(allowed: a file, or one of gst, gst2, lq"
    ):
        load_controller("nosuch")
