"""The simulated bench on the graph: lockstep waits for commands, real time is paced by the wall clock."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic, perf_counter

from heli_bench_sim.nodes.latency import Jitter, Latency
from heli_bench_sim.simulator import BenchSimulator
from heli_bench_sim.watch import WatchParameters
from heli_common.component import Message
from heli_common.errors import SafetyStop
from heli_common.nodes.connection import Connection
from heli_common.nodes.requests import Requests
from heli_common.nodes.scheduling import Awake
from heli_common.timing import COMMAND_LATENCY_NS, CONTROL_PERIOD_NS, SENSOR_PERIOD_NS, is_control_tick
from heli_common.topics import BENCH_SIM, OPTIONAL_NODES, RECORDER, SUPERVISOR, TOPICS

LOCKSTEP, REALTIME = "lockstep", "realtime"
MODES = (LOCKSTEP, REALTIME)

RECORDER_LAG_NS = 200 * SENSOR_PERIOD_NS
"""In lockstep the recorder may be this far behind the bench."""

STATUS_PERIOD_NS = 1_000_000_000
IDLE_SECONDS = 0.02
CLOSING_SECONDS = 5.0

CATCH_UP_SECONDS = SENSOR_PERIOD_NS * 1e-9
"""A bench further behind the wall clock than this does not hurry after it: its time has stood still.

