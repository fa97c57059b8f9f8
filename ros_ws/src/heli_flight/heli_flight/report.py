"""A flight's report: one HTML file that needs nothing else, pictures beside it, and the figures of merit."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from typing import Any

import yaml

from heli_common.errors import InputError
from heli_common.flight_state import FlightState
from heli_flight.figures import flight_figures
from heli_flight.flight_hash import TopicCount, bag_hash, count_check
from heli_flight.flight_record import FlightRecord
from heli_flight.interactive import plotly_json
from heli_flight.metrics import flight_metrics
from heli_flight.page import live, render_page, still, write_page
from heli_flight.picture import figure_canvas, save_png
from heli_flight.sensor_figures import sensor_figures

NOTHING = "–"

_COUNTED = ("counts", "losses")
_LABELS = {
    "plan": "plan",
    "seed": "seed",
    "mode": "way of running",
    "controller": "controller",
    "controllers": "controllers' hashes",
    "result": "result",
}


@dataclass(frozen=True)
class Report:
    """What was written.

    Attributes:
        page: the HTML file.
        pictures: PNG files.
        summaries: per flight: name, provenance and figures of merit, ready for JSON.
    """

    page: Path
    pictures: tuple[Path, ...]
    summaries: list[dict[str, Any]]


def write_report(folders: Sequence[Path], out: Path, static: bool = False) -> Report:
    """Write the report of one flight, or of several laid over each other.

    Args:
        folders: of the bags.
        out: folder for `report.html`, `metrics.json` and the pictures, or the path of the HTML file.
        static: pictures instead of interactive plots in the page, which then is small and needs no script.

    Raises:
        InputError: no bags given, one is unreadable, or `out` cannot be written.
    """
    if not folders:
        raise InputError("no bag given", allowed="one or more bags")
    page = out if out.suffix == ".html" else out / "report.html"
    records = [FlightRecord.load(folder) for folder in folders]
    counts = [count_check(record.bag) for record in records]
    names = _names(records)
    summaries: list[dict[str, Any]] = [
        {"name": name, "provenance": provenance(record, count), "metrics": flight_metrics(record)}
        for name, record, count in zip(names, records, counts, strict=True)
    ]
    drawn: list[dict[str, Any]] = []
    pictures: dict[Path, bytes] = {}
    for figure in (*flight_figures(records, names), *sensor_figures(records, names)):
        png = save_png(figure_canvas(figure))
        pictures[page.parent / f"{figure.key}.png"] = png
        timed = not figure.plane
        drawn.append(still(figure, png) if static else live(figure, plotly_json(figure), timed))
    html = render_page(
        "report.html",
        kind="flight report",
        heading=_title(summaries),
        static=static,
        about=summaries[0]["provenance"]["about"] if len(records) == 1 else "",
        flights=[_flight(*each) for each in zip(summaries, records, counts, strict=True)],
        hover=_hover_rows(summaries),
        steps=_step_rows(summaries),
        figures=drawn,
    )
    write_page(page, html, page.parent / "metrics.json", summaries, pictures)
    return Report(page, tuple(pictures), summaries)


def provenance(record: FlightRecord, counts: Sequence[TopicCount]) -> dict[str, Any]:
    """Where a flight comes from, ready for JSON: plan, settings, versions, hash and losses."""
    plan = _mapping(record.custom_data.get("plan", ""))
    short = {key: text for key, text in record.custom_data.items() if not _is_document(key, text)}
    return {
        **short,
        "plan": str(plan.get("name", "")),
        "about": str(plan.get("about", "")),
        "versions": _mapping(record.custom_data.get("versions", "")),
        "flight_sha256": bag_hash(record.bag),
        "messages": sum(count.messages for count in counts),
        "lost_messages": sum(count.lost for count in counts),
        "late_commands": _late(record.custom_data),
    }


def _is_document(key: str, text: str) -> bool:
    """Whether a remark is a file or a table rather than a word: shown folded."""
    return key in ("plan", "parameters", "versions", *_COUNTED) or "\n" in text


def _late(custom_data: Mapping[str, str]) -> int | None:
    """Commands that came too late, of all topics; None if nobody counted."""
    counts = [text for key, text in custom_data.items() if key.startswith("late_") and text.isdecimal()]
    return sum(map(int, counts)) if counts else None


def _mapping(text: str) -> dict[str, Any]:
    """A YAML or JSON mapping in custom data; empty if it is none."""
    try:
        document = yaml.safe_load(text)
    except yaml.YAMLError:
        return {}
    return document if isinstance(document, dict) else {}


def _names(records: Sequence[FlightRecord]) -> list[str]:
    """Short names that tell the flights apart: the controllers if they differ, else the folders."""
    controllers = [Path(record.custom_data.get("controller", "")).stem for record in records]
    folders = [record.bag.folder.resolve().name for record in records]
    if len(records) > 1 and all(controllers) and len(set(controllers)) == len(controllers):
        return controllers
    if len(set(folders)) == len(folders):
        return folders
    return [str(record.bag.folder) for record in records]


def _title(summaries: Sequence[Mapping[str, Any]]) -> str:
    plans = {summary["provenance"]["plan"] or summary["name"] for summary in summaries}
    flown = ", ".join(sorted(plans))
    return flown if len(summaries) == 1 else f"{flown}: {len(summaries)} flights"


def _number(value: float | None, factor: float = 1.0, digits: int = 2) -> str:
    return NOTHING if value is None else f"{value * factor:.{digits}f}".replace("-", "−")


def _cm(value: float | None) -> str:
    return _number(value, 100.0)


def _deg(value: float | None) -> str:
    return _number(value, degrees(1.0))


def _hover_rows(summaries: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """Rows in the manner of the source's Table 5.2."""
    return [
        [
            summary["name"],
            f"{hover['start_s']:.1f} – {hover['start_s'] + hover['duration_s']:.1f}",
            *(_cm(hover[f"sigma_{axis}_m"]) for axis in "xyz"),
            _deg(hover["sigma_psi_rad"]),
            _deg(hover["sigma_theta_rad"]),
            _deg(hover["sigma_phi_rad"]),
            _cm(hover["max_xy_m"]),
            _cm(hover["max_z_m"]),
            *(_cm(hover[f"mean_{axis}_m"]) for axis in "xyz"),
        ]
        for summary in summaries
        for hover in summary["metrics"]["hover"]
    ]


