"""Reports: self-contained, quick, and honest about flights that are incomplete."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

import pytest
import synthetic_flight as synthetic

from heli_common.errors import InputError
from heli_flight.bag import BagWriter
from heli_flight.cli import bag as bag_command
from heli_flight.cli import report as report_command
from heli_flight.figures import flight_figure
from heli_flight.flight_record import FlightRecord
from heli_flight.plan import load_plan
from heli_flight.report import write_report

KEYS = {
    *("steps", "hover", "position", "attitude", "velocity", "commands", "rotor"),
    *("spectra", "estimation", "imu"),
}


@pytest.fixture(scope="module")
def flights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the bags `steps`, `other`, `cut`, `grounded` and `empty`."""
    folder = tmp_path_factory.mktemp("flights")
    synthetic.write_flight(folder / "steps", load_plan("hover_steps"))
    synthetic.write_flight(folder / "other", controller="loop_shaping_2dof", wander=0.004, seed=5)
    synthetic.write_flight(folder / "cut", until=17.0, without=("velocity_reference", "rotor"))
    synthetic.write_flight(folder / "grounded", until=3.0)
    BagWriter(folder / "empty").close()
    return folder


def command(*arguments: str) -> int:
    parser = argparse.ArgumentParser(prog="heli")
    subparsers = parser.add_subparsers()
    report_command.add_parser(subparsers)
    bag_command.add_parser(subparsers)
    parsed = parser.parse_args(arguments)
    return int(parsed.func(parsed))


def plain(page: str) -> str:
    """The page without its scripts."""
    return re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)


def test_a_whole_flight(flights: Path, tmp_path: Path) -> None:
    report = write_report([flights / "steps"], tmp_path / "out")
    assert report.page == tmp_path / "out" / "report.html"
    assert report.pictures == () and not list((tmp_path / "out").glob("*.png"))
    assert set(re.findall(r'id="plot-(\w+)"', report.page.read_text())) == KEYS
    page = plain(report.page.read_text())
    for words in (
        "hover_steps",
        "Steps",
        "Provenance",
        "late commands",
        "lq",
        "gust_xy",
        "run_down",
        "heli_controller/2",
        "Commands against limits",
        "Errors of the navigation",
        "Sampling and losses",
        "The air stood still",
    ):
        assert words in page
    assert "What is missing" not in page
    (summary,) = report.summaries
    assert summary["provenance"]["flight_sha256"] in page
    assert json.loads((tmp_path / "out" / "metrics.json").read_text()) == report.summaries
    assert len(summary["metrics"]["steps"]) == 4


def test_the_page_needs_nothing_else(flights: Path, tmp_path: Path) -> None:
    page = write_report([flights / "other"], tmp_path / "page.html").page
    assert page == tmp_path / "page.html"
    text = page.read_text()
    assert not re.search(r"<(script|img|iframe)[^>]+src=[\"'](?!data:)", text)
    assert not re.search(r"<link[^>]+href=[\"'](?!data:)", plain(text))
    assert "Plotly.newPlot" in text
    for data in re.findall(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL):
        assert {"data", "layout"} <= set(json.loads(data))


def test_a_static_page_is_small_and_without_scripts(
    flights: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command("report", str(flights / "other"), "--out", str(tmp_path), "--static") == 0
    out = capsys.readouterr().out
    assert "report.html" in out and "overshoot" in out
    page = (tmp_path / "report.html").read_text()
    assert "<script" not in page and page.count("data:image/png;base64,") == len(KEYS)
    pictures = {path for path in tmp_path.iterdir() if path.suffix not in (".html", ".json")}
    assert {path.name for path in pictures} == {f"{key}.{kind}" for key in KEYS for kind in ("png", "svg")}
    starts = {".png": b"\x89PNG", ".svg": b"<?xml"}
    assert all(path.read_bytes().startswith(starts[path.suffix]) for path in pictures)
    assert len(page) < 2_000_000


def test_several_flights(flights: Path, tmp_path: Path) -> None:
    report = write_report([flights / "steps", flights / "other"], tmp_path)
    assert [summary["name"] for summary in report.summaries] == ["lq", "loop_shaping_2dof"]
    page = plain(report.page.read_text())
    assert "2 flights" in page and "loop_shaping_2dof" in page
    assert "Parameters that differ" in page and "All parameters are the same." in page
    assert "loop_shaping_2dof, 95 %" in report.page.read_text()
    same = write_report([flights / "cut", flights / "grounded"], tmp_path / "same", static=True)
    assert [summary["name"] for summary in same.summaries] == ["cut", "grounded"]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cut", ["topic velocity_reference is empty", "topic rotor is empty", "no hover", "flying"]),
        ("grounded", ["never flying", "no hover", "did not end in stopped but in homing"]),
    ],
)
def test_an_incomplete_flight_says_what_is_missing(
    flights: Path, tmp_path: Path, name: str, words: list[str]
) -> None:
    report = write_report([flights / name], tmp_path)
    page = plain(report.page.read_text())
    assert "What is missing" in page
    for word in words:
        assert word in page
    json.dumps(report.summaries, allow_nan=False)


