"""`heli model encoders`: how well the encoders' whole counts can tell position and attitude."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from math import degrees
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from heli_common.errors import InputError
from heli_common.files import write_atomically
from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_navigation.encoder_budget import RingError, attitude_three_sigma, budget, ring_error, steps

HEIGHTS, RADII = 9, 3
"""Rows of the table: evenly spaced over the work space, both ends included."""

PLAIN_WIDTH = 112
"""Columns when nobody says how many there are: in a file or a pipe."""


def add_job(jobs: Any) -> None:
    """Add `encoders` to `heli model`."""
    text = "error of position and attitude from the encoders' quantisation, over the work space"
    job = jobs.add_parser(
        "encoders",
        help=text,
        description=f"{text[0].upper()}{text[1:]} (three sigma, each at its worst azimuth).",
    )
    job.add_argument("--json", action="store_true", help="print one JSON object in SI")
    job.add_argument(
        "--out", type=Path, metavar="FILE.png", help="draw a map of the worst error over radius and height"
    )
    job.set_defaults(func=run_encoders)


def run_encoders(options: argparse.Namespace) -> int:
    """Compute, print, draw.

    Args:
        options: of the command line.

    Raises:
        InputError: the picture's name does not end in .png, or it cannot be written.
    """
    geometry = RigGeometry()
    if options.out is not None:
        _draw(geometry, options.out)
    heights = list(steps(geometry.work_top, geometry.work_bottom, HEIGHTS))
    rings = budget(heights, list(steps(0.0, geometry.work_radius, RADII)), geometry)
    centre = ring_error(geometry.centre_height, 0.0, geometry)
    if options.json:
        mapping = as_mapping(geometry, centre, rings) | {"figure": options.out and str(options.out)}
        sys.stdout.write(json.dumps(mapping, indent=2, allow_nan=False) + "\n")
        return 0
    console = Console(highlight=False)
    show(centre, rings, console if console.is_terminal else Console(width=PLAIN_WIDTH, highlight=False))
    if options.out is not None:
        sys.stdout.write(f"figure {options.out}\n")
    return 0


def as_mapping(geometry: RigGeometry, centre: RingError, rings: tuple[RingError, ...]) -> dict[str, Any]:
    """Everything for JSON: metres and radians, heights above the base plane.

    Args:
        geometry: of the rig.
        centre: error at the centre of the flight space.
        rings: errors over the work space.
    """
    return {
        "count": RADIAN_PER_COUNT,
        "work_space": {
            "radius": geometry.work_radius,
            "bottom": geometry.work_bottom,
            "top": geometry.work_top,
        },
        "attitude_three_sigma": attitude_three_sigma()._asdict(),
        "attitude_largest": 0.5 * RADIAN_PER_COUNT,
        "centre": asdict(centre),
        "worst": asdict(_worst(rings)),
        "position": [asdict(ring) for ring in rings],
    }


def show(centre: RingError, rings: tuple[RingError, ...], console: Console) -> None:
    """Print the table, and below it what the encoders do at the centre, at the worst place and to attitude.

    Args:
        centre: error at the centre of the flight space.
        rings: errors over the work space.
        console: where to.
    """
    table = Table(title="position error from the encoders' quantisation, 3σ, each at its worst azimuth")
    for name in (
        "height [m]",
        "radius [m]",
        "one count [mm]",
        "north [mm]",
        "east [mm]",
        "down [mm]",
        "worst [mm]",
        "azimuth [deg]",
    ):
        table.add_column(name.replace("[", "\\["), justify="right")
    before = None
    for ring in rings:
        if before not in (None, ring.height):
            table.add_section()
        table.add_row(
            f"{ring.height:.2f}" if before != ring.height else "",
            f"{ring.radius:.2f}",
            *(
                f"{1e3 * length:.2f}"
                for length in (ring.per_count, ring.north, ring.east, ring.down, ring.worst)
            ),
            f"{degrees(ring.azimuth):.0f}" if ring.radius > 0.0 else "-",
        )
        before = ring.height
    console.print(table)
    worst = _worst(rings)
    attitude = attitude_three_sigma()
    for line in (
        "height above the base plane, radius from the axis; no error exceeds 3σ by more than 4 %",
        f"centre of the flight space: one count of one arm {1e3 * centre.per_count:.2f} mm, "
        f"3σ horizontally {1e3 * centre.north:.2f} mm, in height {1e3 * centre.down:.2f} mm",
        f"worst in the table: {1e3 * worst.worst:.2f} mm at height {worst.height:.2f} m, "
        f"radius {worst.radius:.2f} m, where one count of one arm is {1e3 * worst.per_count:.2f} mm",
        f"yaw, pitch, roll everywhere: 3σ {degrees(attitude.psi):.3f} deg each, "
        f"largest error half a count, {degrees(0.5 * RADIAN_PER_COUNT):.3f} deg",
    ):
        console.print(line, soft_wrap=True)


def _worst(rings: tuple[RingError, ...]) -> RingError:
    return max(rings, key=lambda ring: ring.worst)


def _draw(geometry: RigGeometry, path: Path) -> None:
    if path.suffix.lower() != ".png":
        raise InputError(
            f"cannot draw into {path.suffix or 'a name without ending'}", allowed=".png", file=path
        )
    from heli_flight.encoder_map import draw_map  # drawing libraries are slow to load

    try:
        write_atomically(path, draw_map(geometry))
    except OSError as error:
        raise InputError(f"cannot write the figure: {error.strerror}", file=path) from None
