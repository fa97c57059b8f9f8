"""Committed motion of the bench: it may change only with a commit that says so.

Rewrite with `python tests/test_golden.py` and look at the difference. Open loop and without pulse rounding,
so that processors differ by rounding alone (spec 6.5): compared to 1e-7 over 5 s.
"""

from pathlib import Path

import numpy as np

from heli_bench_sim.bench import Bench
from heli_bench_sim.parameters import thesis
from heli_bench_sim.states import STATE_NAMES, Input
from heli_bench_sim.trim import trim

GOLDEN = Path(__file__).parent / "golden" / "doublet.csv"
SAMPLES, EVERY = 2_000, 20
PULSES = {
    200: [(Input.B_1s, 0.01)],
    300: [(Input.B_1s, -0.01)],
    400: [(Input.B_1s, 0.0)],
    600: [(Input.A_1s, 0.01)],
    700: [(Input.A_1s, -0.01)],
    800: [(Input.A_1s, 0.0)],
}
"""Sample at which the blade angle leaves trim by so much [rad]."""


def doublet():
    """Every 50 ms of 5 s: the 18 states from trim, a doublet in B_1s, then one in A_1s."""
    bench, point = Bench(), trim(thesis())
    bench.place(point.state, point.inputs)
    rows = [bench.state]
    for sample in range(SAMPLES):
        for channel, size in PULSES.get(sample, ()):
            inputs = point.inputs
            inputs[channel] += size
            bench.place(bench.state, inputs)  # servos are there at once, pulses are not rounded
        bench.advance()
        if (sample + 1) % EVERY == 0:
            rows.append(bench.state)
    return np.array(rows)


def test_motion_is_the_committed_one():
    golden = np.loadtxt(GOLDEN, delimiter=",", skiprows=1)
    np.testing.assert_allclose(doublet(), golden, rtol=1e-7, atol=1e-7)


def test_the_golden_flight_moves():
    golden = np.loadtxt(GOLDEN, delimiter=",", skiprows=1)
    assert GOLDEN.read_text().splitlines()[0] == ",".join(STATE_NAMES)
    assert np.ptp(golden[:, STATE_NAMES.index("q")]) > 0.05
    assert np.ptp(golden[:, STATE_NAMES.index("p")]) > 0.05
    assert np.abs(golden[:, :3]).max() < 0.4


if __name__ == "__main__":
    np.savetxt(GOLDEN, doublet(), delimiter=",", header=",".join(STATE_NAMES), comments="", fmt="%.17g")
