"""What the source prints of its flights: data, nothing is computed here (source sec. 3.5 and 5.3)."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

CONTROLLERS = ("lq", "gst", "gst2", "ncf", "ncf2")
"""Of the source, in the order of its Table 5.2."""

TITLES = {
    "lq": "LQ",
    "gst": "GS/T 1DOF",
    "gst2": "GS/T 2DOF",
    "ncf": "loop shaping 1DOF",
    "ncf2": "loop shaping 2DOF",
}

Four = tuple[float, float, float, float]


def _hover(x: float, y: float, z: float, psi: float) -> Four:
    """From cm and deg."""
    return (0.01 * x, 0.01 * y, 0.01 * z, radians(psi))


HOVER: dict[str, Four] = {
    "lq": _hover(4.61, 6.47, 10.49, 8.17),
    "gst": _hover(4.30, 4.16, 8.16, 7.24),
    "gst2": _hover(3.88, 3.77, 4.62, 7.50),
    "ncf": _hover(0.96, 1.41, 7.89, 3.97),
    "ncf2": _hover(2.10, 2.15, 7.63, 8.50),
}
"""Table 5.2: standard deviations x, y, z [m] and psi [rad] of one hover each, of unknown length."""

LQ_HOVER = HOVER["lq"]

FARTHEST = {"lq": 0.10, "gst": 0.04, "ncf": 0.015}
"""Largest deviation in the xy plane [m], sec. 5.3.1; that of LQ can hardly be read."""


@dataclass(frozen=True)
class WindFlight:
    """One flight of sec. 5.3.2: wind from the front up to a speed [m/s] and what is said of it."""

    speed: float
    pitch_deg: float | None
    words: str


WIND: dict[str, WindFlight] = {
    "lq": WindFlight(4.3, -2.0, "offsets in position and velocity; no more was tried, too excited already"),
    "gst": WindFlight(5.0, -2.0, "smaller offset in position, smoother"),
    "ncf": WindFlight(3.0, None, "position exact and attitude calm up to here, then jumpy"),
}
"""Figures 5.11, 5.12 and the text beside them. The text gives the pitch as 2 deg, the figure as negative."""

NOISE_DEG: dict[str, tuple[float | None, float | None]] = {"lq": (None, 1.0), "ncf2": (1.2, None)}
"""Largest sigma borne and smallest sigma lost of white noise on B_1s [deg], sec. 5.3.3."""

OPERATING_POINT_DEG = {
    "theta": 0.798,
    "phi": -2.400,
    "A_M": -7.261,
    "B_1s": -1.515,
    "A_1s": -0.783,
    "A_R": 12.410,
}
"""Table 5.3: means over several hovers [deg]; A_M = -theta_0, A_R = theta_t."""

DEAD_TIME = 0.1
"""Of the wireless link [s], sec. 4.3: with it the cable was preferred."""
