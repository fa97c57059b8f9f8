"""`heli export` and `heli import`: there and back, and bad input in one line with exit code 2."""

from pathlib import Path

import pytest

from heli_control.controller_file import ControllerFile, shipped_controllers
from heli_flight.cli.main import main

LQ = shipped_controllers()["lq"]


def test_there_and_back_is_the_same_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mat, back = tmp_path / "lq.mat", tmp_path / "back.yaml"
    assert main(["export", str(LQ), "--to", "mat", "--out", str(mat)]) == 0
    assert main(["import", str(mat), "--out", str(back)]) == 0
    assert capsys.readouterr().out == f"mat {mat}\ncontroller {back}\n"
    assert back.read_text() == ControllerFile.read(LQ).to_yaml()


def test_bad_input_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    for words in (["import", str(LQ)], ["export", str(tmp_path / "nowhere.yaml")]):
        assert main([*words, "--out", str(out)]) == 2
        message = capsys.readouterr().err
        assert message.startswith(f"heli {words[0]}: {words[1]}")
        assert message.count("\n") == 1
        assert not out.exists()
