"""A swift flight is the flight of the components, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest

from heli_control.controller_file import load_controller
from heli_flight.flight_log import FlightLog
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import Plan, load_plan
from heli_flight.plan_phases import Hover
from heli_flight.swift_flight import SwiftFlight, is_swift, plain_flight


def windy(wind: float, wind_to: float) -> Plan:
    """The campaign's hover in gusts, in wind that changes."""
    plan = load_plan("campaign_hover")
    phases = tuple(
        replace(phase, wind=wind, wind_to=wind_to) if isinstance(phase, Hover) else phase
        for phase in plan.phases
    )
    return replace(plan, phases=phases)


def assert_same_bits(swift: FlightLog, plain: FlightLog) -> None:
    np.testing.assert_array_equal(swift.truth[:, :3], plain.truth[:, :3])
    np.testing.assert_array_equal(swift.command, plain.command)
    np.testing.assert_array_equal(swift.rotor, plain.rotor)
    np.testing.assert_array_equal(swift.state, plain.state)
    np.testing.assert_array_equal(swift.reference[:, :3], plain.reference[:, :3])
    # attitudes come back from quaternions on one side only
    np.testing.assert_allclose(swift.truth[:, 3:], plain.truth[:, 3:], atol=1e-12)
    assert (swift.reason, swift.remarks, swift.trace) == (plain.reason, plain.remarks, plain.trace)


@pytest.mark.parametrize(("name", "seed", "wind"), [("lq", 3, (1.0, 3.0)), ("ncf2", 8, (0.0, 2.0))])
def test_ground_truth_and_commands_are_those_of_the_components(
    name: str, seed: int, wind: tuple[float, float]
) -> None:
    plan, controller = windy(*wind), load_controller(name)
    swift = SwiftFlight(plan, seed, controller).fly()
    assert swift.reason == ""
    assert np.ptp(swift.truth[1500:, 0]) > 1e-3  # the gusts are there
    assert_same_bits(swift, plain_flight(plan, seed, controller))


def test_a_flight_that_is_lost_ends_at_the_same_tick_for_the_same_reason() -> None:
    values = NodeValues(
        {"supervisor": {"maximum_tilt": 0.06}, "bench_sim": {"link.dead_time": 0.02, "helicopter.mass": 7.5}}
    )
    plan, controller = windy(0.0, 3.0), load_controller("lq")
    swift = SwiftFlight(plan, 5, controller, values).fly()
    assert "roll or pitch" in swift.reason
    assert_same_bits(swift, plain_flight(plan, 5, controller, values))


def test_another_seed_is_another_flight() -> None:
    plan, controller = load_plan("campaign_hover"), load_controller("lq")
    first, second = (SwiftFlight(plan, seed, controller).fly() for seed in (1, 2))
    assert first.trace != second.trace
    assert first.trace == SwiftFlight(plan, 1, controller).fly().trace


@pytest.mark.parametrize("name", ["gusty_hover", "identification", "switching"])
def test_faults_excitations_and_changes_of_controller_are_left_to_the_components(name: str) -> None:
    plan = load_plan(name)
    assert not is_swift(plan)
    with pytest.raises(ValueError, match="faults, excitations or several controllers"):
        SwiftFlight(plan, 1, load_controller("lq"))
