"""Weights in words, the weights file with its defaults, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_control.realisation import response
from heli_control.schemes import SCHEMES
from heli_control.weight import Weight, read_weight
from heli_control.weights_file import default_weights, read_weights

FINITE = st.floats(-10.0, 10.0, allow_nan=False)


def test_first_order_by_hand() -> None:
    # (2 s + 6) / (s + 3) is 2 everywhere
    weight = read_weight({"numerator": [2.0, 6.0], "denominator": [1.0, 3.0]}, None, "W")
    assert np.allclose(response(weight.system, np.array([0.0, 1.0, 50.0])), 2.0)
    assert read_weight(4, None, "W").mapping() == 4.0


@settings(deadline=None, max_examples=50, derandomize=True)
@given(st.lists(FINITE, min_size=3, max_size=3), st.floats(0.1, 10.0), st.floats(0.1, 10.0))
def test_state_space_and_polynomials_agree(numerator: list[float], one: float, other: float) -> None:
    denominator = np.polymul([1.0, one], [1.0, other]).tolist()
    weight = read_weight({"numerator": numerator, "denominator": denominator}, None, "W")
    omega = np.array([0.0, 0.3, 4.0, 70.0])
    np.testing.assert_allclose(response(weight.system, omega)[:, 0, 0], weight.at(1j * omega), atol=1e-9)
    assert read_weight(weight.mapping(), None, "W") == weight


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("three", "W: 'three' is no weight"),
        (float("nan"), "W: nan is no weight"),
        (True, "W: True is no weight"),
        ({"numerator": [1.0], "denominator": [0.0, 1.0]}, "W.denominator[0]: begins with 0"),
        ({"numerator": [1.0, 0.0, 0.0], "denominator": [1.0, 1.0]}, "is not proper"),
        ({"numerator": [1.0], "denominator": [1.0, -1.0]}, "has a pole at 1"),
        ({"numerator": [1.0], "denominator": [1.0, 0.0]}, "has a pole at 0"),
        ({"numerator": [], "denominator": [1.0]}, "W.numerator: [] is no list"),
        ({"zeros": [1.0]}, "W.zeros: unknown key"),
    ],
)
def test_wrong_weights_are_refused(value: Any, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_weight(value, None, "W")
    assert message in str(caught.value)


@pytest.mark.parametrize("kind", SCHEMES)
def test_shipped_weights_are_complete_and_survive_a_round_trip(kind: str, tmp_path: Path) -> None:
    shipped = default_weights(kind)
    assert tuple(shipped.axes) == SCHEMES[kind].axes
    path = tmp_path / "weights.yaml"
    path.write_text(yaml.safe_dump(shipped.mapping()))
    assert read_weights(kind, path) == shipped


def test_a_users_file_changes_only_what_it_names(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(
        "format: heli_weights/1\nkind: gst\nhorizontal: {W_y: {theta: 7.0}, settings: {attitude: 0.3}}\n"
    )
    mine, shipped = read_weights("gst", path), default_weights("gst")
    assert mine.axes["horizontal"].weights["W_y"]["theta"] == Weight((7.0,))
    assert mine.axes["horizontal"].weights["W_y"]["u"] == shipped.axes["horizontal"].weights["W_y"]["u"]
    assert mine.axes["horizontal"].settings["attitude"] == 0.3
    assert mine.axes["vertical"] == shipped.axes["vertical"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kind: gst", "format: None is another format"),
        ("format: heli_weights/1\nkind: ncf", "kind: 'ncf' is another kind (allowed: gst)"),
        ("format: heli_weights/1\nkind: gst\nhorizontal: {W_z: {theta: 1}}", "horizontal.W_z: unknown key"),
        ("format: heli_weights/1\nkind: gst\nhorizontal: {W_y: {psi: 1}}", "horizontal.W_y.psi: unknown key"),
        (
            "format: heli_weights/1\nkind: gst\nvertical: {scales: {w: 0}}",
            "vertical.scales.w: 0 is out of range",
        ),
        (
            "format: heli_weights/1\nkind: gst\nhorizontal: {settings: {gamma_margin: 0.9}}",
            "horizontal.settings.gamma_margin: 0.9 is out of range",
        ),
    ],
)
def test_wrong_files_are_refused_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text + "\n")
    with pytest.raises(InputError) as caught:
        read_weights("gst", path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
