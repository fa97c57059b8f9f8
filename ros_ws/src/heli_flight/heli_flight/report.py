"""A flight's report: one HTML file that needs nothing else, and the figures of merit beside it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from typing import Any

from heli_common.errors import InputError
from heli_common.flight_state import FlightState
from heli_common.topics import DATA_TOPICS
from heli_flight.figures import Figure
from heli_flight.flight_hash import TopicCount, bag_hash, count_check
from heli_flight.flight_record import FlightRecord
from heli_flight.flight_statistics import sampling_metrics
from heli_flight.graph_pictures import graph_canvas, plotly_graph
from heli_flight.graphs import Graph
from heli_flight.interactive import plotly_json
from heli_flight.metrics import flight_metrics
from heli_flight.page import live, render_page, still, write_page
from heli_flight.page_tables import number
from heli_flight.picture import figure_canvas, save_png, save_svg
from heli_flight.report_sections import Content, Flights, Section, contents
from heli_flight.report_tables import mapping, parameter_table

_COMPARED = ("flight_state", "reference", "ground_truth")
"""Topics without which a flight cannot be laid over others."""

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
        pictures: PNG and SVG files, if the page is static.
        summaries: per flight: name, provenance, figures of merit and sampling, ready for JSON.
    """

    page: Path
    pictures: tuple[Path, ...]
    summaries: list[dict[str, Any]]


def write_report(folders: Sequence[Path], out: Path, static: bool = False) -> Report:
    """Write the report of one flight, or of several laid over each other.

    Args:
        folders: of the bags.
        out: folder for `report.html`, `metrics.json` and the pictures, or the path of the HTML file.
        static: pictures instead of interactive plots in the page, small and without a script,
            and every picture as PNG and SVG beside it.

    Raises:
        InputError: no bags given, one is unreadable or empty, one of several lacks what is compared, or `out`
            cannot be written.
    """
    page = out if out.suffix == ".html" else out / "report.html"
    records = load_flights(folders)
    counts = [count_check(record.bag) for record in records]
    flights = summarized(records, counts)
    pictures: dict[Path, bytes] = {}
    sections = [
        {
            "key": section.key,
            "title": section.title,
            "note": content.note,
            "tables": content.tables,
            "figures": drawn_figures(section, content, page.parent, pictures if static else None),
        }
        for section, content in contents(flights)
    ]
    html = render_page(
        "report.html",
        kind="flight report",
        heading=_title(flights.summaries),
        static=static,
        about=flights.summaries[0]["provenance"]["about"] if len(records) == 1 else "",
        flights=[_flight(*each) for each in zip(flights.summaries, records, strict=True)],
        sections=sections,
    )
    write_page(page, html, page.parent / "metrics.json", flights.summaries, pictures)
    return Report(page, tuple(pictures), list(flights.summaries))


def load_flights(folders: Sequence[Path]) -> list[FlightRecord]:
    """Read the bags of a report.

    Args:
        folders: of the bags.

    Raises:
        InputError: no bags given, one is unreadable or empty, or one of several lacks what is compared.
    """
    if not folders:
        raise InputError("no bag given", allowed="one or more bags")
    records = [FlightRecord.load(folder) for folder in folders]
    for folder, record in zip(folders, records, strict=True):
        if not any(record.bag.counts.get(topic) for topic in DATA_TOPICS):
            raise InputError("holds no message of a flight", allowed="the bag of a flight", file=folder)
        lacking = [topic for topic in _COMPARED if not record.bag.counts.get(topic)]
        if len(records) > 1 and lacking:
            raise InputError(
                f"cannot be compared: nothing of {', '.join(lacking)}",
                allowed="bags with " + ", ".join(_COMPARED),
                file=folder,
            )
    return records


def summarized(records: Sequence[FlightRecord], counts: Sequence[Sequence[TopicCount]]) -> Flights:
    """The flights with their figures of merit.

    Args:
        records: flights. counts: of the bag of each.
    """
    names = _names(records)
    summaries = [
        {
            "name": name,
            "provenance": provenance(record, count),
            "metrics": flight_metrics(record),
            "sampling": sampling_metrics(record, count),
        }
        for name, record, count in zip(names, records, counts, strict=True)
    ]
    return Flights(records, names, summaries)


