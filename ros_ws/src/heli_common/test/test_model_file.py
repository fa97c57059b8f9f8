from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from heli_common.errors import InputError
from heli_common.linear_model import OperatingPoint, StateSpace
from heli_common.model_file import ModelFile, yaml_text

FINITE = st.floats(allow_nan=False, allow_infinity=False)


def block(a: Any = ((0.0, 1.0), (-4.0, 0.0))) -> StateSpace:
    return StateSpace(("s", "v"), ("f",), ("s",), np.array(a), np.array([[0.0], [1.0]]), [[1, 0]], [[0.0]])  # type: ignore[arg-type]


def point() -> OperatingPoint:
    return OperatingPoint(
        theta_0=0.169, theta_t=0.195, phi=-0.0944, theta=-0.0069, B_1s=0.0065, A_1s=0.0005, a_1p=0.0093,
        b_1p=0.0007, V_i=4.22, V_t=6.34, M_A=0.821, U_mot=5.54, I_motor=54.7, Omega=163.363,
    )  # fmt: skip


def model(**changes: Any) -> ModelFile:
    base = ModelFile("hover", {"method": "by hand"}, point(), block(), block())
    return replace(base, **changes)


def test_undamped_oscillator_has_poles_at_plus_minus_two_i() -> None:
    np.testing.assert_allclose(block().poles, [2j, -2j])


def test_file_comes_back_bit_for_bit(tmp_path: Path) -> None:
    path = tmp_path / "hover.yaml"
    third = block([[1 / 3, 1e-300], [-0.0, 1e22]])
    before = model(horizontal=third, full=block(), drive=block())
    before.write(path)
    after = ModelFile.read(path)
    assert after.plant_hash == before.plant_hash
    assert after.source == {"method": "by hand"}
    assert after.operating_point == before.operating_point
    assert after.horizontal.A.tobytes() == third.A.tobytes()
    assert after.full is not None
    assert after.drive is not None
    after.write(tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_bytes() == path.read_bytes()


@settings(deadline=None, max_examples=40)
@given(arrays(np.float64, (2, 2), elements=FINITE))
def test_any_float_survives_the_text(matrix: Any) -> None:
    text = yaml_text({"A": matrix.tolist()})
    assert np.array(yaml.safe_load(text)["A"], dtype=np.float64).tobytes() == matrix.tobytes()


def test_hash_knows_every_number_but_not_the_name() -> None:
    reference = model().plant_hash
    assert len(reference) == 64
    assert model(name="other", source={}).plant_hash == reference
    assert model(operating_point=replace(point(), Omega=163.0)).plant_hash != reference
    assert model(vertical=block([[0.0, 1.0], [-4.0, 1e-15]])).plant_hash != reference
    assert model(full=block()).plant_hash != reference


def test_block_without_states_is_a_matrix(tmp_path: Path) -> None:
    gain = StateSpace((), ("a", "b"), ("c",), np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((1, 0)), [[1, 2]])  # type: ignore[arg-type]
    model(drive=gain).write(tmp_path / "gain.yaml")
    read = ModelFile.read(tmp_path / "gain.yaml").drive
    assert read is not None
    assert [read.A.shape, read.B.shape, read.C.shape] == [(0, 0), (0, 2), (1, 0)]
    assert read.D.tolist() == [[1.0, 2.0]]


def test_matrices_cannot_be_changed_from_outside() -> None:
    outside = np.array([[0.0, 1.0], [-4.0, 0.0]])
    inside = block(outside)
    outside[0, 0] = 7.0
    assert inside.A[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        inside.A[0, 0] = 7.0


def test_source_that_yaml_cannot_hold_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="YAML"):
        model(source={"when": object()}).write(tmp_path / "x.yaml")
    assert list(tmp_path.iterdir()) == []


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
        ("format", "heli_model/2", "format: 'heli_model/2' is another format (allowed: heli_model/1)"),
        ("format", KeyError, "format: None is another format"),
        ("name", "", "name: '' is no name"),
        ("source", [1], "source: [1] is no mapping"),
        ("horizontal", KeyError, "horizontal: is missing"),
        ("horizontal.A", KeyError, "horizontal.A: is missing"),
        ("horizontal.E", [[1.0]], "horizontal.E: unknown key (allowed: states, inputs"),
        ("sideways", {}, "sideways: unknown key"),
        ("vertical", 3, "vertical: 3 is no mapping"),
        ("vertical.states", ["s", "s"], "vertical.states[1]: 's' occurs twice"),
        ("vertical.states", ["s", 1], "vertical.states[1]: 1 is no name"),
        ("vertical.inputs", "f", "vertical.inputs: 'f' is no list"),
        ("vertical.A", [[1.0, 2.0]], "vertical.A: holds 1 rows (allowed: 2 rows of 2 numbers)"),
        ("vertical.A", [[1.0, 2.0], [3.0]], "vertical.A[1]: holds 1 numbers"),
        ("vertical.B", 1.0, "vertical.B: holds 1.0"),
        ("vertical.B", [[1.0], ["1e-5"]], "vertical.B[1][0]: '1e-5' is not a number"),
        ("vertical.D", [[math.nan]], "vertical.D[0][0]: nan is not finite"),
        ("vertical.D", [[math.inf]], "vertical.D[0][0]: inf is not finite"),
        ("vertical.D", [[True]], "vertical.D[0][0]: True is not a number"),
        ("vertical.D", [[10**400]], "is not finite"),
        ("operating_point.Omega", KeyError, "operating_point.Omega: is missing"),
        ("operating_point.Omega", "fast", "operating_point.Omega: 'fast' is not a number"),
        ("operating_point.omega", 1.0, "operating_point.omega: unknown key"),
    ],
)
def test_bad_entry_is_named_with_file_key_and_value(tmp_path: Path, key: str, value: Any, words: str) -> None:
    path = tmp_path / "bad.yaml"
    model().write(path)
    document = yaml.safe_load(path.read_text())
    _change(document, key, value)
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(InputError) as caught:
        ModelFile.read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", [None, "a: [1", "- 1\n", "\x00"])
def test_missing_and_corrupt_files_are_refused(tmp_path: Path, text: str | None) -> None:
    path = tmp_path / "corrupt.yaml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=r"corrupt\.yaml"):
        ModelFile.read(path)
