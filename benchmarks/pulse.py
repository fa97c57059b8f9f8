"""How punctual the machine itself is: a bare loop of the bench's control period that computes nothing.

Run by `benchmarks/realtime.py`: `pulse.py SECONDS PRIORITY` prints the jitter's figures [ms] as JSON. The
priority is of SCHED_FIFO; 0 leaves ordinary scheduling. The cores are kept awake as in a flight.
"""

from __future__ import annotations

import json
import sys
from time import perf_counter, sleep

from heli_bench_sim.nodes.latency import Jitter
from heli_common.nodes.scheduling import Awake, become_real_time
from heli_common.timing import CONTROL_PERIOD
from heli_flight.punctuality import PERIOD, punctuality


def beat(seconds: float) -> Jitter:
    """By how much later than its deadline each period begins."""
    jitter, begun = Jitter(), perf_counter() + CONTROL_PERIOD
    for number in range(int(seconds / CONTROL_PERIOD)):
        due = begun + number * CONTROL_PERIOD
        sleep(max(0.0, due - perf_counter()))
        jitter.began(perf_counter() - due)
    return jitter


def main() -> None:
    """Measure and print."""
    seconds, priority = float(sys.argv[1]), int(sys.argv[2])
    become_real_time(priority)
    awake = Awake()
    jitter = beat(seconds)
    awake.end()
    sys.stdout.write(json.dumps(punctuality(jitter.figures())[PERIOD]) + "\n")


if __name__ == "__main__":
    main()
