"""The gain margin in flight is that of the linear loop within 1 dB (issue: control)."""

from dataclasses import replace

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_control.controller_file import ControllerAxis, load_controller
from heli_control.flight_law import FlightLaw
from heli_control.sampled_loop import opened, sampled_margins, spectral_radius
from heli_flight.flown_margin import MarginFlight, linear_loop, multiplied

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


def test_flight_is_lost_within_1_db_of_the_linear_margin() -> None:
    margin = sampled_margins(linear_loop(LQ, "horizontal")).gain_up_db
    flight = MarginFlight(LQ, "horizontal", watch=6.0)
    borne, lost = flight.trial(margin - 1.0), flight.trial(margin + 1.0)
    assert not borne.lost
    assert borne.largest_rate < 0.15
    assert lost.lost
    assert not flight.over
