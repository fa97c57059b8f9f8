"""`heli model encoders`: the table, the JSON object, the picture, and what is refused."""

import argparse
import json
import math
import struct
from dataclasses import fields
from pathlib import Path

import pytest

from heli_common.errors import EXIT_BAD_INPUT, InputError
from heli_flight.cli import main as command_line
from heli_flight.cli import model
from heli_navigation.encoder_budget import RingError


def run(*arguments: str) -> int:
    parser = argparse.ArgumentParser(prog="heli")
    model.add_parser(parser.add_subparsers(required=True))
    options = parser.parse_args(["model", "encoders", *arguments])
    return int(options.func(options))


def test_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run() == 0
    text = capsys.readouterr().out
    assert "…" not in text, "a number was cut off"
    assert "one count of one arm 2.30 mm" in text
    assert "worst in the table: 6.97 mm at height 0.45 m, radius 0.00 m" in text
    assert "yaw, pitch, roll everywhere: 3σ 0.156 deg" in text
    assert max(len(line) for line in text.splitlines()) <= 112
    # the bottom row of all, on the rim: height and radius first, azimuth last
    rows = [line.split() for line in text.splitlines() if line.startswith("│")]
    assert len(rows) == 27
    assert next(cell for cell in rows[-1] if cell != "│") == "0.50"


def test_json_is_in_si_and_says_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["figure"] is None
    assert told["count"] == pytest.approx(math.radians(0.18), rel=1e-12)
    assert told["attitude_three_sigma"] == pytest.approx(
        dict.fromkeys(("psi", "theta", "phi"), 3.0 * told["count"] / math.sqrt(12.0)), rel=1e-12
    )
    assert told["attitude_largest"] == 0.5 * told["count"]
    rings = told["position"]
    assert len(rings) == 27
    assert all(set(ring) == {field.name for field in fields(RingError)} for ring in rings)
    assert {ring["height"] for ring in rings} >= {told["work_space"]["bottom"], told["work_space"]["top"]}
    assert {ring["radius"] for ring in rings} == {0.0, 0.25, told["work_space"]["radius"]}
    assert told["worst"] == max(rings, key=lambda ring: ring["worst"])
    assert told["centre"]["per_count"] == pytest.approx(2.3e-3, abs=5e-5)
    assert (told["centre"]["height"], told["centre"]["radius"]) == (0.90, 0.0)


def test_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "deep" / "map.png"
    assert run("--json", "--out", str(path)) == 0
    assert json.loads(capsys.readouterr().out)["figure"] == str(path)
    content = path.read_bytes()
    width, height = struct.unpack(">II", content[16:24])
    assert content.startswith(b"\x89PNG") and width > 600 and height > 600
    assert len(content) > 20_000
    assert [each.name for each in path.parent.iterdir()] == ["map.png"], "a temporary file was left"
    assert run("--out", str(path)) == 0
    assert capsys.readouterr().out.endswith(f"figure {path}\n")
    assert path.read_bytes() == content, "drawn twice it differs"


@pytest.mark.parametrize("name", ["map.pdf", "map"])
def test_only_png_is_drawn_and_nothing_else_printed(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(InputError, match=r"allowed: \.png"):
        run("--out", str(tmp_path / name))
    assert capsys.readouterr().out == ""
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_one_line_and_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    path = tmp_path / "file" / "map.png"
    assert command_line.main(["model", "encoders", "--out", str(path)]) == EXIT_BAD_INPUT
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith(f"heli model: {path}: cannot write the figure: ")
    assert told.err.count("\n") == 1
    (tmp_path / "map.png").mkdir()
    with pytest.raises(InputError, match="cannot write the figure: Is a directory"):
        run("--out", str(tmp_path / "map.png"))
    assert sorted(each.name for each in tmp_path.iterdir()) == ["file", "map.png"]
