"""The gain margin of controllers in simulated flight beside that of the linear loop as it flies.

Run: python benchmarks/flown_margin.py [CONTROLLER ...] [--axis horizontal|vertical] [--seed N] [--json].
A controller is a shipped name or a file; default: all shipped ones. One whose loop is not stable has no
margin and is named under the table.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from rich.console import Console
from rich.table import Table

from heli_common.errors import SafetyStop
from heli_control.controller_file import AXES, load_controller, shipped_controllers
from heli_flight.flown_margin import flown_margin


def main() -> None:
    """Fly, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("controllers", nargs="*", default=sorted(shipped_controllers()))
    parser.add_argument("--axis", choices=AXES, default=AXES[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    results, refused = [], []
    for name in options.controllers:
        controller = load_controller(name)
        try:
            results.append(flown_margin(controller, options.axis, seed=options.seed))
        except (SafetyStop, ValueError) as error:
            refused.append(f"{name}: {error}")
    if options.json:
        rows = [asdict(result) | {"difference_db": result.difference_db} for result in results]
        Console().print_json(json.dumps(rows))
        return
    table = Table(
        "controller",
        "flown [dB]",
        "linear [dB]",
        "difference [dB]",
        "delay margin [ms]",
        "trials (x lost)",
        title=f"gain margin, {options.axis}",
    )
    for result in results:
        flown = " ".join(f"{trial.level_db:.2f}{'x' if trial.lost else ''}" for trial in result.trials)
        table.add_row(
            result.controller,
            f"{result.flown_db:.2f}",
            f"{result.linear.gain_up_db:.2f}",
            f"{result.difference_db:+.2f}",
            f"{result.linear.delay_ms:.1f}",
            flown,
        )
    Console().print(table, *refused, sep="\n")


if __name__ == "__main__":
    main()
