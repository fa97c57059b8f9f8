"""What stands on the flight report's page, section by section, of one or several flights."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from heli_flight.estimation_figures import estimation_graph
from heli_flight.figures import Figure, flight_figure
from heli_flight.flight_record import FlightRecord
from heli_flight.graphs import Graph
from heli_flight.hover_figures import hover_graph
from heli_flight.page_tables import Table
from heli_flight.report_tables import (
    command_table,
    difference_table,
    estimation_table,
    hover_table,
    mapping,
    sampling_table,
    step_table,
    wind_table,
)
from heli_flight.sensor_figures import air_figure, imu_figure
from heli_flight.spectrum_figures import spectrum_graph
from heli_flight.step_figures import step_graph


@dataclass(frozen=True)
class Flights:
    """The flights of one report.

    Attributes:
        records: at least one.
        names: short ones that tell them apart.
        summaries: of each its name, provenance, figures of merit and sampling.
    """

    records: Sequence[FlightRecord]
    names: Sequence[str]
    summaries: Sequence[dict[str, Any]]


@dataclass(frozen=True)
class Content:
    """Of a section; without tables and figures it is left out, unless it says why."""

    tables: tuple[Table, ...] = ()
    figures: tuple[Figure | Graph, ...] = ()
    note: str = ""


@dataclass(frozen=True)
class Section:
    """One section of the page.

    Attributes:
        key: of links. title: for people.
        build: makes its content.
    """

    key: str
    title: str
    build: Callable[[Flights], Content] = field(repr=False)


def _tables(flights: Flights, *tables: Table) -> tuple[Table, ...]:
    """Those with rows; a single flight needs no column of names."""
    found = tuple(table for table in tables if table.rows)
    if len(flights.records) > 1:
        return found
    return tuple(
        replace(table, header=table.header[1:], rows=tuple(row[1:] for row in table.rows)) for table in found
    )


def _figures(*figures: Figure | Graph | None) -> tuple[Figure | Graph, ...]:
    return tuple(
        figure
        for figure in figures
        if figure is not None and (isinstance(figure, Graph) or any(panel.curves for panel in figure.panels))
    )


def _one(key: str) -> Callable[[Flights], Content]:
    return lambda flights: Content(figures=_figures(flight_figure(key, flights.records, flights.names)))


def _steps(flights: Flights) -> Content:
    graph = step_graph(flights.records, flights.names)
    return Content(_tables(flights, step_table(flights.summaries)), _figures(graph))


def _hover(flights: Flights) -> Content:
    graph = hover_graph(flights.records, flights.names)
    return Content(_tables(flights, hover_table(flights.summaries)), _figures(graph))


def _commands(flights: Flights) -> Content:
    figure = flight_figure("commands", flights.records, flights.names)
    return Content(_tables(flights, command_table(flights.summaries)), _figures(figure))


def _spectra(flights: Flights) -> Content:
    return Content(figures=_figures(spectrum_graph(flights.records, flights.names)))


def _wind(flights: Flights) -> Content:
    table = wind_table(flights.summaries)
    if not table.rows and all(len(record.series["wind"].stamps) for record in flights.records):
        return Content(note="The air stood still.")
    return Content(_tables(flights, table), _figures(air_figure(flights.records, flights.names)))


def _estimation(flights: Flights) -> Content:
    graph, imu = (draw(flights.records, flights.names) for draw in (estimation_graph, imu_figure))
    return Content(_tables(flights, estimation_table(flights.summaries)), _figures(graph, imu))


def _sampling(flights: Flights) -> Content:
    tables = [sampling_table(summary) for summary in flights.summaries]
    return Content(tuple(tables if len(tables) > 1 else [replace(tables[0], title="")]))


def _differences(flights: Flights) -> Content:
    if len(flights.records) < 2:
        return Content()
    parameters = [mapping(record.custom_data.get("parameters", "")) for record in flights.records]
    table = difference_table(flights.summaries, parameters)
    return Content((table,)) if any(parameters) else Content()


SECTIONS = (
    Section("steps", "Steps", _steps),
    Section("hover", "Hover", _hover),
    Section("position", "Position", _one("position")),
    Section("attitude", "Attitude", _one("attitude")),
    Section("velocity", "Velocity", _one("velocity")),
    Section("commands", "Commands", _commands),
    Section("rotor", "Rotor and motor", _one("rotor")),
    Section("spectra", "Spectra", _spectra),
    Section("wind", "Wind", _wind),
    Section("estimation", "Estimated against true", _estimation),
    Section("sampling", "Sampling and losses", _sampling),
    Section("differences", "Differences", _differences),
)
"""Between the overview and the provenance, in this order."""


def contents(flights: Flights) -> Iterator[tuple[Section, Content]]:
    """The sections that have something to show.

    Args:
        flights: of the report.
    """
    for section in SECTIONS:
        content = section.build(flights)
        if content.tables or content.figures or content.note:
            yield section, content