def test_a_cut_bag_still_gives_a_report(flights: Path, tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    content = next((flights / "steps").glob("*.mcap")).read_bytes()
    (tmp_path / "bag" / "bag_0.mcap").write_bytes(content[: len(content) // 2])
    report = write_report([tmp_path / "bag"], tmp_path / "out")
    page = plain(report.page.read_text())
    assert "cut off" in page and "metadata.yaml is missing" in page
    assert report.summaries[0]["provenance"]["plan"] == "hover_steps"


def test_a_name_cannot_break_the_page(tmp_path: Path) -> None:
    evil = "</script><script>alert(1)</script>"
    writer = synthetic.write_flight(tmp_path / "flight", controller=evil, until=15.0)
    other = synthetic.write_flight(tmp_path / "other", until=15.0)
    page = write_report([writer.folder, other.folder], tmp_path / "out").page.read_text()
    assert evil not in page


def test_figures_hold_limits_and_references(flights: Path) -> None:
    records = [FlightRecord.load(flights / "steps")]
    figures = {key: flight_figure(key, records, ["steps"]) for key in ("position", "commands", "rotor")}
    assert [curve.role for curve in figures["position"].panels[2].curves] == [
        "estimate",
        "truth",
        "reference",
    ]
    assert figures["commands"].panels[0].limits == (-10.0, 10.0)
    assert figures["rotor"].panels[1].limits == (0.0, 10.0)
    assert [band.label for band in figures["position"].bands] == [
        "homing",
        "run-up",
        "flying",
        "landing",
        "run-down",
    ]


def test_wrong_folders(flights: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such bag"):
        write_report([tmp_path / "nothing"], tmp_path)
    with pytest.raises(InputError, match="no bag given"):
        write_report([], tmp_path)
    with pytest.raises(InputError, match=r"empty: holds no message of a flight"):
        write_report([flights / "empty"], tmp_path)
    synthetic.write_flight(tmp_path / "blind", until=15.0, without=("ground_truth",))
    with pytest.raises(InputError, match=r"blind: cannot be compared: nothing of ground_truth"):
        write_report([flights / "steps", tmp_path / "blind"], tmp_path)
    assert not list(tmp_path.glob("*.html"))
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_report([flights / "grounded"], tmp_path / "file" / "below", static=True)


def test_report_command(flights: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    both = ("report", str(flights / "other"), "--compare", str(flights / "steps"), "--out", str(tmp_path))
    assert command(*both, "--json") == 0
    assert [each["name"] for each in json.loads(capsys.readouterr().out)] == ["loop_shaping_2dof", "lq"]
    assert command("report", str(flights / "grounded"), "--static", "--json") == 0
    (summary,) = json.loads(capsys.readouterr().out)
    assert summary["metrics"]["steps"] == []
    assert (flights / "grounded" / "report" / "report.html").exists()


def test_bag_info_command(flights: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("bag", "info", str(flights / "steps")) == 0
    out = capsys.readouterr().out
    assert "complete" in out and "ground_truth" in out and "sha256" in out
    assert command("bag", "info", "--json", str(flights / "cut")) == 0
    about = json.loads(capsys.readouterr().out)
    assert about["complete"] and len(about["sha256"]) == 64
    topics = {topic["topic"]: topic for topic in about["topics"]}
    assert topics["rotor"]["messages"] == 0 and topics["encoders"]["lost"] == 0


def test_bag_info_of_a_bag_with_another_layout(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with BagWriter(tmp_path / "flight") as writer:
        writer.add_topic("rotor", "sensor_msgs/msg/JointState")
        writer.write("rotor", 0, b"\0\1\0\0 something else")
    assert command("bag", "info", str(tmp_path / "flight")) == 0
    assert "no hash: rotor" in capsys.readouterr().out


def test_bag_compare_command(flights: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("bag", "compare", str(flights / "steps"), str(flights / "steps")) == 0
    assert "the same flight" in capsys.readouterr().out
    assert command("bag", "compare", str(flights / "steps"), str(flights / "cut")) == 1
    assert "different: " in capsys.readouterr().out


def test_every_option_has_help(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["report", "--help"], ["bag", "info", "--help"], ["bag", "compare", "--help"]):
        with pytest.raises(SystemExit):
            command(*arguments)
        assert "None" not in capsys.readouterr().out
