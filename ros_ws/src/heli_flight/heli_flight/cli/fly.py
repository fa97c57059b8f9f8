"""`heli fly`: a plan from start to bag and report, on the graph or in this process."""

from __future__ import annotations

import argparse
import dataclasses
import json
import re
import sys
from datetime import datetime
from pathlib import Path
from typing import Any

from heli_common.errors import EXIT_BAD_INPUT, EXIT_FLOWN, EXIT_INTERRUPTED, EXIT_SAFETY_STOP, InputError
from heli_common.model_file import ModelFile
from heli_common.topics import IDENTIFICATION, OPTIONAL_NODES
from heli_control.motor_controller_file import load_motor_controller
from heli_flight.bag import STORAGES
from heli_flight.cli.live import LiveProgress
from heli_flight.cli.planned import absolute, planned_order
from heli_flight.flight_hash import bag_hash, count_check
from heli_flight.flight_record import FlightRecord
from heli_flight.flying import fly
from heli_flight.metrics import flight_metrics
from heli_flight.mode import Mode
from heli_flight.order import FlightEnd, FlightOrder
from heli_flight.process_table import NODE_NAMES
from heli_flight.punctuality import FIGURES, punctuality, spoken

WORDS = {
    EXIT_FLOWN: "flown",
    EXIT_BAD_INPUT: "refused",
    EXIT_SAFETY_STOP: "safety stop",
    EXIT_INTERRUPTED: "interrupted",
}


def add_parser(words: Any) -> None:
    """Add `fly` to the command."""
    word = words.add_parser(
        "fly", help="fly a plan", description="Fly a plan; leaves a bag and a report and prints their paths."
    )
    word.add_argument("plan", nargs="?", default="hover_steps", help="shipped plan or path of a plan file")
    word.add_argument(
        "--mode",
        choices=[mode.value for mode in Mode],
        default=Mode.REALTIME.value,
        help="realtime: paced by the clock (default); lockstep: as fast as the graph goes; "
        "realtime_composed, composed: the same in one process, in real time all but the recorder; "
        "inprocess: without ROS",
    )
    word.add_argument("--seed", type=int, help="seed of every random number (default: the plan's)")
    word.add_argument(
        "--controller", help="shipped controller or controller file in place of the plan's first one"
    )
    word.add_argument("--motor", default="motor", help="shipped motor controller or a file (default: motor)")
    word.add_argument(
        "--plant", type=Path, help="model file: refuse controllers that were designed for another plant"
    )
    word.add_argument(
        "--replace",
        action="append",
        default=[],
        metavar="NODE=PROGRAM.py",
        help="fly with a program of your own in place of a node (docs/templates/my_controller_node.py)",
    )
    word.add_argument(
        "--params-file", type=Path, help="ROS 2 parameter file for the nodes (heli parameters prints one)"
    )
    word.add_argument("--out", type=Path, default=Path("flights"), help="folder for bags (default: flights)")
    word.add_argument("--name", help="name of the bag's folder (default: plan, mode and time of day)")
    word.add_argument("--storage", default="mcap", choices=tuple(STORAGES), help="how the bag is stored")
    word.add_argument("--no-report", action="store_true", help="leave the bag only")
    word.add_argument(
        "--no-real-time-scheduling",
        action="store_true",
        help="do not ask for SCHED_FIFO, which keeps times in real time and makes lockstep faster",
    )
    word.add_argument(
        "--with",
        dest="more",
        action="append",
        default=[],
        choices=OPTIONAL_NODES,
        help="an optional node that shall fly along though the plan does not ask for it",
    )
    word.add_argument(
        "--namespace", default="", metavar="NAME", help="of every node and topic: one bench beside another"
    )
    word.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    word.set_defaults(func=run)


def run(options: argparse.Namespace) -> int:
    """Fly as asked; returns the exit code."""
    order = _order(options)
    end = _fly(order, quiet=options.json)
    result = _result(order, end, report=not options.no_report)
    if end.reason and end.exit_code != EXIT_FLOWN:
        sys.stderr.write(f"heli fly: {end.reason}\n")
    if result is None:
        return end.exit_code
    if options.json:
        sys.stdout.write(json.dumps(result, indent=2) + "\n")
    else:
        _print(result)
    return end.exit_code


