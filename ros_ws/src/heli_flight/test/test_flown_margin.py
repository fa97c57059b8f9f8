"""The gain margin in flight is that of the linear loop within 1 dB (issue: control)."""

from dataclasses import replace

import numpy as np
import pytest

from heli_bench_sim import linearize
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.trim import trim
from heli_common.errors import InputError
from heli_control.controller_file import ControllerAxis, load_controller
from heli_control.flight_law import FlightLaw
from heli_control.position_loop import with_positions
from heli_control.rig_plant import with_friction
from heli_control.sampled_loop import NO_CONTROLLER, opened, sampled_margins, spectral_radius
from heli_flight.flown_margin import LOST_RATIO, NO_HOVER_RATE, MarginFlight, linear_loop, multiplied

LQ = load_controller("lq")


def test_multiplied_commands_and_nothing_else() -> None:
    three = multiplied(LQ, "horizontal", 3.0)
    np.testing.assert_allclose(three.horizontal.system.D, 3.0 * LQ.horizontal.system.D)
    np.testing.assert_allclose(three.horizontal.system.C, 3.0 * LQ.horizontal.system.C)
    np.testing.assert_array_equal(three.horizontal.system.A, LQ.horizontal.system.A)
    np.testing.assert_array_equal(three.vertical.system.D, LQ.vertical.system.D)
    assert three.operating_point == LQ.operating_point
    with pytest.raises(InputError, match="'sideways' is no axis"):
        multiplied(LQ, "sideways", 2.0)
    with pytest.raises(ValueError, match=r"factor 0\.0; allowed: above 0"):
        multiplied(LQ, "horizontal", 0.0)


def test_a_limit_acts_on_the_states_as_before() -> None:
    """Commands cut to a share are the same share of what was asked, whatever the factor."""
    for axis in (LQ.horizontal, multiplied(LQ, "horizontal", 4.0).horizontal):
        assert np.linalg.norm(axis.anti_windup) > 0.0
    lifted = multiplied(LQ, "horizontal", 4.0).horizontal
    x, inputs = np.ones(len(lifted.system.states)), np.full(len(lifted.system.inputs), 0.01)
    following = []
    for axis in (LQ.horizontal, lifted):
        asked = axis.system.C @ x + axis.system.D @ inputs
        applied = 0.5 * asked
        following.append(axis.system.A @ x + axis.system.B @ inputs + axis.anti_windup @ (applied - asked))
    np.testing.assert_allclose(following[0], following[1], atol=1e-12)


def test_linear_loop_has_friction_servos_and_the_position_law() -> None:
    loop = linear_loop(LQ, "horizontal")
    assert loop.plant.outputs[-2:] == ("x", "y")
    assert loop.controller.inputs[-2:] == ("x", "y")
    assert loop.plant.A[2, 2] == pytest.approx(-0.0148 - 7.7 / 7.3, abs=1e-3)
    assert 14.5 < sampled_margins(loop).gain_up_db < 15.5
    assert sampled_margins(linear_loop(LQ, "vertical")).gain_up_db > 12.0
    plain = multiplied(LQ, "horizontal", 2.0)
    assert spectral_radius(opened(linear_loop(plain, "horizontal"))) == pytest.approx(
        spectral_radius(opened(loop), 2.0)
    )
    with pytest.raises(InputError, match="'sideways' is no axis"):
        linear_loop(LQ, "sideways")


def test_a_controller_without_references_flies_without_position_law() -> None:
    system = LQ.horizontal.system
    kept = tuple(name for name in system.inputs if not name.endswith("_ref"))
    bare = replace(
        LQ,
        horizontal=ControllerAxis(
            system.part(system.states, kept, system.outputs), LQ.horizontal.anti_windup
        ),
    )
    assert linear_loop(bare, "horizontal").controller.inputs == kept
    assert FlightLaw(bare).name == "lq"


@pytest.mark.parametrize(("name", "axis"), [("lq", "horizontal"), ("gst", "vertical")])
def test_flight_is_lost_within_1_db_of_the_linear_margin(name: str, axis: str) -> None:
    controller = load_controller(name)
    margin = sampled_margins(linear_loop(controller, axis)).gain_up_db
    flight = MarginFlight(controller, axis, watch=3.0)
    own = flight.trial(0.0, NO_HOVER_RATE)
    lost_rate = LOST_RATIO * own.largest_rate
    borne, lost = flight.trial(margin - 1.0, lost_rate), flight.trial(margin + 1.0, lost_rate)
    assert not own.lost
    assert not borne.lost
    assert lost.lost
    assert lost.largest_rate > 2.0 * borne.largest_rate
    assert not flight.over


def test_the_vertical_loop_has_the_drive_in_it() -> None:
    loop = linear_loop(load_controller("gst"), "vertical")
    assert loop.inner.outputs == ("U_mot",)
    held = linearize.vertical(BenchParameters().helicopter, trim(BenchParameters().helicopter))
    held = with_positions(with_friction(held, {"w": 5.0}, 7.3))
    ideal = replace(loop, plant=held, inner=NO_CONTROLLER)
    # an ideal governor's torque stands in for what the shaft's acceleration takes from the body: 0.8 dB
    apart = sampled_margins(ideal).gain_up_db - sampled_margins(loop).gain_up_db
    assert 0.5 < apart < 1.1
