"""`heli replay`: recorded inputs into a node's component, and whether it sends what it sent in flight."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from heli_common.errors import EXIT_DIFFERENT, EXIT_FLOWN
from heli_flight.bag_reader import read_bag
from heli_flight.replay_check import replay


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Describe the sub-command to the `heli` command."""
    parser = subparsers.add_parser(
        "replay",
        help="recorded inputs into a node: does it send what it sent?",
        description="Feed the recorded inputs of a node into it, built as it flew, without ROS. "
        "To play a bag into a live graph, use replay.sh.",
    )
    parser.add_argument("bag", type=Path, metavar="BAG", help="folder of the bag")
    parser.add_argument(
        "--into",
        required=True,
        metavar="NODE",
        help="any but the recorder",
    )
    parser.add_argument("--check", action="store_true", help="exit code 1 unless every byte is the same")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(func=run)


def run(arguments: argparse.Namespace) -> int:
    """Replay and compare.

    Raises:
        InputError: no readable bag, no such node, or something of the flight is missing.
    """
    found = replay(read_bag(arguments.bag), arguments.into)
    same = all(topic.same for topic in found)
    if arguments.json:
        sys.stdout.write(json.dumps({"same": same, "topics": [asdict(topic) for topic in found]}) + "\n")
    else:
        table = Table("topic", "recorded", "repeated", "first difference", box=None, pad_edge=False)
        for topic in found:
            where = "-" if topic.different is None else f"{topic.different * 1e-9:.4f} s"
            table.add_row(topic.topic, str(topic.recorded), str(topic.repeated), where)
        console = Console(highlight=False)
        console.print(table)
        console.print("every byte is the same" if same else "not the same")
        if not found[0].whole:
            until = found[0].until_ns * 1e-9
            console.print(f"compared until {until:.3f} s: the flight has no end in this bag")
    return EXIT_FLOWN if same or not arguments.check else EXIT_DIFFERENT