def _step_rows(summaries: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    rows = []
    for summary in summaries:
        for step in summary["metrics"]["steps"]:
            unit = "rad" if step["axis"] == "psi" else "m"
            show, word = (_deg, "deg") if unit == "rad" else (_cm, "cm")
            show_factor = degrees(1.0) if unit == "rad" else 100.0
            crosses = [step.get(f"cross_{axis}_max_m") for axis in "xyz"]
            rows.append(
                [
                    summary["name"],
                    f"{step['start_s']:.1f}",
                    "ψ" if unit == "rad" else step["axis"],
                    f"{_number(step[f'amplitude_{unit}'], show_factor, 1)} {word}",
                    _number(step["rise_time_s"]),
                    _number(step["overshoot_percent"], digits=1),
                    _number(step["settling_time_s"]),
                    f"{show(step[f'final_error_{unit}'])} {word}",
                    *(_cm(cross) for cross in crosses),
                    _deg(step["theta_range_rad"]),
                    _deg(step["phi_range_rad"]),
                ]
            )
    return rows


def _flight(summary: Mapping[str, Any], record: FlightRecord, counts: Sequence[TopicCount]) -> dict[str, Any]:
    """What the page says of one flight beside tables and plots."""
    origin, metrics, remarks = summary["provenance"], summary["metrics"], record.custom_data
    told = {label: origin[key] for key, label in _LABELS.items() if origin.get(key)}
    others = {
        key.replace("_", " "): text
        for key, text in remarks.items()
        if key not in _LABELS and not _is_document(key, text)
    }
    documents = {
        key.replace("_", " ").capitalize(): _pretty(text)
        for key, text in remarks.items()
        if _is_document(key, text) and key not in (*_COUNTED, "versions")
    }
    return {
        "name": summary["name"],
        "ended": _ended(metrics["flight"]["ended"]),
        "good": metrics["flight"]["complete"] and metrics["flight"]["ended"] == FlightState.STOPPED.word,
        "duration": _number(metrics["flight"]["duration_s"], digits=1),
        "missing": metrics["missing"],
        "tiles": _tiles(summary),
        "facts": {**told, **others, "flight, SHA-256": origin["flight_sha256"]},
        "versions": origin["versions"],
        "documents": documents,
        "counts": counts,
    }


def _ended(word: str | None) -> str:
    """How a flight ended, in words."""
    if word is None:
        return "no flight state"
    if word in (FlightState.STOPPED.word, FlightState.FAULT.word):
        return word
    return f"ends while {word}"


def _pretty(text: str) -> str:
    """JSON on several lines; everything else as it is."""
    if not text.startswith("{"):
        return text
    found = _mapping(text)
    return json.dumps(found, indent=2) if found else text


def _tiles(summary: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Label, value and unit of what one wants to see first."""
    metrics, origin = summary["metrics"], summary["provenance"]
    tiles = []
    if metrics["hover"]:
        hover = max(metrics["hover"], key=lambda one: float(one["duration_s"]))
        tiles += [(f"hover σ {axis}", _cm(hover[f"sigma_{axis}_m"]), "cm") for axis in "xyz"]
        tiles += [("hover σ ψ", _deg(hover["sigma_psi_rad"]), "deg")]
        tiles += [("hover, farthest in the plane", _cm(hover["max_xy_m"]), "cm")]
    if metrics["steps"]:
        worst = max(float(step["overshoot_percent"]) for step in metrics["steps"])
        tiles += [("largest overshoot", _number(worst, digits=1), "%")]
    if metrics["rotor"]:
        tiles += [("rotor speed within", _number(metrics["rotor"]["max_deviation_percent"]), "%")]
    tiles += [("messages lost", str(origin["lost_messages"]), f"of {origin['messages']:,}")]
    if origin["late_commands"] is not None:
        tiles += [("late commands", str(origin["late_commands"]), "")]
    return tiles
