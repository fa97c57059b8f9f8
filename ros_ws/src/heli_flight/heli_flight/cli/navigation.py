"""`heli navigation`: how good the navigation of recorded flights was."""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from heli_common.errors import EXIT_FLOWN, InputError
from heli_flight.flight_record import FlightRecord
from heli_flight.navigation_check import (
    BANDWIDTHS,
    Row,
    differentiated,
    errors,
    gyro_bias_errors,
    imu_only,
    nees,
    row,
)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Describe the sub-command to the `heli` command."""
    parser = subparsers.add_parser(
        "navigation",
        help="errors, delays and honesty of the navigation in recorded flights",
        description="Compare the odometry of recorded flights with their truth: errors, delays, normalised "
        "errors, biases, the attitude by the IMU alone; beside the differentiator on the same bags.",
    )
    parser.add_argument("bags", type=Path, nargs="+", metavar="BAG", help="folders of bags")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(func=run)


def run(arguments: argparse.Namespace) -> int:
    """Assess the navigation of flights.

    Raises:
        InputError: no readable bag, or a flight that never flew.
    """
    try:
        found = assess([FlightRecord.load(folder) for folder in arguments.bags])
    except ValueError as error:
        raise InputError(str(error), allowed="whole flights of this version", key="BAG") from None
    if arguments.json:
        sys.stdout.write(json.dumps(found, indent=2) + "\n")
    else:
        show(found)
    return EXIT_FLOWN


def assess(records: list[FlightRecord]) -> dict[str, Any]:
    """Everything that is said about some flights, ready for JSON, SI."""
    rows = [row("Kalman filter, as flown", [errors(record, record.estimate) for record in records])]
    for bandwidth in BANDWIDTHS:
        flights = [errors(record, differentiated(record.bag, bandwidth)) for record in records]
        rows.append(row(f"differentiator, {bandwidth:g} rad/s", flights))
    honest = [nees(record) for record in records]
    alone = [imu_only(record) for record in records]
    bias = np.concatenate([gyro_bias_errors(record)[0][-1] for record in records])
    return {
        "flights": [str(record.bag.folder) for record in records],
        "rows": [asdict(each) for each in rows],
        "nees": {name: float(np.mean(np.concatenate([each[name] for each in honest]))) for name in honest[0]},
        "gyro_bias_at_end_rms": float(np.sqrt(np.mean(bias**2))),
        "imu_only": {
            "roll_pitch_rms": float(np.sqrt(np.mean([each.roll_pitch**2 for each in alone]))),
            "yaw_drift_over_sigma_rms": float(
                np.sqrt(np.mean([(each.yaw_drift / each.yaw_sigma) ** 2 for each in alone]))
            ),
            "yaw_sigma_mean": float(np.mean([each.yaw_sigma for each in alone])),
        },
    }


def show(found: dict[str, Any]) -> None:
    """Print what `assess` found as a table and a few lines.

    Args:
        found: see `assess`.
    """
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=130)
    table = Table("navigation", title=f"rms errors in free flight, {len(found['flights'])} flight(s)")
    for title in (
        "position [mm]",
        "velocity [cm/s]",
        "its delay [ms]",
        "attitude [deg]",
        "rates [deg/s]",
        "their delay [ms]",
    ):
        table.add_column(escape(title), justify="right")
    for entry in found["rows"]:
        each = Row(**entry)
        table.add_row(
            each.name,
            f"{1e3 * each.position:.2f}",
            f"{1e2 * each.velocity:.2f}",
            f"{1e3 * each.velocity_delay:.1f}",
            f"{math.degrees(each.attitude):.3f}",
            f"{math.degrees(each.rates):.2f}",
            f"{1e3 * each.rates_delay:.1f}",
        )
    console.print(table)
    honest = ", ".join(f"{name.replace('_', ' ')} {value:.2f}" for name, value in found["nees"].items())
    console.print(f"normalised error squared per degree of freedom: {honest}")
    console.print(f"gyro bias at the end: {math.degrees(found['gyro_bias_at_end_rms']):.3f} deg/s rms")
    alone = found["imu_only"]
    drift, sigma = alone["yaw_drift_over_sigma_rms"], math.degrees(alone["yaw_sigma_mean"])
    console.print(
        f"by the IMU alone: roll and pitch {math.degrees(alone['roll_pitch_rms']):.2f} deg rms, "
        f"yaw drift over its own sigma {drift:.2f} rms (sigma {sigma:.2f} deg)"
    )
