"""How long the report of a 10 minute flight takes, section by section, and how large its page is.

Run: python benchmarks/report.py [--bag BAG] [--out DIR] [--json]. Without a bag it flies one in process:
hover, four steps, wind of 3 m/s. The table gives wall time and processor time of every part, measured once.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter, process_time

from rich.console import Console
from rich.table import Table

from heli_common.errors import InputError
from heli_control.controller_file import load_controller
from heli_flight.flight_hash import count_check
from heli_flight.fly_in_process import fly_in_process
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import parse_plan
from heli_flight.report import drawn_figures, load_flights, summarized, write_report
from heli_flight.report_sections import SECTIONS

PLAN = """
name: ten_minutes
about: Ten minutes of hover, steps and wind.
seed: 1
controller: lq
room: gusty
phases:
  - home: {}
  - run_up: {}
  - take_off: {height: 0.0, speed: 0.15}
  - hover: {duration: 390.0}
  - step: {axis: x, amplitude: 0.3, duration: 20.0}
  - step: {axis: x, amplitude: -0.3, duration: 20.0}
  - step: {axis: y, amplitude: 0.3, duration: 20.0}
  - step: {axis: y, amplitude: -0.3, duration: 20.0}
  - hover: {duration: 40.0, wind_to_m_s: 3.0}
  - hover: {duration: 40.0}
  - hover: {duration: 20.0, wind_to_m_s: 0.0}
  - land: {}
  - run_down: {}
"""

ASKED = 15.0
"""Seconds of wall time that the whole may take."""


class Times:
    """Wall and processor time [s] of every part."""

    def __init__(self) -> None:
        self.parts: dict[str, tuple[float, float]] = {}

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Measure what is done inside."""
        wall, cpu = perf_counter(), process_time()
        yield
        self.parts[name] = (perf_counter() - wall, process_time() - cpu)


def fly(bag: Path) -> None:
    """Fly the plan into a bag."""
    order = FlightOrder(parse_plan(PLAN), "ten_minutes", Mode.INPROCESS, 1, load_controller("lq"), "lq", bag)
    end = fly_in_process(order, lambda _: None)
    if end.exit_code:
        raise InputError(f"was not flown to its end: {end.reason}", key="ten_minutes")


def measure(bag: Path, out: Path) -> dict[str, object]:
    """Time the parts one by one, then the whole as `heli report` does it."""
    times = Times()
    with times.part("read the bag"):
        records = load_flights([bag])
    with times.part("hash, counts and figures of merit"):
        flights = summarized(records, [count_check(record.bag) for record in records])
    for section in SECTIONS:
        with times.part(f"section {section.key}"):
            drawn_figures(section, section.build(flights), out, None)
    del records, flights
    with times.part("whole report"):
        report = write_report([bag], out)
    return {
        "parts": {name: {"wall_s": wall, "cpu_s": cpu} for name, (wall, cpu) in times.parts.items()},
        "messages": report.summaries[0]["provenance"]["messages"],
        "flight_s": report.summaries[0]["metrics"]["flight"]["duration_s"],
        "page_mb": report.page.stat().st_size / 1e6,
        "wall_s": times.parts["whole report"][0],
        "asked_s": ASKED,
    }


def main() -> int:
    """Fly or take a bag, measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--bag", type=Path, help="bag of a flight (default: flies ten minutes)")
    parser.add_argument("--out", type=Path, help="where the page is left (default: nowhere)")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        bag = options.bag or Path(folder) / "flight"
        try:
            if options.bag is None:
                fly(bag)
            found = measure(bag, options.out or Path(folder) / "report")
        except InputError as error:
            sys.stderr.write(f"{error}\n")
            return 2
    if options.json:
        sys.stdout.write(json.dumps(found, indent=2) + "\n")
    else:
        _show(found)
    return 0 if found["wall_s"] <= ASKED else 1


def _show(found: dict[str, object]) -> None:
    table = Table("part", box=None, pad_edge=False)
    for title in ("wall [s]", "processor [s]"):
        table.add_column(title, justify="right")
    for name, part in found["parts"].items():
        table.add_row(name, f"{part['wall_s']:.2f}", f"{part['cpu_s']:.2f}")
    console = Console(highlight=False)
    console.print(table)
    console.print(
        f"flight {found['flight_s']:.0f} s, {found['messages']:,} messages, page {found['page_mb']:.1f} MB, "
        f"{found['wall_s']:.1f} s (asked: {ASKED:g} s)"
    )


if __name__ == "__main__":
    sys.exit(main())
