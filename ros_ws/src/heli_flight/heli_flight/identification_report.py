"""The report of an identification: one HTML file that needs nothing else (source Figures 2.10-2.23)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_flight.graph_pictures import graph_png, plotly_graph
from heli_flight.graphs import Graph
from heli_flight.identification import Identified
from heli_flight.identification_figures import comparison_graph, pole_graph, residual_graph, shown
from heli_flight.identification_tables import (
    coefficient_table,
    fit_table,
    pole_table,
    residual_table,
    weak_lines,
)
from heli_flight.page import live, render_page, still, write_page
from heli_flight.page_tables import number
from heli_flight.response_figures import response_graphs
from heli_identification.identified_model import block_of
from heli_identification.published_coefficients import NOTES
from heli_identification.records import data_hash
from heli_identification.structures import Structure


@dataclass(frozen=True)
class IdentificationReport:
    """What was written: the HTML file and PNG files."""

    page: Path
    pictures: tuple[Path, ...]


def write_identification_report(
    found: Identified,
    metrics: Mapping[str, Any],
    out: Path,
    prior: ModelFile | None = None,
    *,
    static: bool = False,
) -> IdentificationReport:
    """Write the report of an identification.

    Args:
        found: identification.
        metrics: the same in numbers, ready for JSON; stands beside the page.
        out: folder for `identification.html`, `identification.json` and the pictures.
        prior: model that stands beside the identified one.
        static: pictures instead of interactive plots in the page, and beside it.

    Raises:
        InputError: `out` cannot be written.
    """
    beside = _beside(found.estimate.structure, prior)
    drawn = graphs(found, None if beside is None else beside.model())
    pictures = {
        out / f"{graph.key}.png": graph_png(graph) for group in drawn.values() for graph in group if static
    }
    flights = ", ".join(sorted({record.name for record in found.records}))
    html = render_page(
        "identification.html",
        kind="identification report",
        heading=f"{found.estimate.structure.name} from {flights}",
        static=static,
        **_page(found, beside),
        graphs={name: [_shown(graph, out, pictures) for graph in group] for name, group in drawn.items()},
    )
    page = out / "identification.html"
    write_page(page, html, out / "identification.json", metrics, pictures)
    return IdentificationReport(page, tuple(pictures))


def graphs(found: Identified, prior: StateSpace | None) -> dict[str, list[Graph]]:
    """Graphs by the section they stand in: `comparison`, `poles`, `residuals` and `responses`.

    Args:
        found: identification.
        prior: model that stands beside it, of the same states.
    """
    return {
        "comparison": [comparison_graph(found)] if found.fit is not None else [],
        "poles": [pole_graph(found, prior)],
        "residuals": [residual_graph(found)],
        "responses": response_graphs(found, prior),
    }


def _beside(structure: Structure, prior: ModelFile | None) -> Structure | None:
    """The structure with a prior model's values, if that has the block with all its signals."""
    block = None if prior is None else getattr(prior, block_of(structure))
    try:
        return None if block is None else structure.from_model(block)
    except InputError:
        return None


def _shown(graph: Graph, out: Path, pictures: Mapping[Path, bytes]) -> dict[str, Any]:
    png = pictures.get(out / f"{graph.key}.png")
    return live(graph, plotly_graph(graph)) if png is None else still(graph, png)


def _page(found: Identified, beside: Structure | None) -> dict[str, Any]:
    """What the template needs beside the graphs."""
    estimate, choice = found.estimate, found.choice
    model: StateSpace | None = None if beside is None else beside.model()
    return {
        "badges": [choice.method, f"noise: {estimate.noise.value}", f"input: {choice.source.value}"]
        + (["averaged"] if choice.averaging else []),
        "white": estimate.white,
        "converged": estimate.converged,
        "tiles": _tiles(found),
        "weak": weak_lines(found),
        "coefficients": coefficient_table(found, beside),
        "source_note": NOTES[block_of(estimate.structure)],
        "fits": None if found.fit is None else fit_table(found),
        "poles": pole_table(found, model),
        "residuals": residual_table(found),
        "names": estimate.names,
        "matrix": estimate.correlations.tolist(),
        "provenance": {
            "estimated from": ", ".join(found.segments),
            "validated on": ", ".join(found.validation) or "nothing",
            "data, SHA-256": data_hash(found.records),
            "sample time": f"{found.records[0].period:g} s",
            "operating point": ", ".join(f"{shown(n)} {v:.4g}" for n, v in found.means.items()),
            "search": f"{len(estimate.steps)} steps",
        },
    }


def _tiles(found: Identified) -> list[tuple[str, str, str]]:
    """Label, value and unit of what one wants to see first."""
    estimate = found.estimate
    tiles = [("data", number(sum(record.duration for record in found.records), 1), "s")]
    if found.fit is not None:
        fits = zip(found.fit.outputs, found.fit.percent.tolist(), strict=True)
        tiles += [(f"fit {shown(name)}", number(value, 1), "%") for name, value in fits]
    share = estimate.errors / abs(estimate.values)
    known = int((share < 0.1).sum())
    tiles.append(("known to better than 10 %", str(known), f"of {len(share)} coefficients"))
    return tiles
