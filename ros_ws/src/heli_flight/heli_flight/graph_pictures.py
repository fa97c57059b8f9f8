"""Graphs drawn by the browser (plotly) or as PNG and SVG pictures (matplotlib)."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
import plotly.graph_objects as go
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from plotly.subplots import make_subplots

from heli_flight.figures import REFERENCE
from heli_flight.graphs import GREY, Curve, Graph, Kind, Plot
from heli_flight.picture import FLIGHT_COLOURS, ROLE_COLOURS, STYLE, save_png

_GRID = "rgba(128,128,128,0.22)"
_LIMIT = "#dc2626"
_BAND_OPACITY, _PALE, _CLOUD = 0.22, 0.45, 0.3
_GAP = 0.72
"""Between rows of plots in a picture [inch]."""
_TOP, _BOTTOM, _BETWEEN = 40, 88, 76
"""Pixels above, below and between rows of plots."""
_ONE_LINE = 110
"""Letters that the names in a picture's legend may have to stand in one line."""
_SYMBOLS = {
    Kind.POINTS: {"symbol": "circle", "size": 4},
    Kind.CLOUD: {"symbol": "circle", "size": 3, "opacity": _CLOUD},
    Kind.CROSSES: {"symbol": "x-thin-open", "size": 9, "line": {"width": 2}},
    Kind.DIAMONDS: {"symbol": "diamond-open", "size": 10, "line": {"width": 2}},
}


def plotly_graph(graph: Graph) -> str:
    """Data and layout of a graph for `Plotly.newPlot`; colours of text are the page's business."""
    rows, columns = len(graph.rows), len(graph.rows[0])
    inside = rows * graph.row_height + (rows - 1) * _BETWEEN
    drawn = make_subplots(
        rows=rows,
        cols=columns,
        subplot_titles=[plot.title for row in graph.rows for plot in row],
        horizontal_spacing=(0.24 if graph.rows[0][0].y_log else 0.16) / columns if columns > 1 else 0.0,
        vertical_spacing=_BETWEEN / inside if rows > 1 else 0.0,
    )
    shown: set[str] = set()
    for row, plots in enumerate(graph.rows, start=1):
        for column, plot in enumerate(plots, start=1):
            for curve in plot.curves:
                for trace in _traces(curve, shown):
                    drawn.add_trace(trace, row=row, col=column)
            for limit in plot.limits:
                line = {"color": _LIMIT, "width": 1, "dash": "dot"}
                drawn.add_hline(y=limit, row=row, col=column, line=line)
            _axes(drawn, plot, row, column)
    if graph.timed:
        drawn.for_each_xaxis(lambda axis: axis.update(matches=None if axis.plotly_name == "xaxis" else "x"))
    drawn.update_yaxes(gridcolor=_GRID, zeroline=False, automargin=True)
    drawn.update_annotations(font_size=13)
    drawn.update_layout(
        template="none",
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": "system-ui, sans-serif", "size": 12},
        height=_TOP + inside + _BOTTOM,
        margin={"l": 60, "r": 14, "t": _TOP, "b": _BOTTOM},
        legend={
            "orientation": "h",
            "x": 0.0,
            "xanchor": "left",
            "yref": "container",
            "y": 0.0,
            "yanchor": "bottom",
        },
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": "rgba(128,128,128,0.7)", "activecolor": "#2563eb"},
        hovermode="closest",
    )
    return str(drawn.to_json())


