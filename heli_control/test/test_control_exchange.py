"""Exchange: python-control objects and .mat files there and back bit for bit; wrong files are refused."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import control
import numpy as np
import pytest
from scipy.io import loadmat, savemat

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_control.controller_file import ControllerAxis, ControllerFile, load_controller
from heli_control.exchange import (
    control_objects,
    from_control,
    read_file,
    read_mat,
    to_control,
    write_mat,
)

MODEL_PATH = Path(__file__).parent / "data" / "hover_model.yaml"
MODEL = ModelFile.read(MODEL_PATH)
LQ = load_controller("lq")


def same(one: StateSpace, two: StateSpace) -> None:
    assert (one.states, one.inputs, one.outputs) == (two.states, two.inputs, two.outputs)
    for key in "ABCD":
        assert getattr(one, key).tobytes() == getattr(two, key).tobytes()
        assert getattr(one, key).shape == getattr(two, key).shape


def static_controller() -> ControllerFile:
    """Without states: matrices of no rows, and of no columns."""
    vertical = StateSpace(
        (),
        ("w", "r"),
        ("theta_0", "theta_t"),
        np.zeros((0, 0)),
        np.zeros((0, 2)),
        np.zeros((2, 0)),
        np.eye(2),
    )
    return replace(LQ, vertical=ControllerAxis(vertical, np.zeros((0, 2))))


def test_control_objects_have_the_names_and_come_back() -> None:
    made = control_objects(MODEL)
    assert set(made) >= {"horizontal", "vertical"}
    assert made["horizontal"].input_labels == ["B_1s", "A_1s"]
    assert made["horizontal"].isctime()
    back, period = from_control(made["horizontal"])
    assert period is None
    same(back, MODEL.horizontal)
    for controller in (LQ, static_controller()):
        for axis, system in control_objects(controller).items():
            back, period = from_control(system)
            assert period == 0.01
            same(back, getattr(controller, axis).system)


def test_control_computes_with_them() -> None:
    omega = np.array([1.0, 10.0])
    theirs = to_control(MODEL.horizontal)(1j * omega)
    pencil = 1j * omega[:, None, None] * np.eye(8) - MODEL.horizontal.A
    ours = MODEL.horizontal.C @ np.linalg.solve(pencil, np.array([MODEL.horizontal.B] * 2))
    np.testing.assert_allclose(np.moveaxis(theirs, 2, 0), ours, rtol=1e-9)


def test_wrong_objects_are_refused() -> None:
    with pytest.raises(InputError, match="TransferFunction is no state space"):
        from_control(control.tf([1], [1, 1]))
    with pytest.raises(InputError, match=r"dt: True is no sample time"):
        from_control(control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], True))
    with pytest.raises(InputError, match="not finite"):
        from_control(control.ss([[np.nan]], [[1.0]], [[1.0]], [[0.0]]))


@pytest.mark.parametrize("file", [MODEL, LQ, static_controller()], ids=["model", "lq", "static"])
def test_mat_files_come_back_bit_for_bit(file: ModelFile | ControllerFile, tmp_path: Path) -> None:
    path = tmp_path / "one.mat"
    write_mat(file, path)
    back = read_mat(path)
    assert type(back) is type(file)
    assert json.dumps(back.mapping()) == json.dumps(file.mapping())
    if isinstance(file, ModelFile):
        assert isinstance(back, ModelFile)
        assert back.plant_hash == file.plant_hash
    other = tmp_path / "two.mat"
    write_mat(back, other)
    assert other.read_bytes() == path.read_bytes()


def test_extreme_numbers_survive(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    a = rng.standard_normal((3, 3)) * 10.0 ** rng.integers(-300, 300, (3, 3)).astype(float)
    a[0] = [-0.0, 5e-324, 1.7976931348623157e308]
    system = replace(MODEL.vertical, states=("w", "r", "s"), A=a, B=np.ones((3, 2)), C=np.ones((2, 3)))
    write_mat(replace(MODEL, vertical=system), tmp_path / "one.mat")
    back = read_mat(tmp_path / "one.mat")
    assert isinstance(back, ModelFile)
    same(back.vertical, system)


def test_what_another_tool_finds(tmp_path: Path) -> None:
    path = tmp_path / "lq.mat"
    write_mat(LQ, path)
    found = loadmat(path, simplify_cells=True)
    horizontal = found["horizontal"]
    np.testing.assert_array_equal(horizontal["D"], LQ.horizontal.system.D)
    np.testing.assert_array_equal(horizontal["anti_windup"], LQ.horizontal.anti_windup)
    assert list(horizontal["outputs"]) == ["B_1s", "A_1s"]
    assert horizontal["dt"] == 0.01
    assert found["operating_point"]["theta_0"] == LQ.operating_point.theta_0
    assert found["format"] == "heli_controller/2"
    assert set(found["operating_point"]) == set(asdict(LQ.operating_point))


def test_either_kind_of_file_is_read() -> None:
    assert isinstance(read_file(MODEL_PATH), ModelFile)
    with pytest.raises(InputError, match="cannot be read"):
        read_file(Path("nowhere.yaml"))


def changed(tmp_path: Path, **changes: object) -> Path:
    """A .mat file of the LQ controller with variables replaced, or left out for None."""
    path = tmp_path / "changed.mat"
    write_mat(LQ, path)
    found = {key: value for key, value in loadmat(path).items() if not key.startswith("__")}
    found = {key: value for key, value in (found | changes).items() if value is not None}
    savemat(path, found)
    return path


def test_wrong_mat_files_are_refused_in_one_line(tmp_path: Path) -> None:
    text = tmp_path / "text.mat"
    text.write_text("no matrices here\n" * 20)
    empty = tmp_path / "empty.mat"
    empty.write_bytes(b"")
    newer = tmp_path / "newer.mat"
    newer.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + b"\x89HDF" + bytes(400))
    cut = tmp_path / "cut.mat"
    write_mat(LQ, cut)
    cut.write_bytes(cut.read_bytes()[:700])
    for path, words in (
        (tmp_path / "nowhere.mat", "cannot be read"),
        (text, "is no .mat file"),
        (empty, "is no .mat file"),
        (newer, "is a .mat file of version 7.3"),
        (cut, "is no .mat file"),
        (changed(tmp_path, format="heli_model/9"), "format: 'heli_model/9' is another format"),
    ):
        with pytest.raises(InputError) as caught:
            read_mat(path)
        assert words in str(caught.value)
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)


def test_wrong_contents_are_refused_by_their_key(tmp_path: Path) -> None:
    whole = {"states": [["a"]], "inputs": [["w"]], "outputs": [["theta_0"]], "dt": 0.01}
    for changes, words in (
        ({"vertical": None}, "axes.vertical: is missing"),
        ({"surplus": 1.0}, "surplus: unknown key"),
        ({"sample_time_s": 0.02}, r"dt: 0\.01 \(allowed: 0\.02\)"),
        ({"horizontal": 3.0}, r"horizontal\.dt: None"),
        ({"provenance": "{"}, "provenance: '{' is no JSON"),
        ({"operating_point": np.eye(2)}, "operating_point: .* cannot be used"),
        ({"vertical": whole | {"A": [[1j]]}}, r"vertical\.A: .* cannot be used"),
        ({"vertical": whole | {"A": [[1.0]]}}, r"vertical.*is missing"),
    ):
        with pytest.raises(InputError, match=words):
            read_mat(changed(tmp_path, **changes))