def drawn_figures(
    section: Section, content: Content, folder: Path, pictures: dict[Path, bytes] | None
) -> list[dict[str, Any]]:
    """The figures of a section for the template; the first goes by the section's name.

    Args:
        section: they stand in. content: of it.
        folder: of the pictures.
        pictures: to which PNG and SVG are added; None draws in the browser.
    """
    drawn = []
    for figure in content.figures:
        if pictures is None:
            graph = isinstance(figure, Graph)
            plot = plotly_graph(figure) if isinstance(figure, Graph) else plotly_json(figure)
            about = live(figure, plot, timed=figure.timed if isinstance(figure, Graph) else not graph)
        else:
            canvas = figure_canvas(figure) if isinstance(figure, Figure) else graph_canvas(figure)
            png = save_png(canvas)
            pictures[folder / f"{figure.key}.png"] = png
            pictures[folder / f"{figure.key}.svg"] = save_svg(canvas)
            about = still(figure, png)
        drawn.append({**about, "title": "" if figure.title == section.title else figure.title})
    return drawn


def provenance(record: FlightRecord, counts: Sequence[TopicCount]) -> dict[str, Any]:
    """Where a flight comes from, ready for JSON: plan, settings, versions, hash and losses."""
    plan = mapping(record.custom_data.get("plan", ""))
    short = {key: text for key, text in record.custom_data.items() if not _is_document(key, text)}
    return {
        **short,
        "plan": str(plan.get("name", "")),
        "about": str(plan.get("about", "")),
        "versions": mapping(record.custom_data.get("versions", "")),
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


def _flight(summary: Mapping[str, Any], record: FlightRecord) -> dict[str, Any]:
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
        if _is_document(key, text) and key not in (*_COUNTED, "versions", "parameters")
    }
    return {
        "name": summary["name"],
        "ended": _ended(metrics["flight"]["ended"]),
        "good": metrics["flight"]["complete"] and metrics["flight"]["ended"] == FlightState.STOPPED.word,
        "duration": number(metrics["flight"]["duration_s"], digits=1),
        "missing": metrics["missing"],
        "tiles": _tiles(summary),
        "facts": {**told, **others, "flight, SHA-256": origin["flight_sha256"]},
        "versions": origin["versions"],
        "documents": documents,
        "stages": _stages(metrics["stages"]),
        "parameters": parameter_table(mapping(remarks.get("parameters", ""))),
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
    found = mapping(text)
    return json.dumps(found, indent=2) if found else text


def _tiles(summary: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Label, value and unit of what one wants to see first."""
    metrics, origin = summary["metrics"], summary["provenance"]
    tiles = []
    if metrics["hover"]:
        hover = max(metrics["hover"], key=lambda one: float(one["duration_s"]))
        tiles += [(f"hover σ {axis}", number(100.0 * hover[f"sigma_{axis}_m"]), "cm") for axis in "xyz"]
        tiles += [("hover σ ψ", number(degrees(1.0) * hover["sigma_psi_rad"]), "deg")]
        tiles += [("hover, farthest in the plane", number(100.0 * hover["max_xy_m"]), "cm")]
    if metrics["steps"]:
        worst = max(float(step["overshoot_percent"]) for step in metrics["steps"])
        tiles += [("largest overshoot", number(worst, digits=1), "%")]
    if metrics["rotor"]:
        tiles += [("rotor speed within", number(metrics["rotor"]["max_deviation_percent"]), "%")]
    tiles += [("messages lost", str(origin["lost_messages"]), f"of {origin['messages']:,}")]
    if origin["late_commands"] is not None:
        tiles += [("late commands", str(origin["late_commands"]), "")]
    return tiles


def _stages(stages: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Name, times and share of the flight [%] of every stage that takes any time."""
    whole = sum(stage["duration_s"] for stage in stages)
    return [
        {
            "state": stage["state"],
            "start": number(stage["start_s"], 1),
            "duration": number(stage["duration_s"], 1),
            "share": round(100.0 * stage["duration_s"] / whole, 2),
        }
        for stage in stages
        if stage["duration_s"] > 0.005 * whole
    ]