def _traces(curve: Curve, shown: set[str]) -> list[go.Scatter]:
    """A curve for plotly; a label stands in the legend once."""
    colour, x = _colour(curve.colour), curve.x.astype(np.float32)
    named = {
        "name": curve.label,
        "legendgroup": curve.label,
        "showlegend": bool(curve.label) and curve.label not in shown,
    }
    shown.add(curve.label)
    if curve.kind is Kind.BAND and curve.upper is not None:
        around = np.concatenate((curve.y, curve.upper[::-1])).astype(np.float32)
        fill = f"rgba({int(colour[1:3], 16)},{int(colour[3:5], 16)},{int(colour[5:7], 16)},{_BAND_OPACITY})"
        return [
            go.Scatter(
                x=np.concatenate((x, x[::-1])),
                y=around,
                mode="lines",
                line={"width": 0},
                fill="toself",
                fillcolor=fill,
                hoverinfo="skip",
                **named,
            )
        ]
    y = curve.y.astype(np.float32)
    if curve.kind is Kind.STEMS:
        x = np.repeat(x, 3)
        y = np.column_stack((np.zeros(len(y)), y, np.full(len(y), np.nan))).ravel().astype(np.float32)
    if curve.kind in _SYMBOLS:
        marker = {"color": colour, **_SYMBOLS[curve.kind]}
        return [go.Scatter(x=x, y=y, mode="markers", marker=marker, **named)]
    line = {"color": colour, "width": 1.5, "dash": "dash" if curve.kind is Kind.DASHED else "solid"}
    if curve.kind is Kind.WIDE:
        return [go.Scatter(x=x, y=y, mode="lines", line=line | {"width": 4}, opacity=_PALE, **named)]
    return [go.Scatter(x=x, y=y, mode="lines", line=line, **named)]


def _axes(drawn: Any, plot: Plot, row: int, column: int) -> None:
    x_range, ticks = plot.x_range, None
    if plot.log:
        low, high = _ends(plot)
        x_range, ticks = (float(np.log10(low)), float(np.log10(high))), _decades(low, high)
    drawn.update_xaxes(
        type="log" if plot.log else "linear",
        title={"text": plot.x_label, "standoff": 4},
        range=x_range,
        tickvals=ticks,
        ticktext=None if ticks is None else [f"{tick:g}" for tick in ticks],
        gridcolor=_GRID,
        zeroline=False,
        showline=False,
        row=row,
        col=column,
    )
    drawn.update_yaxes(title={"text": plot.y_label, "standoff": 4}, row=row, col=column)
    if plot.y_range is not None:
        drawn.update_yaxes(range=list(plot.y_range), row=row, col=column)
    if plot.y_log:
        drawn.update_yaxes(type="log", exponentformat="power", dtick=1, row=row, col=column)
    if plot.equal:
        (name,) = {axis.plotly_name for axis in drawn.select_xaxes(row=row, col=column)}
        drawn.update_yaxes(scaleanchor=name.replace("axis", ""), constrain="domain", row=row, col=column)
        drawn.update_xaxes(constrain="domain", row=row, col=column)


def graph_png(graph: Graph, dpi: int = 110) -> bytes:
    """The PNG file of a graph."""
    return save_png(graph_canvas(graph), dpi)


def graph_canvas(graph: Graph) -> Canvas:
    """A graph drawn, to be saved as PNG or SVG."""
    rows, columns = len(graph.rows), len(graph.rows[0])
    width, height = 12.0, 1.5 + (graph.row_height / 100.0 + _GAP) * rows
    with mpl.rc_context(STYLE):
        canvas = Canvas(figsize=(width, height))
        FigureCanvasAgg(canvas)
        axes = canvas.subplots(rows, columns, squeeze=False)
        # placed by hand: an automatic layout draws everything twice
        canvas.subplots_adjust(
            left=0.75 / width,
            right=1.0 - 0.15 / width,
            top=1.0 - 0.75 / height,
            bottom=0.85 / height,
            wspace=0.07 * columns + 0.06,
            hspace=_GAP / (graph.row_height / 100.0),
        )
        known: dict[str, Any] = {}
        for line, plots in zip(axes, graph.rows, strict=True):
            for axis, plot in zip(line, plots, strict=True):
                _draw(axis, plot)
                for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
                    known.setdefault(label, handle)
        place = {"x": 0.01, "y": 1.0 - 0.08 / height, "va": "top", "ha": "left"}
        canvas.suptitle(graph.title, **place, fontsize=12, fontweight="bold", color="#111827")
        columns = len(known) if sum(map(len, known)) < _ONE_LINE else 6
        canvas.legend(known.values(), known.keys(), loc="lower center", ncols=max(1, columns), frameon=False)
    return canvas


