"""`heli bag`: what is in a bag, and where two flights differ."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from heli_common.errors import EXIT_DIFFERENT, EXIT_FLOWN, InputError
from heli_flight.bag import STORAGES
from heli_flight.bag_check import BagState, bag_state, write_again
from heli_flight.bag_reader import Bag, read_bag
from heli_flight.flight_hash import bag_hash, count_check, first_difference

EXIT_NOT_WHOLE = 1
SHOWN_LINES = 40


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Describe the sub-command to the `heli` command."""
    parser = subparsers.add_parser("bag", help="look into bags", description="Look into recorded flights.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    info = commands.add_parser(
        "info",
        help="topics, counts, losses, hash and remarks of a bag",
        description="Topics, counts, losses, hash and remarks of a bag; also of one that was cut off.",
    )
    info.add_argument("bag", type=Path, metavar="BAG", help="folder of the bag")
    info.add_argument("--json", action="store_true", help="print JSON")
    info.set_defaults(func=run_info)
    check = commands.add_parser(
        "check",
        help="whether a bag is whole, what is lost, and a repaired copy",
        description="Say whether a bag is whole and what is lost; exit code 1 if it is not. "
        "The bag itself is not touched.",
    )
    check.add_argument("bag", type=Path, metavar="BAG", help="folder or storage file of the bag")
    check.add_argument("--repair", type=Path, metavar="FOLDER", help="write what is readable into a new bag")
    check.add_argument("--storage", default="mcap", choices=tuple(STORAGES), help="of the new bag")
    check.add_argument("--json", action="store_true", help="print JSON")
    check.set_defaults(func=run_check)
    copy = commands.add_parser(
        "copy",
        help="the same flight as another bag: fewer topics, another way of storing",
        description="Write a flight into another bag, with fewer topics or stored another way.",
    )
    copy.add_argument("bag", type=Path, metavar="BAG", help="folder of the bag")
    copy.add_argument("folder", type=Path, metavar="FOLDER", help="of the new bag")
    copy.add_argument("--without", default="", metavar="A,B", help="topics to leave out, comma-separated")
    copy.add_argument("--storage", default="mcap", choices=tuple(STORAGES), help="of the new bag")
    copy.set_defaults(func=run_copy)
    compare = commands.add_parser(
        "compare",
        help="whether two bags hold the same flight, and where they differ first",
        description="Compare two flights byte by byte; exit code 1 if they differ.",
    )
    compare.add_argument("first", type=Path, metavar="BAG", help="folder of a bag")
    compare.add_argument("second", type=Path, metavar="OTHER", help="folder of another bag")
    compare.set_defaults(func=run_compare)


def run_info(arguments: argparse.Namespace) -> int:
    """Say what is in a bag.

    Raises:
        InputError: no readable bag.
    """
    bag = read_bag(arguments.bag)
    about = bag_information(bag)
    if arguments.json:
        sys.stdout.write(json.dumps(about, indent=2) + "\n")
    else:
        _print(about, Console(highlight=False))
    return EXIT_FLOWN


def run_check(arguments: argparse.Namespace) -> int:
    """Say whether a bag is whole; repair it into another folder if asked to.

    Raises:
        InputError: nothing readable, or the new folder cannot be written.
    """
    bag = read_bag(arguments.bag)
    state = bag_state(bag, arguments.bag)
    if arguments.repair is not None:
        write_again(bag, arguments.repair, arguments.storage)
    if arguments.json:
        about = asdict(state) | {"whole": state.whole, "repaired": arguments.repair and str(arguments.repair)}
        sys.stdout.write(json.dumps(about, indent=2) + "\n")
    else:
        sys.stdout.write(f"{arguments.bag}: {'whole' if state.whole else 'not whole'}\n")
        sys.stdout.writelines(f"  {line}\n" for line in _state_lines(state, sum(bag.counts.values())))
        if arguments.repair is not None:
            sys.stdout.write(f"what is readable was written to {arguments.repair}\n")
    return EXIT_FLOWN if state.whole else EXIT_NOT_WHOLE


def run_copy(arguments: argparse.Namespace) -> int:
    """Write a flight into another bag.

    Raises:
        InputError: no readable bag, no such topic, or the new folder cannot be written.
    """
    bag = read_bag(arguments.bag)
    without = tuple(name.strip() for name in arguments.without.split(",") if name.strip())
    write_again(bag, arguments.folder, arguments.storage, without)
    return EXIT_FLOWN