def _order(options: argparse.Namespace) -> FlightOrder:
    plant = ModelFile.read(options.plant).plant_hash if options.plant else ""
    order = planned_order(options.plan, options.seed, options.params_file, options.controller or "", plant)
    name = options.name or f"{order.plan.name}_{options.mode}_{datetime.now():%Y%m%d_%H%M%S}"
    bag = (options.out / name).absolute()
    if bag.exists():
        raise InputError("exists already", allowed="a new folder", file=bag, key="--name")
    return dataclasses.replace(
        order,
        mode=Mode(options.mode),
        bag=bag,
        real_time_scheduling=not options.no_real_time_scheduling,
        motor=load_motor_controller(options.motor),
        motor_name=absolute(options.motor),
        replaced=_replaced(options.replace, options.mode),
        with_identification=IDENTIFICATION in options.more,
        storage=options.storage,
        namespace=_namespace(options.namespace, options.mode),
    )


def _namespace(name: str, mode: str) -> str:
    """A namespace without the slashes around it."""
    bare = name.strip("/")
    if name and mode == Mode.INPROCESS.value:
        allowed = "realtime, lockstep: in this process there are no topics"
        raise InputError(f"in mode {mode}", allowed=allowed, key="--namespace")
    if name and not re.fullmatch(r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*", bare, re.ASCII):
        allowed = "letters, digits and _, no digit first, e.g. left"
        raise InputError(f"{name!r}", allowed=allowed, key="--namespace")
    return bare


def _replaced(words: list[str], mode: str) -> dict[str, Path]:
    """Programs by the name of the node whose place they take."""
    if words and (mode == Mode.INPROCESS.value or Mode(mode).composed):
        allowed = "realtime, lockstep: a program of one's own is a process"
        raise InputError(f"in mode {mode}", allowed=allowed, key="--replace")
    programs = {}
    for word in words:
        name, _, path = word.partition("=")
        if name not in NODE_NAMES:
            raise InputError(f"{name!r} is no node", allowed=", ".join(NODE_NAMES), key="--replace")
        if not Path(path).is_file():
            raise InputError(f"{path!r} is no file", allowed="NODE=PROGRAM.py", key=f"--replace {name}")
        programs[name] = Path(path).absolute()
    return programs


def _fly(order: FlightOrder, quiet: bool) -> FlightEnd:
    with LiveProgress(order.plan.duration, quiet) as live:
        return fly(order, live.show, live.warn)


def _result(order: FlightOrder, end: FlightEnd, report: bool) -> dict[str, Any] | None:
    """Everything about the flight; None if no bag was left."""
    if not (order.bag / "metadata.yaml").is_file():
        return None
    record = FlightRecord.load(order.bag)
    lost = sum(entry.lost for entry in count_check(record.bag))
    late = {key: int(value) for key, value in record.custom_data.items() if key.startswith("late_")}
    page = _report(order.bag) if report else None
    return {
        "ended": WORDS[end.exit_code],
        "reason": end.reason,
        "mode": order.mode.value,
        "seed": order.seed,
        "controller": order.notes()["controller"],
        "simulated_s": round(end.simulated_seconds, 3),
        "wall_s": round(end.wall_seconds, 3),
        "lost_messages": lost,
        "late_commands": late,
        "punctuality": punctuality(record.custom_data) if order.mode.paced else {},
        "paused_s": float(record.custom_data.get("paused_s", 0.0)),
        "metrics": flight_metrics(record),
        "bag": str(order.bag),
        "report": str(page) if page else None,
        "sha256": bag_hash(record.bag),
    }


def _report(bag: Path) -> Path:
    from heli_flight.report import write_report  # drawing libraries are slow to load

    return write_report([bag], bag / "report").page


def _print(result: dict[str, Any]) -> None:
    say = sys.stdout.write
    speed = result["simulated_s"] / max(result["wall_s"], 1e-9)
    say(f"{result['ended']}: {result['simulated_s']:.1f} s in {result['wall_s']:.1f} s ({speed:.1f} x)\n")
    say(f"lost messages {result['lost_messages']}")
    for key, count in result["late_commands"].items():
        say(f", {key.replace('late_', 'late ')} {count}")
    if result["paused_s"]:
        say(f", the bench itself was kept from running for {result['paused_s']:.3f} s")
    say("\n")
    for key, figures in result["punctuality"].items():
        said = ", ".join(f"{word} {figures[name]:.2f}" for word, name in FIGURES.items() if name in figures)
        say(f"{spoken(key)} {said} ms\n")
    say(f"bag {result['bag']}\n")
    if result["report"]:
        say(f"report {result['report']}\n")
    say(f"sha256 {result['sha256']}\n")