def _draw(axis: Any, plot: Plot) -> None:
    for curve in plot.curves:
        _curve(axis, curve)
    for limit in plot.limits:
        axis.axhline(limit, color=_LIMIT, linewidth=0.8, linestyle=":")
    if plot.log:
        low, high = _ends(plot)
        axis.set_xscale("log")
        axis.set_xlim(low, high)
        axis.xaxis.set_major_locator(FixedLocator(_decades(low, high)))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.xaxis.set_minor_locator(NullLocator())
    elif plot.x_range is not None:
        axis.set_xlim(*plot.x_range)
    if plot.y_log:
        axis.set_yscale("log")
    if plot.y_range is not None:
        axis.set_ylim(*plot.y_range)
    if plot.equal:
        axis.set_aspect("equal", adjustable="box")
    axis.set_title(plot.title, fontsize=9.5, color="#374151")
    axis.set_xlabel(plot.x_label, labelpad=1)
    axis.set_ylabel(plot.y_label, labelpad=1)


def _curve(axis: Any, curve: Curve) -> None:
    colour, label = _colour(curve.colour), curve.label or None
    if curve.kind is Kind.BAND and curve.upper is not None:
        shade = {"color": colour, "alpha": _BAND_OPACITY, "linewidth": 0.0}
        axis.fill_between(curve.x, curve.y, curve.upper, label=label, **shade)
    elif curve.kind is Kind.STEMS:
        axis.vlines(curve.x, 0.0, curve.y, color=colour, linewidth=1.4, label=label)
    elif curve.kind is Kind.POINTS:
        axis.plot(curve.x, curve.y, ".", color=colour, markersize=3.5, label=label)
    elif curve.kind is Kind.CLOUD:
        dots = {"markersize": 2.2, "markeredgewidth": 0.0, "alpha": _CLOUD}
        axis.plot(curve.x, curve.y, "o", color=colour, label=label, **dots)
    elif curve.kind is Kind.CROSSES:
        axis.plot(curve.x, curve.y, "x", color=colour, markersize=6, markeredgewidth=1.5, label=label)
    elif curve.kind is Kind.DIAMONDS:
        hollow = {"markerfacecolor": "none", "markeredgecolor": colour, "markeredgewidth": 1.5}
        axis.plot(curve.x, curve.y, "D", markersize=6, linestyle="none", zorder=4, label=label, **hollow)
    elif curve.kind is Kind.WIDE:
        axis.plot(curve.x, curve.y, color=colour, linewidth=3.2, alpha=_PALE, label=label)
    else:
        style = "--" if curve.kind is Kind.DASHED else "-"
        axis.plot(curve.x, curve.y, style, color=colour, linewidth=1.1, label=label)


def _ends(plot: Plot) -> tuple[float, float]:
    """Of a logarithmic axis."""
    if plot.x_range is not None:
        return plot.x_range
    if not plot.curves:
        return 0.1, 10.0
    return min(float(c.x.min()) for c in plot.curves), max(float(c.x.max()) for c in plot.curves)


def _decades(low: float, high: float) -> list[float]:
    """Ticks at every decade, of a short axis at 1, 2 and 5 in each."""
    steps = (1.0,) if high > 300.0 * low else (1.0, 2.0, 5.0)
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    every = [step * 10.0**decade for decade in decades for step in steps]
    return [value for value in every if low * 0.999 <= value <= high * 1.001]


def _colour(number: int) -> str:
    return ROLE_COLOURS[REFERENCE] if number == GREY else FLIGHT_COLOURS[number % len(FLIGHT_COLOURS)]
