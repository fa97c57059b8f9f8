"""Loads the compiled kernels before time runs: a bench of its own is homed a little, then flies a little."""

from __future__ import annotations

import numpy as np

from heli_bench_sim.bench import Bench
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.faults import FaultSchedule, ImuDropout
from heli_bench_sim.rig_picture import draw
from heli_bench_sim.simulator import BenchSimulator
from heli_bench_sim.states import INPUT_SIZE, STATE_SIZE, State
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.timing import CONTROL_PERIOD_NS, SENSOR_PERIOD_NS
from heli_common.topics import TOPICS

WIND = 1.0
"""Asked of the wind generator [m/s]."""


def warm_up(parameters: BenchParameters) -> None:
    """Compile or load everything that a bench calls in flight, as do those who look at it.

    Args:
        parameters: of the bench that will fly.
    """
    fault = ImuDropout(start_ns=CONTROL_PERIOD_NS, end_ns=2 * CONTROL_PERIOD_NS)
    simulator = BenchSimulator(Bench(parameters, faults=FaultSchedule((fault,))))
    _go_on(simulator, FlightState.HOMING)
    state = np.zeros(STATE_SIZE)
    state[State.Omega] = parameters.helicopter.rotor_speed
    bench = simulator.bench
    bench.place(state, np.zeros(INPUT_SIZE))
    _go_on(simulator, FlightState.FLYING)
    _ = bench.violations
    draw(bench.position, bench.attitude, bench.wind, parameters.geometry, parameters.helicopter)


def _go_on(simulator: BenchSimulator, state: FlightState) -> None:
    """Go on by two control periods with commands of zero."""
    for _ in range(2 * CONTROL_PERIOD_NS // SENSOR_PERIOD_NS):
        simulator.tick()
        stamp_ns = simulator.stamp_ns
        for topic in ("servo_command", "motor_command"):
            simulator.receive(topic, stamp_ns, (0.0,) * len(TOPICS[topic].layout.fields))
        simulator.receive("flight_state", stamp_ns, flight_state_values(state, 0.0, WIND))
