"""The bench as a component: commands on the time grid, link, fan, faults on request, the model's regime."""

import dataclasses
import math

import pytest

from heli_bench_sim.bench import Bench
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.link import WIRELESS, LinkParameters
from heli_bench_sim.parameters import thesis
from heli_bench_sim.simulator import BenchSimulator
from heli_bench_sim.states import State
from heli_bench_sim.trim import trim
from heli_common.component import Message
from heli_common.errors import InputError
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.timing import CONTROL_PERIOD_NS, SENSOR_PERIOD_NS, is_control_tick
from heli_common.topics import BENCH_CONDITION, TOPICS
from heli_common.vehicle_state import imu_from_values, swap_earth

HOVER = trim(thesis())
LEVEL = (HOVER.B_1s, HOVER.A_1s, HOVER.theta_0, HOVER.theta_t)


def fly(
    simulator: BenchSimulator, ticks: int, servo: tuple[float, ...] = LEVEL, fan: float = 0.0
) -> list[Message]:
    """Go on, answering every control tick with the same commands."""
    sent = []
    for _ in range(ticks):
        messages = simulator.tick()
        sent += messages
        stamp = simulator.stamp_ns
        if is_control_tick(stamp):
            simulator.receive("servo_command", stamp, (*servo, *(0.0,) * 8))
            simulator.receive("motor_command", stamp, (0.0, 0.0, HOVER.U_mot))
            simulator.receive("flight_state", stamp, flight_state_values(FlightState.FLYING, 163.0, fan))
    return sent


def hovering(**settings: object) -> BenchSimulator:
    bench = Bench(BenchParameters(**settings))  # type: ignore[arg-type]
    bench.place(HOVER.state, HOVER.inputs)
    return BenchSimulator(bench)


def condition(messages: list[Message], name: str) -> list[tuple[int, float]]:
    index = BENCH_CONDITION.index(name)
    return [(m.stamp_ns, float(m.values[index])) for m in messages if m.topic == "bench_condition"]


def test_every_output_is_sent_with_its_rate_and_length() -> None:
    simulator = hovering()
    messages = fly(simulator, 41)
    for topic in simulator.outputs:
        stamps = [m.stamp_ns for m in messages if m.topic == topic]
        assert stamps == list(range(0, 100_000_001, TOPICS[topic].period_ns)), topic
    for message in messages:
        assert len(message.values) == len(TOPICS[message.topic].layout.fields)


@pytest.mark.parametrize(("link", "delay_ms"), [(LinkParameters(), 0), (WIRELESS, 100)])
def test_dead_time_of_the_link_is_that_of_its_parameter(link: LinkParameters, delay_ms: int) -> None:
    """A command stamped 0 latches in the frame at 5 ms, through the wireless module in the one at 105 ms."""
    simulator = hovering(link=link)
    level = simulator.bench.command
    moved = (HOVER.B_1s + 0.05, *LEVEL[1:])
    latched = None
    for _ in range(60):
        fly(simulator, 1, moved)
        if latched is None and (simulator.bench.command[:4] != level[:4]).any():
            latched = simulator.stamp_ns - SENSOR_PERIOD_NS
    assert latched == (5 + delay_ms) * 1_000_000


def test_a_fault_of_the_link_adds_to_its_dead_time() -> None:
    simulator = hovering()
    simulator.request_fault("link_delay delay_s=0.04")
    level = simulator.bench.command
    fly(simulator, 1 + 45 * 1_000_000 // SENSOR_PERIOD_NS, (HOVER.B_1s + 0.05, *LEVEL[1:]))
    assert (simulator.bench.command[:4] == level[:4]).all()
    fly(simulator, 1, (HOVER.B_1s + 0.05, *LEVEL[1:]))
    assert (simulator.bench.command[:4] != level[:4]).any()


def test_the_fan_follows_the_flight_state_and_the_wind_is_told() -> None:
    simulator = hovering()
    messages = fly(simulator, 801, fan=4.0)
    speeds = [speed for _, speed in condition(messages, "fan")]
    assert speeds[0] == 0.0
    # 400 samples a second; the command of stamp 0 acts from 5 ms on, with a lag of 1.5 s
    assert speeds[-1] == pytest.approx(4.0 * (1.0 - math.exp(-1.995 / 1.5)), rel=1e-9)
    winds = [m.values for m in messages if m.topic == "wind"]
    assert swap_earth((winds[-1][0], winds[-1][1], winds[-1][2])) == simulator.bench.wind
    assert winds[-1][1] < -1.0


def test_a_fault_on_request_begins_with_the_next_control_tick_and_is_visible() -> None:
    simulator = hovering()
    fly(simulator, 6)
    assert simulator.stamp_ns == 12_500_000
    simulator.request_fault("imu_dropout for_s=0.02")
    messages = fly(simulator, 20)
    assert [stamp for stamp, value in condition(messages, "imu_dropout") if value] == [20_000_000, 30_000_000]
    valid = [(m.stamp_ns, imu_from_values(m.values)[2]) for m in messages if m.topic == "imu"]
    assert [stamp for stamp, sound in valid if not sound] == list(range(20_000_000, 40_000_000, 2_500_000))
    with pytest.raises(InputError, match="encoder_stuck"):
        simulator.request_fault("coffee_spilled")


def test_what_leaves_the_regime_of_the_model_is_remembered_with_time_value_and_bound() -> None:
    bench = Bench(BenchParameters(helicopter=dataclasses.replace(thesis(), fade_fraction=0.9)))
    state = HOVER.state
    state[State.Omega] *= 0.89
    bench.place(state, HOVER.inputs)
    simulator = BenchSimulator(bench)
    assert simulator.remarks() == {f"late_{topic}": "0" for topic in simulator.inputs}
    fly(simulator, 1)
    assert simulator.remarks()["regime_underspeed"] == (
        "underspeed: rotor speed [rad/s] 145 is below 147, first at 0.00 s"
    )


def test_standing_with_a_slow_rotor_is_no_violation() -> None:
    simulator = BenchSimulator(Bench())
    fly(simulator, 2 * CONTROL_PERIOD_NS // SENSOR_PERIOD_NS, (0.0, 0.0, 0.0, 0.1))
    assert simulator.left_regime == {}


def test_two_samples_at_once_are_the_same_as_two_ticks() -> None:
    """Motion, readings, late commands and regime; commands act where they would."""
    one, two = hovering(), hovering()
    for simulator in (one, two):
        simulator.tick()
    for period in range(30):
        servo = (LEVEL[0] + 0.001 * period, *LEVEL[1:])
        for simulator in (one, two):
            stamp = simulator.stamp_ns
            simulator.receive("servo_command", stamp, servo)
            simulator.receive("motor_command", stamp, (0.0, 0.0, HOVER.U_mot))
            simulator.receive("flight_state", stamp, flight_state_values(FlightState.FLYING, 163.0, 1.0))
        rows = []
        for _ in range(4):
            one.tick()
            rows.append(one.bench.reading)
        readings = [*two.run(2), *two.run(2)]
        assert [row.tolist() for row in rows] == [row.tolist() for row in readings]
        assert one.stamp_ns == two.stamp_ns and one.bench.memory.tolist() == two.bench.memory.tolist()
    assert one.remarks() == two.remarks()


def test_the_first_sample_is_no_run() -> None:
    with pytest.raises(ValueError, match=r"taken by tick\(\)"):
        hovering().run(2)
