"""Figures as PNG pictures (matplotlib without a screen)."""

from __future__ import annotations

import base64
import io
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from heli_flight.decimation import thinned
from heli_flight.figures import COMMAND, ESTIMATE, LIMIT, REFERENCE, TRUTH, Curve, Figure

FLIGHT_COLOURS = ("#3b82f6", "#d97706", "#059669", "#9333ea", "#dc2626", "#0891b2", "#65a30d", "#be185d")
ESTIMATE_OPACITY = 0.55
"""The estimate lies as a wide band below the truth: nearly always they are the same."""
ROLE_COLOURS = {
    TRUTH: FLIGHT_COLOURS[0],
    ESTIMATE: "#f59e0b",
    REFERENCE: "#6b7280",
    COMMAND: "#059669",
    LIMIT: "#dc2626",
}
_WIDTH = {TRUTH: 0.9, ESTIMATE: 2.4, REFERENCE: 1.1, COMMAND: 1.5}
STYLE = {
    "font.size": 9.0,
    "axes.edgecolor": "#9ca3af",
    "axes.labelcolor": "#374151",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e7eb",
    "xtick.color": "#4b5563",
    "ytick.color": "#4b5563",
    "path.simplify": True,
    "svg.fonttype": "none",
    "svg.hashsalt": "heli_flight",
}
"""Of matplotlib, for all pictures of a report."""


def colour(curve: Curve) -> str:
    """Of a curve: by its role, or by its flight where several are compared."""
    return (
        FLIGHT_COLOURS[curve.flight % len(FLIGHT_COLOURS)]
        if curve.role == TRUTH
        else ROLE_COLOURS[curve.role]
    )


def save_png(canvas: Canvas, dpi: int = 110) -> bytes:
    """The PNG file of a drawn canvas; the same bytes every time."""
    return _saved(canvas, "png", dpi=dpi, metadata={"Software": None})


def save_svg(canvas: Canvas) -> bytes:
    """The SVG file of a drawn canvas; the same bytes every time."""
    return _saved(canvas, "svg", metadata={"Creator": None, "Date": None})


def _saved(canvas: Canvas, kind: str, **options: Any) -> bytes:
    stream = io.BytesIO()
    with mpl.rc_context(STYLE):
        canvas.savefig(stream, format=kind, **options)
    return stream.getvalue()


def figure_canvas(figure: Figure) -> Canvas:
    """A figure drawn, to be saved as PNG or SVG."""
    with mpl.rc_context(STYLE):
        rows = len(figure.panels)
        canvas = Canvas(figsize=(10.0, 0.9 + 1.75 * rows), layout="constrained")
        FigureCanvasAgg(canvas)
        axes = canvas.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
        for axis, panel in zip(axes, figure.panels, strict=True):
            for band in figure.bands:
                axis.axvline(band.start, color="#d1d5db", linewidth=0.8, zorder=0)
            for curve in panel.curves:
                _draw(axis, curve)
            for limit in panel.limits:
                axis.axhline(limit, color=ROLE_COLOURS[LIMIT], linewidth=0.8, linestyle=":")
            axis.set_ylabel(f"{panel.label} [{panel.unit}]")
        for band in figure.bands:
            if band.end - band.start > 0.03 * (figure.bands[-1].end - figure.bands[0].start):
                axes[0].annotate(
                    band.label,
                    (band.start, 1.0),
                    xycoords=("data", "axes fraction"),
                    xytext=(3, 2),
                    textcoords="offset points",
                    fontsize=7.5,
                    color="#6b7280",
                )
        axes[-1].set_xlabel("time [s]")
        _legend(canvas, axes)
        canvas.suptitle(figure.title, x=0.01, ha="left", fontsize=12, fontweight="bold", color="#111827")
    return canvas


def _draw(axis: Any, curve: Curve) -> None:
    dashed = curve.role == REFERENCE
    x, y = thinned(curve.x, curve.y)
    axis.plot(
        x,
        y,
        label=curve.label,
        color=colour(curve),
        alpha=ESTIMATE_OPACITY if curve.role == ESTIMATE else 1.0,
        linewidth=_WIDTH[curve.role],
        linestyle="--" if dashed else "-",
        zorder=3 if dashed else 2,
    )


def _legend(canvas: Any, axes: Any) -> None:
    known: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    canvas.legend(
        known.values(), known.keys(), loc="outside upper right", ncols=min(len(known), 6), frameon=False
    )


def data_uri(png: bytes) -> str:
    """A picture as it stands inside an HTML file."""
    return "data:image/png;base64," + base64.b64encode(png).decode()
