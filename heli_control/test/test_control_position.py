from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.flight_state import FlightState, flight_state_values
from heli_common.rotations import Euler, Vector3
from heli_common.timing import CONTROL_PERIOD, CONTROL_PERIOD_NS
from heli_common.topics import TOPICS
from heli_common.vehicle_state import (
    UNKNOWN_VARIANCE,
    VehicleState,
    odometry_values,
    pose_values,
    twist_from_values,
    twist_values,
)
from heli_control.position_control import (
    PositionController,
    PositionLaw,
    PositionParameters,
    ProportionalIntegral,
)
from heli_control.reference_model import ReferenceModel

PARAMETERS = PositionParameters()
ZERO = (0.0, 0.0, 0.0)


def standing(position: Vector3 = ZERO, psi: float = 0.0) -> VehicleState:
    return VehicleState(position, Euler(psi, 0.0, -0.09), ZERO, ZERO)


def odometry(state: VehicleState, known: bool = True) -> tuple[float, ...]:
    variance = (1e-6 if known else UNKNOWN_VARIANCE,) * 6
    return odometry_values(state, variance, variance)


def stage(state: FlightState) -> tuple[float, ...]:
    return flight_state_values(state, 163.0)


def ask(
    controller: PositionController,
    tick: int,
    state: VehicleState,
    position: Vector3 = ZERO,
    psi: float = 0.0,
    flight: FlightState = FlightState.FLYING,
    known: bool = True,
) -> tuple[float, float, float, float]:
    """Forward, right, down velocity and yaw rate that the component asks for."""
    stamp = tick * CONTROL_PERIOD_NS
    assert controller.receive("odometry", stamp, odometry(state, known)) == []
    assert controller.receive("reference", stamp, pose_values(position, Euler(psi, 0.0, 0.0))) == []
    (message,) = controller.receive("flight_state", stamp, stage(flight))
    assert (message.topic, message.stamp_ns) == ("velocity_reference", stamp)
    assert len(message.values) == len(TOPICS["velocity_reference"].layout.fields)
    linear, angular = twist_from_values(message.values)
    assert angular[:2] == (0.0, 0.0)
    return (*linear, angular[2])


def first_response(step: float, frequency: float) -> tuple[float, float]:
    """Expected position and rate one control period after a step [m, m/s]."""
    turned = frequency * CONTROL_PERIOD
    decay = math.exp(-turned)
    return step * (1.0 - (1.0 + turned) * decay), step * frequency * turned * decay


def test_first_sample_is_the_gain_times_the_error() -> None:
    asked = ask(PositionController(PARAMETERS), 0, standing(), (0.1, -0.2, 0.3), 0.2)
    down = first_response(0.3, PARAMETERS.response_z)
    assert asked == pytest.approx((0.2, -0.4, 0.7 * down[0] + down[1], 0.5))


def test_errors_are_turned_into_the_heading() -> None:
    # nose east: a target in the north lies to the left
    asked = ask(
        PositionController(PARAMETERS), 0, standing(psi=math.pi / 2.0), (0.1, 0.0, 0.0), math.pi / 2.0
    )
    assert asked == pytest.approx((0.0, -0.2, 0.0, 0.0), abs=1e-12)


def test_integral_grows_by_gain_over_time() -> None:
    axis = ProportionalIntegral(2.0, 5.0, 0.3, 0.8)
    for _ in range(101):
        output = axis.step(0.1, 0.1)
    assert output == pytest.approx(0.2 + 2.0 / 5.0 * 0.1 * 1.0)


def test_integral_and_output_are_limited() -> None:
    controller = PositionController(PARAMETERS)
    for tick in range(6000):
        asked = ask(controller, tick, standing(), (0.1, 0.1, 0.1), 0.1)
    # on its way the expected response is 2 / omega s late, so much less has been taken in
    expected_down = 0.7 * 0.1 + 0.7 / 15.0 * 0.1 * (59.99 - 2.0 / PARAMETERS.response_z)
    assert asked == pytest.approx((0.5, 0.5, expected_down, 0.25 + 0.5), abs=1e-4)
    for tick in range(6000, 6200):
        asked = ask(controller, tick, standing(), (5.0, -5.0, 5.0), 3.0)
    assert asked == pytest.approx((0.8, -0.8, 0.5, 1.0))


def test_a_step_that_is_answered_as_expected_leaves_no_integral() -> None:
    law, expected = PositionLaw(PARAMETERS), ReferenceModel(PARAMETERS.response_x)
    law.step(standing(), ZERO, 0.0)
    expected.step(0.0)
    for _ in range(600):
        expected.step(0.3)
        law.step(standing((expected.value, 0.0, 0.0)), (0.3, 0.0, 0.0), 0.0)
    assert law.axes[0].integral == pytest.approx(0.0, abs=1e-12)


def test_a_vertical_ramp_is_fed_forward() -> None:
    law, expected = PositionLaw(PARAMETERS), ReferenceModel(PARAMETERS.response_z)
    for tick in range(500):
        ramp = -0.15 * tick * CONTROL_PERIOD
        expected.step(ramp)
        asked = law.step(standing((0.0, 0.0, expected.value)), (0.0, 0.0, ramp), 0.0)
    assert asked[2] == pytest.approx(-0.15, rel=0.02)