def _state_lines(state: BagState, held: int) -> list[str]:
    lines = [f"{held:,} messages until {state.until_ns * 1e-9:.3f} s", *state.problems]
    if state.unwritten:
        lines.append(f"{state.unwritten:,} messages had been counted but are not in the file")
    for count in state.losses:
        first = (count.first_gap_ns or 0) * 1e-9
        lost = f"{count.lost} of {count.expected} lost in {count.gaps} gaps"
        lines.append(f"{count.topic}: {lost}, the first at {first:.4f} s")
    for name, reason in state.readers.items():
        lines.append(f"read by {name}: {'yes' if not reason else f'no: {reason}'}")
    return lines


def run_compare(arguments: argparse.Namespace) -> int:
    """Say whether two flights are the same.

    Raises:
        InputError: no readable bag, or messages of another layout.
    """
    difference = first_difference(read_bag(arguments.first), read_bag(arguments.second))
    sys.stdout.write("the same flight\n" if difference is None else f"different: {difference}\n")
    return EXIT_FLOWN if difference is None else EXIT_DIFFERENT


def bag_information(bag: Bag) -> dict[str, Any]:
    """What `heli bag info` says, ready for JSON; the hash is None for a bag of other layouts."""
    stamps = [stamp for each in bag.stamps.values() for stamp in each]
    try:
        digest, problems = bag_hash(bag), list(bag.problems)
    except InputError as error:
        digest, problems = None, [*bag.problems, f"no hash: {error.key}: {error.problem}"]
    jitter = _jitter(bag)
    return {
        "bag": str(bag.folder),
        "complete": bag.complete,
        "problems": problems,
        "start_s": min(stamps, default=0) * 1e-9,
        "duration_s": (max(stamps, default=0) - min(stamps, default=0)) * 1e-9,
        "messages": len(stamps),
        "sha256": digest,
        "topics": [asdict(count) | jitter.get(count.topic, {}) for count in count_check(bag)],
        "custom_data": bag.custom_data,
    }


def _jitter(bag: Bag) -> dict[str, dict[str, float]]:
    """What the recorder noted of the time between arrivals; empty unless it flew in real time."""
    try:
        return {str(topic): dict(figures) for topic, figures in json.loads(bag.custom_data["jitter"]).items()}
    except (KeyError, ValueError, TypeError, AttributeError):
        return {}


def _print(about: dict[str, Any], console: Console) -> None:
    state = "complete" if about["complete"] else "incomplete"
    console.print(
        f"{about['bag']}: {state}, {about['duration_s']:.2f} s from {about['start_s']:.2f} s, "
        f"{about['messages']:,} messages",
        soft_wrap=True,
        markup=False,
    )
    for problem in about["problems"]:
        console.print(f"  {problem}", style="yellow", markup=False)
    console.print(f"sha256 {about['sha256'] or '-'}\n", soft_wrap=True, markup=False)
    console.print(_topic_table(about["topics"]))
    if about["custom_data"]:
        console.print()
        console.print(_remark_table(about["custom_data"]))


def _topic_table(topics: list[dict[str, Any]]) -> Table:
    table = Table("topic", "type", box=None, pad_edge=False)
    timed = any("rms_ms" in topic for topic in topics)
    titles = ("messages", "expected", "lost", "gaps", *(("jitter rms ms", "max ms") if timed else ()))
    for title in titles:
        table.add_column(title, justify="right")
    for topic in topics:
        expected = "-" if topic["expected"] is None else str(topic["expected"])
        style = "yellow" if topic["lost"] else None
        cells = [topic["messages"], expected, topic["lost"], topic["gaps"]]
        if timed:
            cells += [f"{topic[key]:.2f}" if key in topic else "-" for key in ("rms_ms", "max_ms")]
        table.add_row(escape(topic["topic"]), topic["ros_type"], *map(str, cells), style=style)
    return table


def _remark_table(custom_data: dict[str, str]) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("key", no_wrap=True)
    table.add_column("value", overflow="fold")
    for key, text in custom_data.items():
        lines = text.count("\n")
        shown = text.rstrip() if lines <= SHOWN_LINES else f"{lines} lines (see --json)"
        table.add_row(escape(key), escape(shown))
    return table
