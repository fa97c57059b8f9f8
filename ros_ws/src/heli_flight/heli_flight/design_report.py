"""The design report: all controllers of a model side by side, the source's figures beside ours (spec 3.6)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_control.controller_designs import ABOUT, DESIGNS, LQ, MOTOR, DesignSummary
from heli_control.flight_design import software
from heli_control.flight_plants import FLIGHT_AXES
from heli_control.schemes import AxisWeights
from heli_control.weights_file import read_weights
from heli_flight.design_charts import Chart, chart_graph
from heli_flight.design_detail_tables import (
    assumption_table,
    attempt_table,
    examination_tables,
    gain_table,
    plant_tables,
    published_table,
    sweep_table,
)
from heli_flight.design_examination import examination, gain_tables, plant_metrics, sweep
from heli_flight.design_figures import controller_charts, overview_chart, sweep_chart
from heli_flight.design_metrics import WeightsFolder, controller_metrics, designed
from heli_flight.design_tables import overview_tables, robustness_table
from heli_flight.graph_pictures import graph_png, plotly_graph
from heli_flight.page import live, render_page, still, write_page

Told = Callable[[str, int, int], None]


@dataclass(frozen=True)
class DesignReport:
    """What was written.

    Attributes:
        page: the HTML file.
        pictures: PNG files.
        metrics: everything in numbers, ready for JSON.
    """

    page: Path
    pictures: tuple[Path, ...]
    metrics: dict[str, Any]


def write_design_report(
    model: ModelFile,
    out: Path,
    kinds: Sequence[str] = DESIGNS,
    weights: Path | None = None,
    *,
    static: bool = False,
    told: Told | None = None,
) -> DesignReport:
    """Design every kind for a model and write the report.

    Args:
        model: to design for.
        out: folder for `design.html` and `design.json`.
        kinds: which of `DESIGNS`, in the order shown.
        weights: folder with `KIND.yaml` for every kind whose weights differ from the shipped ones.
        static: pictures instead of interactive plots in the page, and beside it.
        told: called before each job with its name, how many are done and how many there are.

    Raises:
        InputError: an unknown kind, a design that fails, or `out` cannot be written; nothing is written then.
    """
    for kind in kinds:
        if kind not in DESIGNS:
            raise InputError(f"unknown kind {kind!r}", allowed=", ".join(DESIGNS), key="kinds")
    if not kinds:
        raise InputError("no kind given", allowed=", ".join(DESIGNS), key="kinds")
    if weights is not None and not weights.is_dir():
        raise InputError("is no folder", allowed="a folder with KIND.yaml", file=weights, key="weights")
    folder, jobs, said = WeightsFolder(weights), len(kinds) + 3, told or _silent
    summaries: dict[str, DesignSummary] = {}
    controllers = []
    for number, kind in enumerate(dict.fromkeys(kinds)):
        said(f"designs {kind}", number, jobs)
        summaries[kind] = designed(kind, model, folder)
        controllers.append(controller_metrics(summaries[kind]))
    said("examines plants and S/KS/T", jobs - 3, jobs)
    rows = [row for controller in controllers for row in controller["published"]]
    metrics: dict[str, Any] = {
        "model": {"name": model.name, "plant_hash": model.plant_hash, "source": dict(model.source)},
        "controllers": controllers,
        "published": {"rows": rows, "of": len(rows), "reproduced": sum(row["reproduced"] for row in rows)},
        "static_gains": [table for table in gain_tables(controllers) if table["ours"]],
        "plants": plant_metrics(model, FLIGHT_AXES),
        "examination": examination(model, folder, summaries) if "skst" in summaries else None,
        "software": software(),
    }
    said("sweeps the trade-off", jobs - 2, jobs)
    metrics["trade_off"] = sweep(model, folder) if "gst" in summaries else []
    said("draws", jobs - 1, jobs)
    charts = _charts(summaries, folder, metrics)
    pictures = {
        out / f"{chart.key}.png": graph_png(
            chart_graph(replace(chart, title=f"{name}: {chart.title}") if name in summaries else chart)
        )
        for name, group in charts.items()
        for chart in group
        if static
    }
    html = render_page(
        "design.html",
        kind="design report",
        heading=f"Controllers for {model.name}",
        static=static,
        **_page(metrics),
        charts={name: [_drawn(chart, out, pictures) for chart in group] for name, group in charts.items()},
    )
    page = out / "design.html"
    write_page(page, html, out / "design.json", metrics, pictures)
    said("done", jobs, jobs)
    return DesignReport(page, tuple(pictures), metrics)


def _silent(_job: str, _done: int, _all_of: int) -> None:
    """For those who do not want to know."""


def _charts(
    summaries: Mapping[str, DesignSummary], folder: WeightsFolder, metrics: Mapping[str, Any]
) -> dict[str, list[Chart]]:
    """Charts by the section they stand in: `overview`, `trade_off`, and each kind."""
    made: dict[str, list[Chart]] = {"overview": [], "trade_off": []}
    if sum(kind != MOTOR for kind in summaries) > 1:
        made["overview"].append(overview_chart(summaries))
    if metrics["trade_off"]:
        made["trade_off"].append(sweep_chart(metrics["trade_off"]))
    for kind, summary in summaries.items():
        weights: Mapping[str, AxisWeights] = {} if kind == LQ else read_weights(kind, folder.path(kind)).axes
        made[kind] = controller_charts(summary, weights)
    return made


def _drawn(chart: Chart, out: Path, pictures: Mapping[Path, bytes]) -> dict[str, Any]:
    png = pictures.get(out / f"{chart.key}.png")
    return live(chart, plotly_graph(chart_graph(chart))) if png is None else still(chart, png)


def _page(metrics: Mapping[str, Any]) -> dict[str, Any]:
    """What the template needs beside the charts."""
    controllers, published = metrics["controllers"], metrics["published"]
    return {
        "model": metrics["model"],
        "kinds": {one["kind"]: ABOUT[one["kind"]] for one in controllers},
        "tiles": _tiles(metrics),
        "overview": overview_tables(controllers),
        "published": published_table(published["rows"]),
        "reproduced": (published["reproduced"], published["of"]),
        "gains": [gain_table(table) for table in metrics["static_gains"]],
        "plants": plant_tables(metrics["plants"]),
        "examination": examination_tables(metrics["examination"]) if metrics["examination"] else [],
        "sweep": sweep_table(metrics["trade_off"]) if metrics["trade_off"] else None,
        "robustness": robustness_table(controllers),
        "assumptions": assumption_table(controllers),
        "attempts": attempt_table(controllers),
        "methods": {one["kind"]: one["method"] for one in controllers},
        "weights": {
            one["kind"]: yaml.safe_dump(one["weights"], sort_keys=False, default_flow_style=None, width=100)
            for one in controllers
        },
        "software": metrics["software"],
        "source": yaml.safe_dump(metrics["model"]["source"], sort_keys=False, allow_unicode=True),
    }


def _tiles(metrics: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Label, value and unit of what one wants to see first."""
    published = metrics["published"]
    entries = [
        (f"{one['kind']} {axis}", entry)
        for one in metrics["controllers"]
        for axis, entry in one["axes"].items()
        if entry["flown"] and "disk" in entry["flown"]
    ]
    syntheses = [
        entry["synthesis"]
        for one in metrics["controllers"]
        for entry in one["axes"].values()
        if entry["synthesis"]
    ]
    tiles = []
    if published["of"]:
        share = f"of {published['of']} ({100.0 * published['reproduced'] / published['of']:.0f} %)"
        tiles.append(("published figures reproduced", str(published["reproduced"]), share))
    if syntheses:
        certified = sum(made["norm"] <= 1.001 * made["gamma"] for made in syntheses)
        tiles.append(("syntheses certified", str(certified), f"of {len(syntheses)}"))
        apart = [made["routes_apart"] for made in syntheses if made["routes_apart"] is not None]
        if apart:
            tiles.append(("both routes agree within", f"{max(apart):.0e}", ""))
    if entries:
        name, entry = min(entries, key=lambda pair: float(pair[1]["flown"]["disk"]["alpha"]))
        tiles.append((f"smallest disk margin as flown: {name}", f"{entry['flown']['disk']['alpha']:.2f}", ""))
        name, entry = max(entries, key=lambda pair: float(pair[1]["continuous"]["peak_T_db"]))
        tiles.append((f"largest |T_u|: {name}", f"{entry['continuous']['peak_T_db']:.2f}", "dB"))
        name, entry = max(entries, key=lambda pair: float(pair[1]["continuous"]["peak_S_db"]))
        tiles.append((f"largest |S_u|: {name}", f"{entry['continuous']['peak_S_db']:.2f}", "dB"))
    return tiles
