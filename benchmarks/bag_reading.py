"""A long bag into numpy: our reader beside rosbags' own decoder of the same messages, three ways of storing.

Run: python benchmarks/bag_reading.py [--minutes 10] [--bag FOLDER]. Flies a hover in process, stores it as
MCAP with and without zstd and as sqlite3, and reads each twice: `FlightRecord.load` gives every number of
every topic as arrays, sizes and constant parts verified; rosbags' `Reader` gives the messages one after the
other, which `deserialize_cdr` decodes and nobody keeps. Seconds are processor time, both run on one core.
Every number of every message of all three is compared; of topics without arrays (`tf`), every byte.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from heli_common.topics import TOPICS
from heli_control.controller_file import load_controller
from heli_flight.bag_check import write_again
from heli_flight.flight_record import FlightRecord
from heli_flight.fly_in_process import fly_in_process
from heli_flight.mode import Mode
from heli_flight.order import FlightOrder
from heli_flight.plan import parse_plan

STORE = get_typestore(Stores.ROS2_JAZZY)
STORAGES = {"mcap": "MCAP, zstd", "mcap_uncompressed": "MCAP", "sqlite3": "sqlite3"}
PLAN = """
name: long
about: A hover as long as asked for.
seed: 1
controller: lq
phases:
  - home: {{duration: 8.0}}
  - run_up: {{duration: 6.0}}
  - take_off: {{height: 0.0, speed: 0.15}}
  - hover: {{duration: {0:.1f}}}
  - land: {{speed: 0.12}}
  - run_down: {{duration: 3.0}}
"""
GROUND_SECONDS = 25.0


def fly(folder: Path, minutes: float) -> FlightRecord:
    """Fly in process."""
    plan = parse_plan(PLAN.format(60.0 * minutes - GROUND_SECONDS), "benchmark")
    controller = load_controller(plan.controller)
    order = FlightOrder(plan, "", Mode.INPROCESS, 1, controller, "lq", folder, with_identification=True)
    fly_in_process(order, lambda _: None)
    return FlightRecord.load(folder)


def flat(message: Any) -> Iterator[float]:
    """The numbers of a decoded message in the order of its definition, stamp, names and lengths left out."""
    for name in message.__dataclass_fields__:
        value = getattr(message, name)
        if isinstance(value, float):
            yield value
        elif isinstance(value, np.ndarray):
            yield from value
        elif hasattr(value, "__dataclass_fields__") and name != "header":
            yield from flat(value)


def rosbags_seconds(folder: Path) -> float:
    """Decode every message and keep none."""
    begin = process_time()
    with Reader(folder) as reader:
        for connection, _, data in reader.messages():
            STORE.deserialize_cdr(data, connection.msgtype)
    return process_time() - begin


def differing(folder: Path, flight: FlightRecord) -> int:
    """Messages of which rosbags decodes another stamp or other numbers than stand in our arrays.

    A topic without arrays is compared as it is serialized.
    """
    place = dict.fromkeys(TOPICS | flight.bag.types, 0)
    wrong = 0
    with Reader(folder) as reader:
        for connection, _, data in reader.messages():
            topic = connection.topic.lstrip("/")
            row = place[topic]
            place[topic] += 1
            if topic not in flight.series:
                wrong += flight.bag.messages[topic][row] != data
                continue
            message, series = STORE.deserialize_cdr(data, connection.msgtype), flight.series[topic]
            stamp = message.header.stamp
            same = series.stamps[row] == stamp.sec * 1_000_000_000 + stamp.nanosec
            wrong += not (same and np.array_equal(series.values[row], np.fromiter(flat(message), float)))
    return wrong + sum(count != place[topic] for topic, count in flight.bag.counts.items())


def same_arrays(one: FlightRecord, other: FlightRecord) -> bool:
    """Whether two flights have the same numbers, and the same bytes of topics without arrays."""
    return one.bag.messages == other.bag.messages and all(
        np.array_equal(one.series[topic].stamps, other.series[topic].stamps)
        and np.array_equal(one.series[topic].values, other.series[topic].values)
        for topic in TOPICS
    )


def measure(folder: Path, minutes: float, flown: Path | None) -> list[dict[str, Any]]:
    """One row per way of storing."""
    flight = FlightRecord.load(flown) if flown else fly(folder / "mcap", minutes)
    rows = []
    for storage, words in STORAGES.items():
        bag = folder / storage
        if not bag.exists():
            write_again(flight.bag, bag, storage)
        FlightRecord.load(bag)  # both find the file in memory
        begin = process_time()
        read = FlightRecord.load(bag)
        ours = process_time() - begin
        theirs = rosbags_seconds(bag)
        wrong = differing(bag, read) if storage == "mcap" else int(not same_arrays(read, flight))
        rows.append(
            {
                "storage": words,
                "megabytes": sum(path.stat().st_size for path in bag.iterdir()) / 1e6,
                "messages": sum(read.bag.counts.values()),
                "ours_s": ours,
                "rosbags_s": theirs,
                "ratio": theirs / ours,
                "differing": wrong,
            }
        )
    return rows


def main() -> int:
    """Measure and print; exit code 1 if a number differs or a bag is not read 10 times as fast."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0, help="length of the flight")
    parser.add_argument("--bag", type=Path, help="take this flight, MCAP with zstd, instead of flying")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = measure(Path(folder), options.minutes, options.bag)
        table = Table("stored as", "MB", "messages", "ours s", "rosbags s", "ratio", "messages that differ")
        for row in rows:
            numbers = (f"{row['megabytes']:.0f}", f"{row['messages']:,}", f"{row['ours_s']:.2f}")
            ratio = (f"{row['rosbags_s']:.1f}", f"{row['ratio']:.1f}", str(row["differing"]))
            table.add_row(row["storage"], *numbers, *ratio)
        Console().print(table)
    return int(any(row["differing"] or row["ratio"] < 10.0 for row in rows))


if __name__ == "__main__":
    sys.exit(main())
