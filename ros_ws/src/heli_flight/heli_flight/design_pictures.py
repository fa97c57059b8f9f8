"""Charts of the design report, drawn by the browser (plotly) or as PNG pictures (matplotlib)."""

from __future__ import annotations

import io
from typing import Any

import matplotlib as mpl
import numpy as np
import plotly.graph_objects as go
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from plotly.subplots import make_subplots

from heli_flight.design_charts import Chart, Plot
from heli_flight.picture import FLIGHT_COLOURS, STYLE

ROW_HEIGHT = 270
_GRID = "rgba(128,128,128,0.22)"
_LIMIT = "#dc2626"
_ONE_LINE = 110
"""Letters that the names in a picture's legend may have to stand in one line."""


def plotly_chart(chart: Chart) -> str:
    """Data and layout of a chart for `Plotly.newPlot`; colours of text are the page's business."""
    rows, columns = len(chart.rows), len(chart.rows[0])
    drawn = make_subplots(
        rows=rows,
        cols=columns,
        subplot_titles=[plot.title for row in chart.rows for plot in row],
        horizontal_spacing=0.14 / columns,
        vertical_spacing=0.30 / (rows + 1),
    )
    shown: set[str] = set()
    for row, plots in enumerate(chart.rows, start=1):
        for column, plot in enumerate(plots, start=1):
            _fill(drawn, chart, plot, row, column, shown)
        drawn.update_yaxes(title={"text": f"[{plots[0].unit}]", "standoff": 4}, row=row, col=1)
    for column in range(1, columns + 1):
        drawn.update_xaxes(title={"text": chart.x_label, "standoff": 6}, row=rows, col=column)
    ends = [float(np.log10(chart.x[0])), float(np.log10(chart.x[-1]))]
    drawn.update_xaxes(
        type="log",
        range=ends,
        gridcolor=_GRID,
        zeroline=False,
        showline=False,
        tickvals=_ticks(chart),
        ticktext=[f"{value:g}" for value in _ticks(chart)],
    )
    drawn.update_yaxes(gridcolor=_GRID, zeroline=False, automargin=True)
    drawn.update_annotations(font_size=13)
    drawn.update_layout(
        template="none",
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": "system-ui, sans-serif", "size": 12},
        height=100 + ROW_HEIGHT * rows,
        margin={"l": 56, "r": 12, "t": 52, "b": 92},
        legend={
            "orientation": "h",
            "x": 0.0,
            "xanchor": "left",
            "yref": "container",
            "y": 0.0,
            "yanchor": "bottom",
        },
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": "rgba(128,128,128,0.7)", "activecolor": "#2563eb"},
        hovermode="x unified" if columns == 1 else "closest",
    )
    return str(drawn.to_json())


def _fill(drawn: Any, chart: Chart, plot: Plot, row: int, column: int, shown: set[str]) -> None:
    """Curves, printed values and limits of one plot; a label stands in the legend once."""
    low = plot.range[0] - 60.0 if plot.range else -np.inf
    for trace in plot.traces:
        drawn.add_trace(
            go.Scatter(
                x=chart.x.astype(np.float32),
                y=np.maximum(trace.y, low).astype(np.float32),
                mode="lines",
                name=trace.label,
                legendgroup=trace.label,
                showlegend=trace.label not in shown,
                line={
                    "color": _colour(trace.colour),
                    "width": 1.7,
                    "dash": "dash" if trace.dashed else "solid",
                },
                hovertemplate="%{x:.3g} rad/s: %{y:.2f} " + plot.unit
                if "rad/s" in chart.x_label
                else "%{x:.3g}: %{y:.2f} " + plot.unit,
            ),
            row=row,
            col=column,
        )
        shown.add(trace.label)
    for marker in plot.markers:
        drawn.add_trace(
            go.Scatter(
                x=[marker.x],
                y=[marker.y],
                mode="markers",
                name=marker.label,
                legendgroup=marker.label,
                showlegend=marker.label not in shown,
                marker={
                    "symbol": "diamond-open",
                    "size": 10,
                    "color": _colour(marker.colour),
                    "line": {"width": 2},
                },
                hovertemplate="published: %{x:.3g} rad/s",
            ),
            row=row,
            col=column,
        )
        shown.add(marker.label)
    for limit in plot.limits:
        drawn.add_hline(y=limit, row=row, col=column, line={"color": _LIMIT, "width": 1, "dash": "dot"})
    if plot.range:
        drawn.update_yaxes(range=list(plot.range), row=row, col=column)


