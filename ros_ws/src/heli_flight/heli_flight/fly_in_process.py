"""A flight in this process: no ROS, as fast as the machine allows, the bytes of a lockstep flight."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

from heli_common.errors import EXIT_FLOWN, EXIT_INTERRUPTED, EXIT_SAFETY_STOP, SafetyStop
from heli_common.flight_state import FlightState
from heli_common.timing import SENSOR_PERIOD_NS
from heli_common.topics import TOPICS, data_topics
from heli_flight.components import DEFAULTS, bench_simulator, controllers, identifier, supervisor
from heli_flight.framed_bag import FramedBagWriter
from heli_flight.in_process import InProcessGraph
from heli_flight.order import FlightEnd, FlightOrder
from heli_flight.parameter_file import read_parameters
from heli_flight.progress import Progress
from heli_flight.recorder import ACKNOWLEDGE_NS, FlightRecorder

PROGRESS_NS = 500_000_000


def fly_in_process(order: FlightOrder, tell: Callable[[Progress], None]) -> FlightEnd:
    """Fly an order to its end and leave its bag.

    Args:
        order: what to fly.
        tell: called twice a simulated second.
    """
    started = perf_counter()
    values = read_parameters(order.parameters) if order.parameters else DEFAULTS
    bench = bench_simulator(order.seed, values, order.plan, order.identified)
    leader = supervisor(order.plan, values)
    bag = FramedBagWriter(order.bag, order.notes(), order.storage)
    recorded = data_topics(order.running)
    for topic in recorded:
        bag.add_topic(topic, TOPICS[topic].layout.ros_type)
    recorder = FlightRecorder(bag, recorded)

    def record(topic: str, _stamp_ns: int, data: bytes) -> None:
        if topic in recorded:
            recorder.receive(topic, data)

    flown = controllers(order.controller, values, order.later, order.motor, order.identified)
    parts = [leader, *flown]
    if order.identified:
        parts.append(identifier(order.plan, values))
    graph = InProcessGraph(bench, parts, record)
    code, reason = EXIT_FLOWN, ""
    try:
        while bench.ended_at is None:
            graph.advance()
            if bench.stamp_ns % ACKNOWLEDGE_NS == 0:
                recorder.settle()
            if bench.stamp_ns % PROGRESS_NS == 0:
                seconds = bench.stamp_ns * 1e-9
                tell(Progress(seconds, leader.state, leader.phase, len(order.plan.phases), leader.reason))
        if leader.state is FlightState.FAULT:
            code, reason = EXIT_SAFETY_STOP, leader.reason
    except (SafetyStop, ValueError, OSError) as error:
        bench.switch_off()
        code, reason = EXIT_SAFETY_STOP, str(error)
    except KeyboardInterrupt:
        code, reason = EXIT_INTERRUPTED, "interrupted"
    finally:
        try:
            recorder.close(bench.remarks() | ({"result": reason} if reason else {}))
        except OSError as error:
            code, reason = EXIT_SAFETY_STOP, str(error)
    simulated = max(bench.stamp_ns, -SENSOR_PERIOD_NS) * 1e-9
    return FlightEnd(code, reason, simulated, perf_counter() - started)
