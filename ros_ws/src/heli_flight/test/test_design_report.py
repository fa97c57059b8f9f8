"""The design report: self-contained, complete, and the same numbers on the page as in the JSON."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_control.controller_designs import design
from heli_control.weights_file import read_weights
from heli_flight.cli.main import main
from heli_flight.design_figures import OMEGA, controller_charts
from heli_flight.design_report import DesignReport, write_design_report
from heli_flight.page_tables import number, significant

MODEL_FILE = Path(__file__).parents[4] / "heli_control" / "test" / "data" / "hover_model.yaml"
MODEL = ModelFile.read(MODEL_FILE)
TITLES = (
    "Synthesis and order", "Cross-overs", "Loop as designed", "Loop as it flies", "Phase lost",
    "Source Table 3.1", "Plants", "S/KS/T examined", "Robustness tests", "Assumptions", "Attempts",
    "Weights of skst",
)  # fmt: skip


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> DesignReport:
    """LQ and S/KS/T, with pictures."""
    return write_design_report(MODEL, tmp_path_factory.mktemp("design"), ("lq", "skst"), static=True)


def plain(page: str) -> str:
    return re.sub(r"<(script|style).*?</\1>", "", page, flags=re.DOTALL)


def test_page_and_pictures_need_nothing_else(report: DesignReport) -> None:
    text = report.page.read_text()
    assert not re.search(r"(src|href)=[\"'](?!data:|#)", text)
    assert "<script" not in text
    assert {path.name for path in report.pictures} == {
        f"{key}.png"
        for key in (
            "overview_loops", "lq_loops", "lq_paths", "skst_loops", "skst_paths", "skst_bounds",
            "skst_reference",
        )
    }  # fmt: skip
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in report.pictures)


def test_page_says_what_the_numbers_say(report: DesignReport) -> None:
    page, metrics = plain(report.page.read_text()), report.metrics
    assert json.loads((report.page.parent / "design.json").read_text()) == metrics
    assert MODEL.plant_hash in page
    for title in TITLES:
        assert title in page
    (lq, skst) = metrics["controllers"]
    norm = skst["axes"]["horizontal"]["synthesis"]["norm"]
    assert f">{norm:.3f}</td>" in page
    peak = lq["axes"]["horizontal"]["continuous"]["peak_S_db"]
    assert f">{peak:.2f}</td>" in page
    of, reproduced = metrics["published"]["of"], metrics["published"]["reproduced"]
    assert of == 10
    assert page.count(">reproduced</td>") == reproduced
    assert page.count(">differs</td>") == of - reproduced
    assert all(row["reason"] for row in metrics["published"]["rows"] if not row["reproduced"])
    assert f"{reproduced} of {of} figures" in page


def test_sampling_and_actuators_cost_margin(report: DesignReport) -> None:
    for controller in report.metrics["controllers"]:
        for axis in controller["axes"].values():
            assert axis["flown"]["disk"]["alpha"] < axis["continuous"]["disk"]["alpha"]
            parts = axis["phase_lost_deg"]
            assert parts["all"] == pytest.approx(sum(parts.values()) - parts["all"])
            # all commands at once are one of the directions that single commands and the disk bound
            assert axis["flown"]["all_at_once"]["gain_up_db"] >= axis["flown"]["disk"]["gain_db"] - 1e-6


def test_cancellation_and_violations_are_told(report: DesignReport) -> None:
    found: dict[str, Any] = report.metrics["examination"]
    integrating = [row for row in found["rank"] if row["appended"]]
    assert {row["scheme"]: row["holds"] for row in integrating} == {"S/KS/T": False, "GS/T": True}
    assert all(row["holds"] for row in found["rank"] if not row["appended"])
    assert min(row["moved"] for row in found["slow_poles"]) < 1e-6


def test_interactive_page_embeds_plotly_once(tmp_path: Path) -> None:
    told: list[str] = []

    def tell(job: str, done: int, all_of: int) -> None:
        told.append(f"{job} {done}/{all_of}")

    made = write_design_report(MODEL, tmp_path / "out", ("motor",), told=tell)
    text = made.page.read_text()
    assert not re.search(r"<(script|img|link|iframe)[^>]+(src|href)=[\"'](?!data:)", text)
    assert text.count("plotly.js v") == 1
    assert made.pictures == ()
    plots = re.findall(r'<script type="application/json" id="data-(\w+)">(.*?)</script>', text, re.DOTALL)
    assert [key for key, _ in plots] == ["motor_loops", "motor_paths", "motor_bounds", "motor_pi"]
    assert all(json.loads(plot)["data"] for _, plot in plots)
    assert told[0] == "designs motor 0/4"
    assert told[-1] == "done 4/4"


def test_curves_stay_below_their_bounds() -> None:
    summary = design("gst", MODEL)
    charts = {chart.key: chart for chart in controller_charts(summary, read_weights("gst", None).axes)}
    for row in charts["gst_bounds"].rows:
        for plot in row:
            curve, bound = plot.traces
            assert np.all(curve.y <= bound.y + 0.01)
    for plot in charts["gst_paths"].rows[0]:
        for trace in plot.traces:
            assert trace.y.shape == OMEGA.shape


def test_bad_input_is_one_line_and_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["design", "report", "--model", str(MODEL_FILE), "--out", str(tmp_path / "out")]
    assert main([*arguments, "--kinds", "lq,pid"]) == 2
    assert "'pid'" in capsys.readouterr().err
    assert main([*arguments, "--weights", str(tmp_path / "none")]) == 2
    assert "none" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    with pytest.raises(InputError, match="no kind"):
        write_design_report(MODEL, tmp_path / "out", ())


def test_command_takes_weights_of_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "lq.yaml").write_text("format: heli_weights/1\nkind: lq\nweights: {theta: 50.0}\n")
    arguments = ["--out", str(tmp_path / "out"), "--kinds", "lq", "--weights", str(tmp_path), "--json"]
    assert main(["design", "report", "--model", str(MODEL_FILE), *arguments]) == 0
    metrics = json.loads(capsys.readouterr().out)
    assert metrics["controllers"][0]["weights"]["theta"] == 50.0


def test_numbers_as_they_are_written() -> None:
    assert number(-0.0004) == "0.00"
    assert number(-1.234) == "−1.23"
    assert number(None) == "–"
    assert significant(0.00000123) == "1.23e−6"
    assert significant(12.0) == "12"
