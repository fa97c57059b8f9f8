"""The page of the reproduction: one HTML file that needs nothing else, and the same in numbers (spec 5)."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heli_flight import reproduction_figures as figures
from heli_flight import reproduction_hover_tables as hovers
from heli_flight import reproduction_tables as tables
from heli_flight.graph_pictures import plotly_graph
from heli_flight.graphs import Graph
from heli_flight.gust_stiffness import stiffness_table
from heli_flight.page import live, render_page, write_page
from heli_flight.page_tables import Table
from heli_flight.reproduction_claims import compared
from heli_flight.reproduction_comparison import Compared
from heli_flight.reproduction_discussion import WORDS
from heli_flight.reproduction_results import Outcomes
from heli_flight.reproduction_run import job_mapping

PAGE, NUMBERS = "reproduction.html", "reproduction.json"


@dataclass(frozen=True)
class _Section:
    """One experiment on the page."""

    key: str
    title: str
    tables: tuple[Callable[[Outcomes], Table], ...]
    graphs: Callable[[Outcomes], list[Graph]] | None = None


_SECTIONS = (
    _Section(
        "F2",
        "F2 hover",
        (hovers.hover_table, hovers.order_table, stiffness_table, hovers.farthest_table),
        figures.hover_graphs,
    ),
    _Section("F1", "F1 steps", (tables.step_table,), figures.step_graphs),
    _Section("F3", "F3 wind", (tables.wind_table,), figures.wind_graphs),
    _Section("F4", "F4 noise", (tables.noise_table,), figures.noise_graphs),
    _Section("F5", "F5 identification", (tables.identification_table,)),
    _Section("F7", "F7 linear and nonlinear", (tables.apart_table,), figures.linear_graphs),
    _Section("F8", "F8 wireless link", (tables.link_table,)),
)


@dataclass(frozen=True)
class Reproduction:
    """What was written: the page, the numbers, and the comparison that stands in both."""

    page: Path
    numbers: Path
    rows: tuple[Compared, ...]


def write_reproduction(outcomes: Outcomes, out: Path, provenance: Mapping[str, str]) -> Reproduction:
    """Write page and numbers.

    Args:
        outcomes: of all jobs.
        out: folder.
        provenance: in words.

    Raises:
        InputError: the folder cannot be written.
    """
    rows = compared(outcomes)
    html = render_page(
        "reproduction.html",
        kind="reproduction",
        heading="The thesis's flights, reproduced and compared",
        static=False,
        badges=[f"{len(outcomes)} flights and searches", *_badges(rows)],
        tiles=_tiles(rows),
        comparison=tables.comparison_table(rows),
        sections=[shown for section in _SECTIONS if (shown := _shown(section, outcomes))["tables"]],
        provenance=provenance,
    )
    numbers = {
        "provenance": dict(provenance),
        "comparison": [dataclasses.asdict(row) for row in rows],
        "flights": [
            job_mapping(job) | {"lost": outcome.lost, "figures": outcome.figures}
            for job, outcome in sorted(outcomes.items(), key=lambda item: item[0].key)
        ],
    }
    write_page(out / PAGE, html, out / NUMBERS, numbers, {})
    return Reproduction(out / PAGE, out / NUMBERS, tuple(rows))


def _badges(rows: Sequence[Compared]) -> list[str]:
    held = sum(row.holds is True for row in rows)
    return [f"{held} of {len(rows)} reproduced"]


def _tiles(rows: Sequence[Compared]) -> list[tuple[str, str, str]]:
    """How many of each experiment's figures and claims hold."""
    experiments = dict.fromkeys(row.experiment for row in rows)
    return [
        (name, str(sum(row.holds is True for row in rows if row.experiment == name)), f"of {count}")
        for name in experiments
        for count in (sum(row.experiment == name for row in rows),)
    ]


def _shown(section: _Section, outcomes: Outcomes) -> dict[str, Any]:
    drawn = section.graphs(outcomes) if section.graphs is not None else []
    made = [table(outcomes) for table in section.tables]
    return {
        "key": section.key,
        "title": section.title,
        "words": WORDS.get(section.key, ()),
        "tables": [table for table in made if table.rows],
        "graphs": [live(graph, plotly_graph(graph)) for graph in drawn],
    }