It is behind by a whole sample then, half of the time in which a command must come.
"""


class BenchProgram:
    """Drives a `BenchSimulator` in lockstep or in real time until the supervisor ends the flight."""

    name = BENCH_SIM
    ends = True

    def __init__(
        self,
        simulator: BenchSimulator,
        mode: str,
        running: tuple[str, ...],
        watch: WatchParameters,
        show: Callable[[int, list[Message]], None] | None = None,
    ) -> None:
        self.simulator = simulator
        self.recorded = RECORDER in running
        self.inputs = (*simulator.inputs, "recorder_ack") if self.recorded else simulator.inputs
        self.outputs = simulator.outputs
        self.waking = tuple(topic for topic in simulator.inputs if TOPICS[topic].source != SUPERVISOR)
        self.finished = False
        self._mode = mode
        self._watch = watch
        self._show = show
        self._connection: Connection | None = None
        self._flying = False
        self._acknowledged_ns = -SENSOR_PERIOD_NS
        self._progress_at = 0.0
        self._clock_zero = 0.0
        self._pauses: list[float] = []
        self._left_regime = 0
        self._closing_since = 0.0
        self._latency, self._jitter = Latency(simulator.inputs), Jitter()
        self._awake: Awake | None = None
        self._requests = Requests()
        self._unpack = {topic: TOPICS[topic].layout.unpack for topic in self.inputs}

    def start(self, connection: Connection) -> None:
        """The graph is wired; the first sample follows when every node of it has said that it is ready."""
        self._connection = connection
        if self._mode == REALTIME:
            self._awake = Awake()
        self._requests.tell(connection, 0)
        self._progress_at = monotonic()

    def on_message(self, topic: str, data: bytes) -> None:
        """Take a command or the recorder's acknowledgement; in lockstep go on as far as that allows."""
        stamp_ns, values = self._unpack[topic](data)
        if topic == "recorder_ack":
            self._acknowledged_ns = max(self._acknowledged_ns, stamp_ns)
        else:
            if self._mode == REALTIME:
                self._latency.arrived(topic, stamp_ns)
            self.simulator.receive(topic, stamp_ns, values)
        if self._mode == LOCKSTEP and self._flying:
            self._advance_lockstep()

    def request_fault(self, text: str) -> None:
        """Let something go wrong from the next control tick on.

        Raises:
            InputError: see `BenchSimulator.request_fault`.
        """
        acts_ns = self.simulator.request_fault(text)
        self._requests.add(text)
        self._requests.tell(self._connection, acts_ns)

    def turn(self) -> float:
        """Start, pace or watch the flight; returns how long the executor may wait for messages [s]."""
        assert self._connection is not None
        if not self._flying:
            return self._wait_for_nodes(self._connection)
        if self.simulator.ended_at is not None:
            return self._end(self._connection)
        if self._mode == REALTIME:
            return self._advance_real_time()
        if monotonic() - self._progress_at > self._watch.stall:
            raise SafetyStop(f"stalled for {self._watch.stall:.0f} s: {self._absent()} missing")
        return IDLE_SECONDS

    def close(self) -> None:
        """Whatever ended the flight, the motor is off and the cores may sleep."""
        self.simulator.switch_off()
        if self._awake is not None:
            self._awake.end()

    def _wait_for_nodes(self, connection: Connection) -> float:
        if absent := connection.absent():
            if monotonic() - self._progress_at > self._watch.stall:
                raise TimeoutError(f"not ready after {self._watch.stall:.0f} s: {', '.join(absent)}")
            return IDLE_SECONDS
        self._flying = True
        self._progress_at = monotonic()
        self._clock_zero = perf_counter()
        if self._mode == LOCKSTEP:
            self._advance_lockstep()
            return IDLE_SECONDS
        return self._advance_real_time()

    def _advance_lockstep(self) -> None:
        simulator = self.simulator
        before = simulator.stamp_ns
        while simulator.ended_at is None and not simulator.missing() and not self._recorder_behind():
            self._publish(simulator.tick())
        if simulator.stamp_ns != before:
            self._progress_at = monotonic()

    def _recorder_behind(self) -> bool:
        return self.recorded and self.simulator.stamp_ns - self._acknowledged_ns > RECORDER_LAG_NS

    def _absent(self) -> str:
        absent = [f"{topic} from {TOPICS[topic].source}" for topic in self.simulator.missing()]
        if self._recorder_behind():
            absent.append(f"acknowledgement from {RECORDER}")
        return " and ".join(absent) or "nothing"

    def _advance_real_time(self) -> float:
        """Publish a sample if it is due and return how long until the next, which may be overdue, too.

        Commands that are there are taken in between.

        A bench that was itself kept from running must not make up for it in one rush, in which no command
        can arrive: it would take its own absence for the others' silence. It moves its clock instead, and
        the summary says how often and how long.
        """
        wait = self._wait
        if wait > 0.0:
            return wait
        simulator = self.simulator
        if is_control_tick(simulator.stamp_ns + SENSOR_PERIOD_NS):
            self._jitter.began(-wait)
        if -wait > CATCH_UP_SECONDS:
            self._pauses.append(-wait)
            self._clock_zero -= wait
        self._refuse_silence()
        self._publish(simulator.tick())
        return max(0.0, self._wait)

    @property
    def _wait(self) -> float:
        """Until the next sample is due [s]; negative if it is late."""
        return self._clock_zero + (self.simulator.stamp_ns + SENSOR_PERIOD_NS) * 1e-9 - perf_counter()

    def _refuse_silence(self) -> None:
        for topic, newest in self.simulator.newest.items():
            if TOPICS[topic].source in OPTIONAL_NODES:
                continue  # the flight goes on without it
            silence = self.simulator.stamp_ns - COMMAND_LATENCY_NS - CONTROL_PERIOD_NS - newest
            if silence > self._watch.silence * 1e9:
                source = TOPICS[topic].source
                at = self.simulator.stamp_ns * 1e-9
                raise SafetyStop(
                    f"{topic} from {source} silent for {self._watch.silence:.1f} s at {at:.2f} s"
                )

    def _publish(self, messages: list[Message]) -> None:
        assert self._connection is not None
        self._connection.publish(messages)
        if self._show is not None:
            self._show(self.simulator.stamp_ns, messages)
        if self._mode == REALTIME and is_control_tick(self.simulator.stamp_ns):
            self._latency.published(self.simulator.stamp_ns)
        left = len(self.simulator.left_regime)
        if self.simulator.stamp_ns % STATUS_PERIOD_NS == 0 or left > self._left_regime:
            self._report(self._connection, "flying")
        self._left_regime = left

    def _report(self, connection: Connection, text: str) -> None:
        late, left = self.simulator.late, self.simulator.left_regime
        values = self.simulator.remarks() | {"mode": self._mode}
        if self._mode == REALTIME:
            awake = self._awake is not None and self._awake.held
            values |= {"cores_kept_awake": "yes" if awake else "no"}
            values |= {"pauses": str(len(self._pauses)), "paused_s": f"{sum(self._pauses):.3f}"}
        values |= self._latency.figures() | self._jitter.figures() if text == "ended" else {}
        level = "warn" if any(late.values()) or self._pauses or left else "ok"
        connection.diagnose(self.simulator.stamp_ns, level, text, values)

    def _end(self, connection: Connection) -> float:
        """Tell the last figures and leave when the recorder has everything up to the end."""
        now = monotonic()
        if not self._closing_since:
            self._closing_since = now
            self._report(connection, "ended")
        complete = self._acknowledged_ns >= (self.simulator.ended_at or 0)
        self.finished = not self.recorded or complete or now - self._closing_since > CLOSING_SECONDS
        return IDLE_SECONDS
