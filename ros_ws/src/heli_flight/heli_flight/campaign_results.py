"""Results of a campaign: one table of all flights as Parquet, figures per controller, the worst flight."""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from heli_common.files import write_atomically
from heli_flight.campaign_flight import FIGURES, Campaign

TABLE, SUMMARY, WORST = "flights.parquet", "summary.json", "worst"
CONFIDENCE_Z = 1.959963984540054
"""Of a 95 % interval."""

Row = Mapping[str, Any]
_WHEN, _NUMBER = re.compile(r" at \d+\.\d+ s$"), re.compile(r"-?\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Share:
    """A success rate and its 95 % interval by Wilson's score."""

    successes: int
    flights: int
    rate: float
    low: float
    high: float


def wilson(successes: int, flights: int) -> Share:
    """The interval of a rate, good for small numbers and for rates of 0 and 1.

        (p + z^2 / 2n +- z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n)        (Wilson 1927)

    Args:
        successes: how many.
        flights: of how many, at least 1.

    Raises:
        ValueError: there are no flights, or more successes than flights.
    """
    if not 0 <= successes <= flights or flights < 1:
        raise ValueError(f"{successes} successes of {flights} flights")
    rate, square = successes / flights, CONFIDENCE_Z**2
    middle = rate + square / (2.0 * flights)
    half = CONFIDENCE_Z * math.sqrt(rate * (1.0 - rate) / flights + square / (4.0 * flights**2))
    whole = 1.0 + square / flights
    low, high = max(0.0, (middle - half) / whole), min(1.0, (middle + half) / whole)
    # at the ends the interval closes exactly; rounding must not open it
    low, high = (0.0 if successes == 0 else low), (1.0 if successes == flights else high)
    return Share(successes, flights, rate, low, high)


def controller_of(row: Row, campaign: Campaign) -> str:
    """Name of the controller that flew."""
    return str(row.get("controller", campaign.plan.controller))


def by_controller(rows: Sequence[Row], campaign: Campaign) -> dict[str, list[Row]]:
    """The flights of each controller, in the order in which they are first flown."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(controller_of(row, campaign), []).append(row)
    return found


def summary(rows: Sequence[Row], campaign: Campaign) -> dict[str, Any]:
    """Figures of each controller and of all, ready for JSON, SI.

    Args:
        rows: of all flights.
        campaign: whose they are.
    """
    groups = by_controller(rows, campaign)
    reasons: dict[str, int] = {}
    for row in rows:
        if not row["success"]:
            reasons[_kind(row)] = reasons.get(_kind(row), 0) + 1
    return {
        "plan": campaign.plan.name,
        "campaign_seed": campaign.vary.seed,
        "flights": len(rows),
        "controllers": {name: _figures(flown) for name, flown in groups.items()},
        "all": _figures(rows),
        "losses": dict(sorted(reasons.items())),
        "worst": worst(rows)["flight"],
    }


def _figures(rows: Sequence[Row]) -> dict[str, Any]:
    share = wilson(sum(bool(row["success"]) for row in rows), len(rows))
    found: dict[str, Any] = {"success": asdict(share)}
    for name in FIGURES:
        values = np.array([row[name] for row in rows])
        values = values[np.isfinite(values)]
        if len(values):
            quantiles = {"median": 0.5, "p95": 0.95, "max": 1.0}
            found[name] = {"mean": float(np.mean(values))} | {
                key: float(np.quantile(values, at)) for key, at in quantiles.items()
            }
    return found


def _kind(row: Row) -> str:
    """Why a flight is no success, without its numbers."""
    if row["reason"]:
        return _NUMBER.sub("..", _WHEN.sub("", str(row["reason"])))
    return "touched the stop" if row["touched"] else "too far from the reference"


def worst(rows: Sequence[Row]) -> Row:
    """The flight that was lost earliest, or else the one farthest from its reference; the first of equals.

    Args:
        rows: of all flights, at least one.
    """

    def badness(row: Row) -> tuple[float, ...]:
        error = row["max_position_m"]
        far = math.inf if math.isnan(error) else error
        early = -row["duration_s"] if row["reason"] else -math.inf
        return (not row["flown"], not row["success"], early, far, -row["flight"])

    return max(rows, key=badness)


def parquet(rows: Sequence[Row], campaign: Campaign) -> bytes:
    """The table of all flights as a Parquet file; the same bytes for the same rows.

    Args:
        rows: of all flights, by number.
        campaign: told in the file's metadata.
    """
    import pyarrow as pa
    from pyarrow import parquet as pq

    kinds = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), str: pa.string()}
    schema = pa.schema([(name, kinds[type(value)]) for name, value in rows[0].items()])
    meta = {"plan": campaign.plan.to_yaml(), "campaign_seed": str(campaign.vary.seed)}
    table = pa.table(
        {name: [row[name] for row in rows] for name in rows[0]}, schema=schema.with_metadata(meta)
    )
    stream = io.BytesIO()
    pq.write_table(table, stream, compression="zstd")
    return stream.getvalue()


def write_results(folder: Path, rows: Sequence[Row], campaign: Campaign) -> dict[str, Any]:
    """Write table, summary and worst flight; the summary.

    Args:
        folder: of the campaign.
        rows: of all flights, by number.
        campaign: whose they are.
    """
    found = summary(rows, campaign)
    write_atomically(folder / TABLE, parquet(rows, campaign))
    write_atomically(folder / SUMMARY, json.dumps(found, indent=2) + "\n")
    write_flight(folder / WORST, int(found["worst"]), rows, campaign)
    return found


def write_flight(folder: Path, number: int, rows: Sequence[Row], campaign: Campaign) -> None:
    """Write a flight so that `heli fly` flies it again: plan, parameters, controllers, row, command.

    Args:
        folder: for the files.
        number: of the flight.
        rows: of all flights, by number.
        campaign: whose it is.
    """
    drawn = campaign.drawn(number)
    names = {name: f"controller_{place}.yaml" for place, name in enumerate(drawn.plan.controllers)}
    for name, file in names.items():
        campaign.controllers[name].write(folder / file)
    campaign.motor.write(folder / "motor.yaml")
    paths = {name: str((folder / file).absolute()) for name, file in names.items()}
    phases = tuple(
        phase if phase.controller is None else replace(phase, controller=paths[phase.controller])
        for phase in drawn.plan.phases
    )
    plan = replace(drawn.plan, controller=paths[drawn.plan.controller], phases=phases)
    write_atomically(folder / "plan.yaml", plan.to_yaml())
    write_atomically(folder / "parameters.yaml", drawn.parameter_file)
    write_atomically(folder / "flight.json", json.dumps(rows[number], indent=2) + "\n")
    write_atomically(folder / "command.txt", command(folder) + "\n")


def command(folder: Path) -> str:
    """What flies the flight of a folder again, on the graph."""
    place = folder.absolute()
    return (
        f"heli fly {place}/plan.yaml --params-file {place}/parameters.yaml --motor {place}/motor.yaml "
        "--mode lockstep"
    )