def chart_png(chart: Chart, dpi: int = 110) -> bytes:
    """The PNG file of a chart."""
    rows, columns = len(chart.rows), len(chart.rows[0])
    with mpl.rc_context(STYLE):
        width, height = (12.0 if columns > 1 else 9.0), 1.5 + 2.6 * rows
        canvas = Canvas(figsize=(width, height))
        FigureCanvasAgg(canvas)
        axes = canvas.subplots(rows, columns, sharex=True, squeeze=False)
        # placed by hand: an automatic layout draws everything twice
        canvas.subplots_adjust(
            left=0.6 / width,
            right=1.0 - 0.15 / width,
            top=1.0 - 0.7 / height,
            bottom=0.9 / height,
            wspace=0.16,
            hspace=0.24,
        )
        known: dict[str, Any] = {}
        for row, plots in zip(axes, chart.rows, strict=True):
            for axis, plot in zip(row, plots, strict=True):
                _draw(axis, chart, plot)
                for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
                    known.setdefault(label, handle)
        for axis in axes[-1]:
            axis.set_xlabel(chart.x_label)
        canvas.suptitle(
            chart.title,
            x=0.01,
            y=1.0 - 0.08 / height,
            va="top",
            ha="left",
            fontsize=12,
            fontweight="bold",
            color="#111827",
        )
        canvas.legend(
            known.values(),
            known.keys(),
            loc="lower center",
            ncols=len(known) if sum(map(len, known)) < _ONE_LINE else 6,
            frameon=False,
        )
        stream = io.BytesIO()
        canvas.savefig(stream, format="png", dpi=dpi, metadata={"Software": None})
    return stream.getvalue()


def _draw(axis: Any, chart: Chart, plot: Plot) -> None:
    for trace in plot.traces:
        axis.plot(
            chart.x,
            trace.y,
            label=trace.label,
            color=_colour(trace.colour),
            linewidth=1.3,
            linestyle="--" if trace.dashed else "-",
        )
    for marker in plot.markers:
        axis.plot(
            marker.x,
            marker.y,
            "D",
            label=marker.label,
            markerfacecolor="none",
            markeredgecolor=_colour(marker.colour),
            markersize=6,
            markeredgewidth=1.5,
            linestyle="none",
            zorder=4,
        )
    for limit in plot.limits:
        axis.axhline(limit, color=_LIMIT, linewidth=0.8, linestyle=":")
    axis.set_xscale("log")
    axis.set_xlim(chart.x[0], chart.x[-1])
    axis.xaxis.set_major_locator(FixedLocator(_ticks(chart)))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_locator(NullLocator())
    if plot.range:
        axis.set_ylim(*plot.range)
    axis.set_title(plot.title, fontsize=9.5, color="#374151")
    axis.set_ylabel(f"[{plot.unit}]", labelpad=1)


def _ticks(chart: Chart) -> list[float]:
    """Decades, or 1, 2 and 5 in each if the axis is short."""
    low, high = float(chart.x[0]), float(chart.x[-1])
    steps = (1.0,) if _long(chart) else (1.0, 2.0, 5.0)
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    every = [step * 10.0**decade for decade in decades for step in steps]
    return [value for value in every if low * 0.999 <= value <= high * 1.001]


def _long(chart: Chart) -> bool:
    return bool(chart.x[-1] > 30.0 * chart.x[0])


def _colour(number: int) -> str:
    return FLIGHT_COLOURS[number % len(FLIGHT_COLOURS)]
