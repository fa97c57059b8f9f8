"""Figures as plotly descriptions, drawn by the browser from within the report itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from heli_flight.decimation import thinned
from heli_flight.figures import COMMAND, ESTIMATE, LIMIT, REFERENCE, TRUTH, Curve, Figure
from heli_flight.picture import ESTIMATE_OPACITY, ROLE_COLOURS, colour

PANEL_HEIGHT = 190
_GRID = "rgba(128,128,128,0.22)"
_WIDTH = {TRUTH: 1.4, ESTIMATE: 3.2, REFERENCE: 1.5, COMMAND: 2.0}


def plotly_json(figure: Figure) -> str:
    """Data and layout of a figure for `Plotly.newPlot`; colours of text are the page's business."""
    drawn = _over_time(figure)
    drawn.update_layout(
        template="none",
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": "system-ui, sans-serif", "size": 12},
        legend={
            "orientation": "h",
            "x": 0.0,
            "xanchor": "left",
            "yref": "container",
            "y": 1.0,
            "yanchor": "top",
        },
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": "rgba(128,128,128,0.7)", "activecolor": "#2563eb"},
        hovermode="x unified",
    )
    return str(drawn.to_json())


def _over_time(figure: Figure) -> Any:
    rows = len(figure.panels)
    drawn = make_subplots(rows=rows, cols=1, shared_xaxes=True, vertical_spacing=0.22 / (rows + 2))
    shown: set[str] = set()
    for row, panel in enumerate(figure.panels, start=1):
        for curve in panel.curves:
            drawn.add_trace(_line(curve, panel.unit, curve.label not in shown), row=row, col=1)
            shown.add(curve.label)
        for limit in panel.limits:
            drawn.add_hline(
                y=limit, row=row, col=1, line={"color": ROLE_COLOURS[LIMIT], "width": 1, "dash": "dot"}
            )
        drawn.update_yaxes(title={"text": f"{panel.label} [{panel.unit}]", "standoff": 8}, row=row, col=1)
    drawn.update_xaxes(title_text="time [s]", row=rows, col=1)
    drawn.update_xaxes(gridcolor=_GRID, zeroline=False, showline=False)
    drawn.update_yaxes(gridcolor=_GRID, zeroline=False, automargin=True)
    shapes = [
        {
            "type": "rect",
            "xref": "x",
            "yref": "paper",
            "y0": 0.0,
            "y1": 1.0,
            "layer": "below",
            "x0": band.start,
            "x1": band.end,
            "fillcolor": "rgba(128,128,128,0.09)",
            "line": {"width": 0},
        }
        for band in figure.bands[::2]
    ]
    words = [
        {
            "x": band.start,
            "xref": "x",
            "xanchor": "left",
            "y": 1.0,
            "yref": "paper",
            "yanchor": "bottom",
            "text": band.label,
            "showarrow": False,
            "font": {"size": 11},
            "opacity": 0.7,
        }
        for band in figure.bands
        if band.end - band.start > 0.03 * (figure.bands[-1].end - figure.bands[0].start)
    ]
    drawn.update_layout(shapes=[*drawn.layout.shapes, *shapes], annotations=words)
    drawn.update_layout(height=70 + PANEL_HEIGHT * rows, margin={"l": 70, "r": 16, "t": 56, "b": 46})
    return drawn


def _line(curve: Curve, unit: str, in_legend: bool) -> Any:
    x, y = thinned(curve.x, curve.y)
    return go.Scatter(
        x=x.astype(np.float32),
        y=y.astype(np.float32),
        mode="lines",
        name=curve.label,
        legendgroup=curve.label,
        showlegend=in_legend,
        opacity=ESTIMATE_OPACITY if curve.role == ESTIMATE else 1.0,
        line={
            "color": colour(curve),
            "width": _WIDTH[curve.role],
            "dash": "dash" if curve.role == REFERENCE else "solid",
        },
        hovertemplate="%{y:.3f} " + unit,
    )
