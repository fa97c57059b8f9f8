from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from heli_common.errors import InputError
from heli_control.controller_file import shipped_controllers
from heli_control.motor_control import MotorParameters
from heli_control.motor_controller_file import MotorControllerFile, load_motor_controller

MADE = MotorControllerFile(
    "fast", "hinf", MotorParameters(gain=1 / 3, integral_time=0.15), "bench", "a" * 64, {"gamma": 1.7}
)


def test_file_comes_back_bit_for_bit(tmp_path: Path) -> None:
    MADE.write(tmp_path / "fast.yaml")
    after = MotorControllerFile.read(tmp_path / "fast.yaml")
    assert after == MADE
    assert after.to_yaml() == (tmp_path / "fast.yaml").read_text()


def test_plant_and_provenance_may_be_missing(tmp_path: Path) -> None:
    document = MADE.mapping()
    del document["plant"], document["provenance"]
    (tmp_path / "fast.yaml").write_text(yaml.safe_dump(document))
    after = MotorControllerFile.read(tmp_path / "fast.yaml")
    assert (after.plant_name, after.plant_hash, after.provenance) == ("", "", {})
    assert after.parameters == MADE.parameters


def test_shipped_controller_has_the_default_drive_and_is_no_flight_controller() -> None:
    shipped, default = load_motor_controller("motor").parameters, MotorParameters()
    assert replace(shipped, gain=default.gain, integral_time=default.integral_time) == default
    # rounded by hand from the same drive, the defaults are near
    assert shipped.gain == pytest.approx(default.gain, rel=0.1)
    assert shipped.integral_time == pytest.approx(default.integral_time, rel=0.15)
    assert "motor" not in shipped_controllers()
    with pytest.raises(
        InputError, match=r"controller: 'lq' is no controller \(allowed: a file, or one of motor\)"
    ):
        load_motor_controller("lq")


def test_a_controller_for_another_plant_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "fast.yaml"
    MADE.write(path)
    assert load_motor_controller(str(path), "a" * 64) == MADE
    with pytest.raises(
        InputError, match=r"fast\.yaml: plant\.hash: 'aaaa.*' is another plant \(bench\) \(allowed: bbb"
    ):
        load_motor_controller(str(path), "b" * 64)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        (
            "format",
            "heli_controller/2",
            "format: 'heli_controller/2' is another format (allowed: heli_motor/1)",
        ),
        ("name", "", "name: '' is no name"),
        ("gain", KeyError, "gain: is missing"),
        ("gain", math.nan, "gain: nan is out of range (allowed: 0 .. 10 V s/rad)"),
        ("gain", -0.1, "gain: -0.1 is out of range (allowed: 0 .. 10 V s/rad)"),
        ("integral_time", "long", "integral_time: 'long' is not a number"),
        ("integral_gain", 1.0, "integral_gain: unknown key"),
        ("sample_time_s", 0.02, "sample_time_s: 0.02 (allowed: 0.01)"),
        ("plant", {"name": "x"}, "plant.hash: is missing"),
        ("plant", {"name": "x", "hash": 3}, "plant.hash: 3 is no name"),
        ("provenance", [], "provenance: [] is no mapping"),
    ],
)
def test_bad_entry_is_named_with_file_key_and_value(tmp_path: Path, key: str, value: Any, words: str) -> None:
    document = MADE.mapping()
    if value is KeyError:
        del document[key]
    else:
        document[key] = value
    (tmp_path / "bad.yaml").write_text(yaml.safe_dump(document))
    with pytest.raises(InputError) as refused:
        MotorControllerFile.read(tmp_path / "bad.yaml")
    assert str(refused.value).startswith(f"{tmp_path / 'bad.yaml'}: {words}")