def test_integral_stands_still_while_the_output_is_limited() -> None:
    axis = ProportionalIntegral(2.0, 5.0, 0.3, 0.8)
    for _ in range(500):
        assert axis.step(1.0, 1.0) == 0.8
    assert axis.integral == 0.0
    axis.integral = 0.3
    axis.step(-1.0, -1.0)  # limited the other way, but the error takes the integral back towards zero
    assert axis.integral == 0.3
    axis.step(-0.1, -0.1)
    assert axis.integral == pytest.approx(0.3 - 2.0 / 5.0 * 0.1 * CONTROL_PERIOD)


def test_feed_forward_is_added_before_the_limit() -> None:
    law = PositionLaw(PARAMETERS)
    assert law.step(standing(), ZERO, 0.0, (0.3, -0.1, 0.2, 0.4)) == pytest.approx((0.3, -0.1, 0.2, 0.4))
    assert law.step(standing(), ZERO, 0.0, (3.0, -3.0, 3.0, 3.0)) == pytest.approx((0.8, -0.8, 0.5, 1.0))


def test_heading_error_goes_through_the_front_never_round_the_back() -> None:
    asked = ask(PositionController(PARAMETERS), 0, standing(psi=math.radians(160)), ZERO, math.radians(-160))
    assert asked[3] == -1.0


@pytest.mark.parametrize(
    ("flight", "known"),
    [(state, True) for state in FlightState if not state.controlled] + [(FlightState.FLYING, False)],
)
def test_not_controlled_or_not_known_gives_zeros_and_resets(flight: FlightState, known: bool) -> None:
    controller = PositionController(PARAMETERS)
    for tick in range(100):
        ask(controller, tick, standing(), (0.1, 0.1, 0.1), 0.1)
    assert ask(controller, 100, standing(), (0.1, 0.1, 0.1), 0.1, flight, known) == (0.0,) * 4
    asked = ask(controller, 101, standing(), (0.1, 0.1, 0.1), 0.1)
    assert asked == ask(PositionController(PARAMETERS), 101, standing(), (0.1, 0.1, 0.1), 0.1)
    assert asked[:2] == pytest.approx((0.2, 0.2))


@settings(deadline=None, max_examples=50)
@given(st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=60))
def test_output_and_integral_never_leave_their_limits(errors: list[float]) -> None:
    axis = ProportionalIntegral(2.0, 5.0, 0.3, 0.8)
    for error in errors:
        assert abs(axis.step(error, error)) <= 0.8
        assert abs(axis.integral) <= 0.3


@pytest.mark.parametrize("topic", ["odometry", "reference", "flight_state"])
def test_a_number_that_is_not_finite_is_refused_by_name(topic: str) -> None:
    values = {
        "odometry": odometry(standing()),
        "reference": pose_values(ZERO, Euler(0, 0, 0)),
        "flight_state": stage(FlightState.IDLE),
    }[topic]
    for index, field in enumerate(TOPICS[topic].layout.fields):
        broken = [*values[:index], math.nan, *values[index + 1 :]]
        with pytest.raises(ValueError) as caught:
            PositionController(PARAMETERS).receive(topic, 0, broken)
        assert str(caught.value) == f"{topic}: {field} is nan"


def test_unknown_topic_and_flight_state_are_refused() -> None:
    with pytest.raises(ValueError, match="'encoders' is none of"):
        PositionController(PARAMETERS).receive("encoders", 0, [0.0])
    controller = PositionController(PARAMETERS)
    controller.receive("odometry", 0, odometry(standing()))
    controller.receive("reference", 0, pose_values(ZERO, Euler(0, 0, 0)))
    with pytest.raises(ValueError, match="flight state code 9"):
        controller.receive("flight_state", 0, flight_state_values(9.0))


def excited(controller: PositionController, tick: int, *excitation: float) -> tuple[float, ...]:
    """Forward, right, down velocity and yaw rate asked for with an excitation of the reference."""
    stamp = tick * CONTROL_PERIOD_NS
    twist = twist_values((excitation[0], excitation[1], excitation[2]), (0.0, 0.0, excitation[3]))
    controller.receive("odometry", stamp, odometry(standing()))
    controller.receive("reference", stamp, pose_values(ZERO, Euler(0.0, 0.0, 0.0)))
    assert controller.receive("flight_state", stamp, stage(FlightState.FLYING)) == []
    (message,) = controller.receive("reference_excitation", stamp, twist)
    assert message.stamp_ns == stamp
    linear, angular = twist_from_values(message.values)
    return (*linear, angular[2])


def test_an_excitation_is_added_to_the_reference_inside_its_limits() -> None:
    controller = PositionController(PARAMETERS, excited=True)
    assert excited(controller, 0, 0.1, -0.2, 0.05, 0.3) == pytest.approx((0.1, -0.2, 0.05, 0.3))
    assert excited(controller, 1, 9.0, -9.0, 9.0, -9.0) == pytest.approx((0.8, -0.8, 0.5, -1.0))
    assert "reference_excitation" not in PositionController(PARAMETERS).inputs


def test_a_lost_identification_leaves_the_reference_as_it_is_and_the_stamps_right() -> None:
    controller = PositionController(PARAMETERS, excited=True)
    stamps = []
    for tick in range(10):
        stamp = tick * CONTROL_PERIOD_NS
        controller.receive("odometry", stamp, odometry(standing()))
        controller.receive("reference", stamp, pose_values(ZERO, Euler(0.0, 0.0, 0.0)))
        for message in controller.receive("flight_state", stamp, stage(FlightState.FLYING)):
            assert all(value == pytest.approx(0.0) for value in message.values)
            stamps.append(message.stamp_ns // CONTROL_PERIOD_NS)
    assert stamps == [0, 1, 2, 3, 5, 6, 7, 8, 9]
