"""What one message costs in each component, and what the codec and the bag cost: a table, no verdict.

Run: python benchmarks/components.py [--json]. Flies short_hover in process with a stop watch at every call.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from rich.console import Console
from rich.table import Table

from heli_common.topics import DATA_TOPICS, TOPICS
from heli_control.controller_file import load_controller
from heli_flight.bag import BagWriter
from heli_flight.bag_reader import read_bag
from heli_flight.components import bench_simulator, controllers, supervisor
from heli_flight.flight_hash import bag_hash
from heli_flight.in_process import InProcessGraph
from heli_flight.plan import load_plan


class Watch:
    """Times every call of a function; the figures are microseconds."""

    def __init__(self, function):
        self.function, self.seconds = function, []

    def __call__(self, *arguments):
        """Call and time."""
        begin = perf_counter()
        result = self.function(*arguments)
        self.seconds.append(perf_counter() - begin)
        return result

    def figures(self):
        """Calls, median and 99 % quantile."""
        micro = 1e6 * np.array(self.seconds)
        return {
            "calls": len(micro),
            "median_us": float(np.median(micro)),
            "p99_us": float(np.quantile(micro, 0.99)),
        }


def measure(folder: Path) -> dict[str, dict[str, float]]:
    """Median and 99 % quantile per call; whole-bag figures in microseconds per message."""
    bench, plan = bench_simulator(1), load_plan("short_hover")
    parts = [supervisor(plan), *controllers(load_controller("lq"))]
    watches = {}
    for part in parts:
        watches[f"{part.name}.receive"] = part.receive = Watch(part.receive)
    watches["bench_sim.tick"] = bench.tick = Watch(bench.tick)
    bag = BagWriter(folder / "bag")
    for topic in DATA_TOPICS:
        bag.add_topic(topic, TOPICS[topic].layout.ros_type)
    record = watches["bag.write"] = Watch(bag.write)
    graph = InProcessGraph(bench, parts, lambda *sent: record(*sent) if sent[0] in DATA_TOPICS else None)
    while bench.ended_at is None:
        graph.advance()
    bag.close()
    rows = {name: watch.figures() for name, watch in watches.items()}
    values = np.arange(85.0)
    pack, unpack = Watch(TOPICS["odometry"].layout.pack), Watch(TOPICS["odometry"].layout.unpack)
    for stamp in range(5_000):
        unpack(pack(stamp, values))
    rows |= {"odometry pack": pack.figures(), "odometry unpack": unpack.figures()}
    read, digest = Watch(read_bag), Watch(bag_hash)
    for _ in range(3):
        digest(read(folder / "bag"))
    messages = rows["bag.write"]["calls"]
    for name, watch in (("bag read, per message", read), ("flight hash, per message", digest)):
        rows[name] = {key: value / messages for key, value in watch.figures().items()} | {"calls": messages}
    return rows


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = measure(Path(folder))
    if options.json:
        sys.stdout.write(json.dumps(rows, indent=2) + "\n")
        return
    table = Table("what", "calls", "median us", "99 % us")
    for name, row in rows.items():
        table.add_row(name, f"{row['calls']:.0f}", f"{row['median_us']:.2f}", f"{row['p99_us']:.2f}")
    Console().print(table)


if __name__ == "__main__":
    main()
