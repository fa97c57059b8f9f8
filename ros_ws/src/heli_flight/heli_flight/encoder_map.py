"""Map of the encoders' position error over the work space, as a PNG picture (matplotlib without a screen)."""

from __future__ import annotations

import io
from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure as Canvas
from matplotlib.patheffects import AbstractPathEffect, withStroke

from heli_common.rig_geometry import RigGeometry
from heli_navigation.encoder_budget import budget, steps

HEIGHTS, RADII = 41, 26
"""Points of the map."""

SECTOR = tuple(float(azimuth) for azimuth in np.radians(np.arange(0.0, 61.0, 5.0)))
"""Azimuths searched [rad]: a sixth of the turn, the rest is its mirror images."""

_INK = "#111827"
_STYLE = {
    "font.size": 9.0,
    "axes.edgecolor": "#9ca3af",
    "axes.labelcolor": "#374151",
    "xtick.color": "#4b5563",
    "ytick.color": "#4b5563",
}


def draw_map(geometry: RigGeometry, dpi: int = 120) -> bytes:
    """The PNG file: three sigma along the worst direction, at the worst azimuth, over radius and height.

    Args:
        geometry: of the rig.
        dpi: resolution.

    Raises:
        ValueError: the arms do not reach the whole work space.
    """
    heights = list(steps(geometry.work_bottom, geometry.work_top, HEIGHTS))
    radii = list(steps(0.0, geometry.work_radius, RADII))
    rings = budget(heights, radii, geometry, SECTOR)
    millimetres = np.array([ring.worst for ring in rings]).reshape(HEIGHTS, RADII) * 1e3
    with mpl.rc_context(_STYLE):
        canvas = Canvas(figsize=(6.4, 6.2), layout="constrained")
        FigureCanvasAgg(canvas)
        canvas.suptitle(
            "Position error of the encoders",
            x=0.02,
            ha="left",
            fontsize=12,
            fontweight="bold",
            color=_INK,
        )
        axis = canvas.subplots()
        axis.set_title(
            "3σ along the worst direction, at the worst azimuth", loc="left", fontsize=9, color="#6b7280"
        )
        levels = _levels(float(millimetres.min()), float(millimetres.max()))
        # every band a step of colour, wide or narrow
        bands = BoundaryNorm(levels, mpl.colormaps["Blues"].N)
        colours = axis.contourf(radii, heights, millimetres, levels, cmap="Blues", norm=bands)
        lines = axis.contour(radii, heights, millimetres, levels[1:-1], colors="white", linewidths=0.8)
        edge: list[AbstractPathEffect] = [withStroke(linewidth=2.0, foreground="white")]
        for label in axis.clabel(lines, fmt="%g", fontsize=8, colors=_INK, inline=False):
            x, y = axis.transAxes.inverted().transform(axis.transData.transform(label.get_position()))
            # half a number at the edge says less than none
            label.set_visible(0.02 < x < 0.98 and 0.02 < y < 0.98)
            label.set_path_effects(edge)
        axis.plot(0.0, geometry.centre_height, "+", color=_INK, markersize=11, clip_on=False, zorder=5)
        axis.annotate(
            "centre of the flight space",
            (0.0, geometry.centre_height),
            xytext=(9, -3),
            textcoords="offset points",
            color=_INK,
            fontsize=8,
        )
        axis.set_xlabel("distance from the axis [m]")
        axis.set_ylabel("height above the base plane [m]")
        bar = canvas.colorbar(colours, ax=axis, label="3σ [mm]", ticks=levels)
        bar.ax.tick_params(length=0)
        stream = io.BytesIO()
        canvas.savefig(stream, format="png", dpi=dpi, metadata={"Software": None})
    return stream.getvalue()


def _levels(low: float, high: float) -> Sequence[float]:
    """Contour levels [mm]: every quarter where the map is flat, every half and whole where it is steep."""
    steep = [*np.arange(0.0, 3.0, 0.25), *np.arange(3.0, 5.0, 0.5), *np.arange(5.0, 1000.0, 1.0)]
    below = max((level for level in steep if level <= low), default=0.0)
    above = min((level for level in steep if level >= high), default=high)
    return [float(level) for level in steep if below <= level <= above]
