"""How the bench keeps its time in real time, by a clock of the test's own."""

import pytest

from heli_bench_sim.bench import Bench
from heli_bench_sim.nodes import bench_program
from heli_bench_sim.simulator import BenchSimulator
from heli_bench_sim.watch import WatchParameters
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.topics import TOPICS

MS = 1e-3


class Connection:
    """Everybody is there; keeps what the bench says."""

    def __init__(self):
        self.stamps, self.said = [], {}

    def absent(self):
        return []

    def publish(self, messages):
        self.stamps += [message.stamp_ns for message in messages if message.topic == "imu"]

    def diagnose(self, _stamp_ns, _level, _text, values):
        self.said = values


class PacedBench:
    """A bench whose wall clock only goes on when it is told."""

    def __init__(self, monkeypatch):
        self.now = 100.0
        monkeypatch.setattr(bench_program, "perf_counter", lambda: self.now)
        self.connection = Connection()
        self._program = bench_program.BenchProgram(
            BenchSimulator(Bench(seed=1)), bench_program.REALTIME, ("bench_sim",), WatchParameters()
        )
        self._program.start(self.connection)
        self.wait = self._program.turn()

    def after(self, seconds):
        """Its next turn comes so much later; how long it would wait then."""
        self.now += seconds
        self.wait = self._program.turn()
        return self.wait

    def end(self):
        """What it says of the flight when that has ended."""
        stopped = TOPICS["flight_state"].layout.pack(0, flight_state_values(FlightState.STOPPED, 0.0, 0.0))
        self._program.on_message("flight_state", stopped)
        self._program.turn()
        self._program.close()
        return self.connection.said


@pytest.fixture
def bench(monkeypatch):
    return PacedBench(monkeypatch)


def test_a_sample_comes_every_2_5_ms(bench):
    for _ in range(8):
        assert bench.wait == pytest.approx(2.5 * MS)
        bench.after(bench.wait)
    assert bench.connection.stamps == [2_500_000 * number for number in range(9)]
    assert bench.after(1.0 * MS) == pytest.approx(1.5 * MS), "nothing is due"
    assert len(bench.connection.stamps) == 9
    assert bench.end()["pauses"] == "0"


def test_a_bench_that_is_a_little_late_catches_up(bench):
    assert bench.after(2.5 * MS + 2.0 * MS) == pytest.approx(0.5 * MS)
    assert bench.after(0.5 * MS) == pytest.approx(2.5 * MS)
    assert bench.end()["pauses"] == "0"


def test_a_bench_that_is_late_by_more_than_a_sample_moves_its_clock(bench):
    """Hurrying after it would leave the others no time to answer."""
    assert bench.after(2.5 * MS + 4.0 * MS) == pytest.approx(2.5 * MS)
    for _ in range(3):
        bench.after(2.5 * MS)
    said = bench.end()
    assert (said["pauses"], said["paused_s"]) == ("1", "0.004")


def test_how_late_its_periods_begin_is_told(bench):
    for _ in range(8):  # two control periods, the second of which begins 1 ms late
        bench.after(bench.wait + (1.0 * MS if len(bench.connection.stamps) == 4 else 0.0))
    assert bench.end()["period_jitter_ms"].endswith("max 1.00")
