"""How punctual the machine itself is: a bare loop of the bench's control period that computes nothing.

Run by `benchmarks/realtime.py`: `pulse.py SECONDS PRIORITY` prints the jitter's figures [ms] as JSON. The
priority is of SCHED_FIFO; 0 leaves ordinary scheduling. The cores are kept awake as in a flight.
"""

from __future__ import annotations

import json
import sys
from time import perf_counter, sleep

import numpy as np

from heli_common.nodes.scheduling import Awake, become_real_time
from heli_common.timing import CONTROL_PERIOD

QUANTILES = {"median_ms": 0.5, "p99_ms": 0.99, "p99_9_ms": 0.999, "max_ms": 1.0}


def lateness(seconds: float) -> list[float]:
    """By how much later than its deadline each period begins [s]."""
    found, begun = [], perf_counter() + CONTROL_PERIOD
    for number in range(int(seconds / CONTROL_PERIOD)):
        due = begun + number * CONTROL_PERIOD
        sleep(max(0.0, due - perf_counter()))
        found.append(perf_counter() - due)
    return found


def main() -> None:
    """Measure and print."""
    seconds, priority = float(sys.argv[1]), int(sys.argv[2])
    become_real_time(priority)
    awake = Awake()
    late = lateness(seconds)
    awake.end()
    figures = 1e3 * np.quantile(late, list(QUANTILES.values()))
    sys.stdout.write(json.dumps(dict(zip(QUANTILES, figures.tolist(), strict=True))) + "\n")


if __name__ == "__main__":
    main()
