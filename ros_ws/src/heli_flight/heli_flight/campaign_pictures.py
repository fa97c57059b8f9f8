"""Pictures of a campaign: distribution of the error, success, what the error depends on, the grid as map."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from heli_common.files import write_atomically
from heli_flight.campaign_flight import Campaign
from heli_flight.campaign_results import by_controller, controller_of, wilson
from heli_flight.picture import FLIGHT_COLOURS, STYLE
from heli_flight.vary_file import CONTROLLER

Row = Mapping[str, Any]
_DPI = 110


def write_pictures(folder: Path, rows: Sequence[Row], campaign: Campaign) -> list[Path]:
    """Draw everything there is to draw; the files.

    Args:
        folder: of the campaign.
        rows: of all flights.
        campaign: whose they are.
    """
    pictures: dict[str, Callable[[Sequence[Row], Campaign], Canvas]] = {
        "position_error.png": position_error,
        "success.png": success,
    }
    if campaign.vary.numbers:
        pictures["dependence.png"] = dependence
    if len(_map_names(campaign)) == 2:
        pictures["map.png"] = success_map
    written = []
    with mpl.rc_context(STYLE):
        for name, draw in pictures.items():
            stream = io.BytesIO()
            FigureCanvasAgg(draw(rows, campaign)).print_png(stream)
            write_atomically(folder / name, stream.getvalue())
            written.append(folder / name)
    return written


def position_error(rows: Sequence[Row], campaign: Campaign) -> Canvas:
    """Share of flights whose largest error stays below a value; lost flights count as beyond all."""
    canvas = Canvas(figsize=(7.5, 4.5), dpi=_DPI, layout="constrained")
    axis = canvas.subplots()
    for place, (name, flown) in enumerate(by_controller(rows, campaign).items()):
        good = [100.0 * row["max_position_m"] for row in flown if row["flown"]]
        values = np.sort([value for value in good if math.isfinite(value)])
        share = np.arange(1, len(values) + 1) / len(flown)
        axis.step(values, share, where="post", label=name, color=_colour(place), linewidth=1.4)
    axis.set(
        xlabel="largest distance from the reference in hover [cm]",
        ylabel="share of flights below",
        ylim=(0.0, 1.02),
        title=f"{campaign.plan.name}: {len(rows)} flights",
    )
    axis.legend()
    return canvas


def success(rows: Sequence[Row], campaign: Campaign) -> Canvas:
    """Success rate of each controller with its 95 % interval."""
    groups = by_controller(rows, campaign)
    canvas = Canvas(figsize=(7.5, 1.2 + 0.5 * len(groups)), dpi=_DPI, layout="constrained")
    axis = canvas.subplots()
    for place, flown in enumerate(groups.values()):
        share = wilson(sum(bool(row["success"]) for row in flown), len(flown))
        axis.plot(100.0 * share.rate, place, "o", color=_colour(place))
        axis.hlines(place, 100.0 * share.low, 100.0 * share.high, color=_colour(place), linewidth=2.0)
    axis.set(xlim=(-2.0, 102.0), xlabel="success [%], with 95 % interval (Wilson)")
    axis.set_yticks(range(len(groups)), list(groups))
    axis.invert_yaxis()
    return canvas


def dependence(rows: Sequence[Row], campaign: Campaign) -> Canvas:
    """Largest error over every number drawn; crosses above are flights without success."""
    names = list(campaign.vary.numbers)
    columns = min(3, len(names))
    lines = math.ceil(len(names) / columns)
    canvas = Canvas(figsize=(3.6 * columns, 2.8 * lines), dpi=_DPI, layout="constrained")
    axes = canvas.subplots(lines, columns, squeeze=False, sharey=True).ravel()
    errors = np.array([100.0 * row["max_position_m"] for row in rows])
    good = np.array([bool(row["success"]) for row in rows])
    colours = {name: _colour(place) for place, name in enumerate(by_controller(rows, campaign))}
    each = np.array([colours[controller_of(row, campaign)] for row in rows])
    shown = good & np.isfinite(errors)
    top = 1.08 * float(np.max(errors[shown], initial=1.0))
    for axis, name in zip(axes, names, strict=False):
        x = np.array([float(row[name]) for row in rows])
        axis.scatter(x[shown], errors[shown], s=6, c=each[shown], linewidths=0)
        axis.scatter(x[~good], np.full(int((~good).sum()), top), s=18, c=each[~good], marker="x")
        axis.set_xlabel(name, fontsize=8)
    for axis in axes[len(names) :]:
        axis.set_visible(False)
    axes[0].set_ylabel("largest error [cm]")
    return canvas


def success_map(rows: Sequence[Row], campaign: Campaign) -> Canvas:
    """Success rate over two numbers of the grid, one map per controller."""
    (across, up), grid = _map_names(campaign), campaign.vary.grid
    groups = by_controller(rows, campaign)
    canvas = Canvas(figsize=(1.0 + 3.1 * len(groups), 3.4), dpi=_DPI, layout="constrained")
    axes = canvas.subplots(1, len(groups), squeeze=False, sharey=True)[0]
    for axis, (name, flown) in zip(axes, groups.items(), strict=True):
        cells = {(i, j): [0, 0] for i in range(len(grid[across])) for j in range(len(grid[up]))}
        for row in flown:
            cell = cells[grid[across].index(row[across]), grid[up].index(row[up])]
            cell[0] += bool(row["success"])
            cell[1] += 1
        table = np.array(
            [
                [100.0 * cells[i, j][0] / max(cells[i, j][1], 1) for i in range(len(grid[across]))]
                for j in range(len(grid[up]))
            ]
        )
        axis.imshow(table, origin="lower", vmin=0.0, vmax=100.0, cmap="RdYlGn", aspect="auto")
        for (i, j), (won, flights) in cells.items():
            axis.text(i, j, f"{won}/{flights}", ha="center", va="center", fontsize=7)
        axis.set_xticks(range(len(grid[across])), [f"{value:g}" for value in grid[across]])
        axis.set_yticks(range(len(grid[up])), [f"{value:g}" for value in grid[up]])
        axis.set(title=name, xlabel=across)
        axis.grid(False)
    axes[0].set_ylabel(up)
    return canvas


def _map_names(campaign: Campaign) -> tuple[str, ...]:
    """The two numbers of the grid that have most values, if there are two."""
    numbers = [name for name in campaign.vary.grid if name != CONTROLLER and _numeric(campaign, name)]
    pairs = list(combinations(numbers, 2))
    return max(pairs, key=lambda pair: math.prod(len(campaign.vary.grid[n]) for n in pair), default=())


def _numeric(campaign: Campaign, name: str) -> bool:
    return all(isinstance(value, float) for value in campaign.vary.grid[name])


def _colour(place: int) -> str:
    return FLIGHT_COLOURS[place % len(FLIGHT_COLOURS)]
