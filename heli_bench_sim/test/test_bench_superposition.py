"""Excitation on the bench: added to the servo command, saturated and mixed with it, gone when it is lost."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heli_bench_sim.bench import Bench
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.link import WIRELESS, LinkParameters
from heli_bench_sim.parameters import thesis
from heli_bench_sim.simulator import BenchSimulator
from heli_bench_sim.superposition import STALE_NS, Superposition
from heli_bench_sim.trim import trim
from heli_common.errors import SafetyStop
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.timing import CONTROL_PERIOD_NS, is_control_tick

HOVER = trim(thesis())
LEVEL = (HOVER.B_1s, HOVER.A_1s, HOVER.theta_0, HOVER.theta_t)
QUIET = (0.0,) * 12


def test_one_frame_by_hand() -> None:
    sums = Superposition(excited=True)
    sums.send_command(0, (1.0, 2.0, 3.0, 4.0))
    sums.send_excitation(0, (0.1, 0.2, 0.0, -0.5))
    assert sums.take(0, 0) == pytest.approx((1.1, 2.2, 3.0, 3.5))


def test_without_identification_frames_pass_untouched() -> None:
    sums = Superposition()
    sums.send_command(0, (1.0, 2.0, 3.0, 4.0))
    assert sums.take(0, 0) == (1.0, 2.0, 3.0, 4.0)
    assert sums.take(CONTROL_PERIOD_NS, 0) is None


def test_an_excitation_that_stays_away_counts_as_zero() -> None:
    sums = Superposition(excited=True)
    sums.send_excitation(0, (1.0, 0.0, 0.0, 0.0))
    for stamp in range(0, 200_000_000, CONTROL_PERIOD_NS):
        sums.send_command(stamp, (0.0,) * 4)
        expected = 1.0 if stamp <= STALE_NS else 0.0
        assert sums.take(stamp, 0) == (expected, 0.0, 0.0, 0.0)


@given(st.lists(st.floats(-0.1, 0.1), min_size=8, max_size=8), st.integers(0, 3))
def test_command_and_excitation_of_one_stamp_go_through_the_link_together(
    numbers: list[float], delay: int
) -> None:
    sums, dead_time = Superposition(excited=True), delay * CONTROL_PERIOD_NS
    for stamp in range(0, 100_000_000, CONTROL_PERIOD_NS):
        scale = stamp / CONTROL_PERIOD_NS
        sums.send_command(stamp, [scale * x for x in numbers[:4]])
        sums.send_excitation(stamp, [scale * x for x in numbers[4:]])
        taken = sums.take(stamp, dead_time)
        if scale >= delay:
            assert taken is not None
            sent = scale - delay
            assert taken == tuple(sent * a + sent * b for a, b in zip(numbers[:4], numbers[4:], strict=True))


def fly(
    simulator: BenchSimulator,
    ticks: int,
    excitation: tuple[float, ...] | None,
    servo: tuple[float, ...] = LEVEL,
    volts: float = 0.0,
) -> list[tuple[float, ...]]:
    """Go on and answer; gives the values of `actuator_state`."""
    seen = []
    for _ in range(ticks):
        for message in simulator.tick():
            if message.topic == "actuator_state":
                seen.append(tuple(map(float, message.values)))
        stamp = simulator.stamp_ns
        if is_control_tick(stamp):
            simulator.receive("servo_command", stamp, (*servo, *(0.0,) * 8))
            simulator.receive("motor_command", stamp, (0.0, 0.0, HOVER.U_mot))
            simulator.receive("flight_state", stamp, flight_state_values(FlightState.FLYING, 163.0))
            if excitation is not None:
                simulator.receive("excitation", stamp, (*excitation, *(0.0,) * 8))
                simulator.receive("motor_excitation", stamp, (0.0, 0.0, volts))
    return seen


def hovering(excited: bool = True, link: LinkParameters | None = None) -> BenchSimulator:
    bench = Bench(BenchParameters(link=link or LinkParameters()))
    bench.place(HOVER.state, HOVER.inputs)
    return BenchSimulator(bench, excited)


@pytest.mark.parametrize("link", [LinkParameters(), WIRELESS])
def test_the_blades_take_the_sum_and_actuator_state_tells_it(link: LinkParameters) -> None:
    excitation = (0.02, -0.01, 0.015, -0.03)
    together, alone = hovering(link=link), hovering(excited=False, link=link)
    summed = tuple(a + b for a, b in zip(LEVEL, excitation, strict=True))
    seen = fly(together, 161, excitation)
    assert seen == fly(alone, 161, None, summed)
    assert seen[-1][:4] == pytest.approx(summed, abs=2e-4)
    assert seen[-1][10] == 0.0


def test_zeros_change_nothing() -> None:
    assert fly(hovering(), 81, (0.0,) * 4) == fly(hovering(excited=False), 81, None)


def test_the_sum_is_saturated_like_any_command() -> None:
    pushed = (math.radians(60.0), 0.0, 0.0, 0.0)
    seen = fly(hovering(), 41, pushed)
    assert seen[-1][10] == 1.0
    assert seen[-1][0] < math.radians(15.0)


def test_lockstep_waits_for_it_and_real_time_counts_it_late() -> None:
    simulator = hovering()
    fly(simulator, 3, None)
    assert simulator.stamp_ns == 5_000_000
    assert simulator.missing() == ("excitation", "motor_excitation")
    simulator.tick()
    assert simulator.late == {topic: int("excitation" in topic) for topic in simulator.inputs}
    assert hovering(excited=False).inputs == ("servo_command", "motor_command", "flight_state")


def test_an_excitation_that_is_no_number_stops_the_bench() -> None:
    with pytest.raises(SafetyStop, match=r"excitation: position.B_1s is nan"):
        hovering().receive("excitation", 0, (math.nan, *QUIET[1:]))


def test_the_control_voltage_takes_its_excitation_until_it_is_lost() -> None:
    simulator = hovering()
    fly(simulator, 5, (0.0,) * 4, volts=-0.25)
    assert simulator.bench.command[4] == HOVER.U_mot - 0.25
    fly(simulator, 4 * STALE_NS // CONTROL_PERIOD_NS, None)
    assert simulator.bench.command[4] == HOVER.U_mot - 0.25
    fly(simulator, 8, None)
    assert simulator.bench.command[4] == HOVER.U_mot
    simulator.switch_off()
    assert simulator.bench.command[4] == 0.0
