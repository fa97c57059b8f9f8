"""The flight report in a real browser: no request to the network, a silent console, every figure drawn."""

from __future__ import annotations

import socket
import subprocess
import sys
from pathlib import Path

import page_check
import pytest

from heli_control.controller_file import load_controller
from heli_flight.fly_in_process import fly_in_process
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import parse_plan
from heli_flight.report import write_report

PLAN = """
name: browser
about: A short flight for the report.
seed: 1
controller: lq
room: gusty
phases:
  - home: {}
  - run_up: {duration: 6.0}
  - take_off: {height: 0.0, speed: 0.3}
  - hover: {duration: 5.0}
  - step: {axis: x, amplitude: 0.2, duration: 3.0}
  - land: {speed: 0.3}
  - run_down: {duration: 1.0}
"""

PAGE = """<!DOCTYPE html><html><head><meta charset="utf-8"><title>page</title>
<link rel="icon" href="data:,"></head><body>{}</body></html>"""


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bag of a short flight with a step, in gusts."""
    bag = tmp_path_factory.mktemp("browser") / "flight"
    order = FlightOrder(parse_plan(PLAN), "browser", Mode.INPROCESS, 1, load_controller("lq"), "lq", bag)
    assert fly_in_process(order, lambda _: None).exit_code == 0
    return bag


def opened(folder: Path, body: str) -> page_check.Visit:
    """What happens when a page with this body is opened."""
    page = folder / "page.html"
    page.write_text(PAGE.format(body))
    return page_check.visit(page)


def test_report_opens_without_network_and_without_error(flight: Path, tmp_path: Path) -> None:
    report = write_report([flight], tmp_path)
    picture = tmp_path / "page.png"
    seen = page_check.visit(report.page, picture)
    assert seen.problems == []
    text = report.page.read_text()
    assert seen.figures == text.count('class="plot"') >= 11
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_static_report_in_a_dark_browser(flight: Path, tmp_path: Path) -> None:
    report = write_report([flight], tmp_path, static=True)
    seen = page_check.visit(report.page, dark=True)
    assert seen.problems == []
    assert seen.figures == len(report.pictures) // 2 >= 11


def test_checker_finds_what_it_looks_for(tmp_path: Path) -> None:
    """A page with every fault at once: each is found, and the server that it asks is asked for nothing."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"http://127.0.0.1:{server.getsockname()[1]}/style.css"
        seen = opened(
            tmp_path,
            f'<link rel="stylesheet" href="{address}">'
            '<img alt="far" src="https://far.invalid/picture.png"><img alt="empty">'
            '<div class="plot" id="plot-hollow"><div class="frame"></div></div>'
            '<div class="plot" id="plot-full"><svg><path class="js-line" d="M0 0"/></svg></div>'
            "<script>console.error('first fault'); fetch('https://far.invalid/data.json').catch(() => {});"
            " nowhere.to.be.found();</script>",
        )
        server.setblocking(False)
        with pytest.raises(BlockingIOError):
            server.accept()
    assert {address, "https://far.invalid/picture.png", "https://far.invalid/data.json"} <= set(seen.requests)
    assert any("first fault" in line for line in seen.console)
    assert any("nowhere is not defined" in line for line in seen.console)
    assert seen.missing == ("empty", "plot-hollow") and seen.figures == 4
    assert len(seen.problems) == len(seen.requests) + len(seen.console) + 2


def test_checker_is_content_with_a_clean_page(tmp_path: Path) -> None:
    assert opened(tmp_path, "<p>nothing but words</p><script>let x = 1;</script>").problems == []


def test_checker_as_a_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "page.html"
    page.write_text(PAGE.format("<script>console.warn('a fault')</script>"))
    words = [sys.executable, page_check.__file__]
    done = subprocess.run([*words, page], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "a fault" in done.stdout
    done = subprocess.run([*words, tmp_path / "none.html"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "no such page" in done.stderr
    monkeypatch.setenv("HELI_BROWSER", "no_such_browser")
    with pytest.raises(FileNotFoundError, match="apt-get install chromium"):
        page_check.visit(page)
