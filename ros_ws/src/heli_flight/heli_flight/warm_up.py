"""Compiles every kernel into the cache, so that no node compiles while others wait (spec 6.5)."""

from __future__ import annotations

import shutil
import sys
from time import perf_counter

from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.warm_up import warm_up as bench_warm_up
from heli_common.files import write_atomically
from heli_common.kernel_cache import MARK, cache_folder
from heli_control.controller_file import load_controller
from heli_flight.components import bench_simulator, controllers, supervisor
from heli_flight.in_process import InProcessGraph
from heli_flight.plan import load_plan
from heli_flight.swift_flight import SwiftFlight
from heli_navigation.warm_up import warm_up as navigation_warm_up

KEPT = 8
"""Kernels of so many other states of the sources stay in the cache."""


def forget_old_kernels() -> None:
    """Remove the kernels of sources that are long gone; the newest few stay, for other checkouts."""
    others = [path for path in cache_folder().parent.iterdir() if path.is_dir() and path != cache_folder()]
    for path in sorted(others, key=lambda path: path.stat().st_mtime)[:-KEPT]:
        shutil.rmtree(path, ignore_errors=True)


def warm_up(seconds: float = 0.1) -> float:
    """Fly a little of a plan without recording; returns how long it took [s]."""
    started = perf_counter()
    parts = [supervisor(load_plan("short_hover")), *controllers(load_controller("lq"))]
    graph = InProcessGraph(bench_simulator(1), parts, lambda *_: None)
    while graph.bench.stamp_ns < seconds * 1e9:
        graph.advance()
    bench_warm_up(BenchParameters())
    navigation_warm_up()
    SwiftFlight(load_plan("campaign_hover"), 1, load_controller("lq")).fly()
    write_atomically(cache_folder() / MARK, "")
    forget_old_kernels()
    return perf_counter() - started


if __name__ == "__main__":
    sys.stdout.write(f"kernels ready after {warm_up():.1f} s in {cache_folder().name}\n")
