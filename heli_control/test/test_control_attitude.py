from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_common.rotations import Euler, Vector3
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import TOPICS
from heli_common.vehicle_state import UNKNOWN_VARIANCE, VehicleState, odometry_values, twist_values
from heli_control.attitude_control import AttitudeController, AttitudeParameters
from heli_control.controller_file import ControllerAxis, ControllerFile
from heli_control.flight_law import FlightLaw
from heli_control.lq import LqWeights, design_lq

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")
LQ = design_lq(MODEL, LqWeights())
STATIC = design_lq(MODEL, LqWeights(command_delay=0.0))
POINT = MODEL.operating_point
TRIM = (POINT.B_1s, POINT.A_1s, POINT.theta_0, POINT.theta_t)
PARAMETERS = AttitudeParameters()
IDLE = (0.0, 0.0, math.radians(1.0), math.radians(4.0))
ZERO = (0.0, 0.0, 0.0)
HOVER = VehicleState(ZERO, Euler(0.3, POINT.theta, POINT.phi), ZERO, ZERO)


def only(axis: str, signal: str, output: str, gain: float) -> ControllerFile:
    """A controller with one gain and otherwise trim."""

    def block(name: str, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> ControllerAxis:
        direct = np.zeros((2, len(inputs)))
        if name == axis:
            direct[outputs.index(output), inputs.index(signal)] = gain
        empty = (np.zeros((0, 0)), np.zeros((0, len(inputs))), np.zeros((2, 0)))
        return ControllerAxis(StateSpace((), inputs, outputs, *empty, direct), np.zeros((0, 2)))

    return replace(
        STATIC,
        horizontal=block("horizontal", STATIC.horizontal.system.inputs, ("B_1s", "A_1s")),
        vertical=block("vertical", STATIC.vertical.system.inputs, ("theta_0", "theta_t")),
    )


class Driver:
    """Feeds a component sample after sample."""

    def __init__(self, *controllers: ControllerFile) -> None:
        self.component = AttitudeController(controllers[0], PARAMETERS, controllers[1:])
        self.tick = 0

    def step(
        self,
        state: VehicleState = HOVER,
        velocity: Vector3 = ZERO,
        yaw_rate: float = 0.0,
        flight: FlightState = FlightState.FLYING,
        known: bool = True,
        planned: int = 0,
    ) -> tuple[float, ...]:
        stamp = self.tick * CONTROL_PERIOD_NS
        self.tick += 1
        variance = (1e-6 if known else UNKNOWN_VARIANCE,) * 6
        receive = self.component.receive
        assert receive("flight_state", stamp, flight_state_values(flight, 163.0, controller=planned)) == []
        assert receive("velocity_reference", stamp, twist_values(velocity, (0.0, 0.0, yaw_rate))) == []
        (message,) = receive("odometry", stamp, odometry_values(state, variance, variance))
        assert (message.topic, message.stamp_ns) == ("servo_command", stamp)
        assert len(message.values) == len(TOPICS["servo_command"].layout.fields)
        assert set(message.values[4:]) == {0.0}
        return tuple(message.values[:4])

    def engaged(self) -> Driver:
        for _ in range(260):  # full authority after 200; then the past commands are those of full authority
            self.step()
        assert self.component.authority == 1.0
        return self


def test_it_does_not_matter_when_the_states_go_on() -> None:
    """Right after the command, as nodes do it, or when the next message comes."""
    prompt, late = Driver(LQ).engaged(), Driver(LQ).engaged()
    for step in range(50):
        state = HOVER._replace(velocity=(0.01 * step, -0.02, 0.03 * (step % 7)))
        assert prompt.step(state) == late.step(state)
        assert prompt.component.update() == []


def test_hover_at_the_operating_point_is_trim() -> None:
    assert Driver(LQ).engaged().step() == pytest.approx(TRIM, abs=1e-12)


@pytest.mark.parametrize(
    ("axis", "signal", "output", "state"),
    [
        ("horizontal", "theta", "B_1s", HOVER._replace(attitude=Euler(0, POINT.theta + 0.1, POINT.phi))),
        ("horizontal", "phi", "A_1s", HOVER._replace(attitude=Euler(0, POINT.theta, POINT.phi + 0.1))),
        ("horizontal", "u", "A_1s", HOVER._replace(velocity=(0.1, 0.0, 0.0))),
        ("horizontal", "v", "B_1s", HOVER._replace(velocity=(0.0, 0.1, 0.0))),
        ("horizontal", "p", "A_1s", HOVER._replace(rates=(0.1, 0.0, 0.0))),
        ("horizontal", "q", "B_1s", HOVER._replace(rates=(0.0, 0.1, 0.0))),
        ("vertical", "w", "theta_0", HOVER._replace(velocity=(0.0, 0.0, 0.1))),
        ("vertical", "r", "theta_t", HOVER._replace(rates=(0.0, 0.0, 0.1))),
    ],
)
def test_every_signal_reaches_its_command_through_the_message(
    axis: str, signal: str, output: str, state: VehicleState
) -> None:
    command = Driver(only(axis, signal, output, 0.5)).engaged().step(state)
    channel = ("B_1s", "A_1s", "theta_0", "theta_t").index(output)
    expected = list(TRIM)
    expected[channel] += 0.5 * 0.1
    assert command == pytest.approx(expected, abs=1e-12)


def test_reference_is_turned_from_heading_axes_into_the_body() -> None:
    # level heading axes against a body rolled by 90 deg to the right: down is to the right of the body
    rolled = HOVER._replace(attitude=Euler(1.0, 0.0, math.pi / 2.0))
    law = only("horizontal", "v_ref", "A_1s", 0.1)
    assert Driver(law).engaged().step(rolled, (0.0, 0.0, 0.5))[1] == pytest.approx(TRIM[1] + 0.05)
    law = only("vertical", "w_ref", "theta_0", 0.1)
    assert Driver(law).engaged().step(rolled, (0.0, 0.5, 0.0))[2] == pytest.approx(TRIM[2] - 0.05)
    # nose up by 0.2 rad: forward has a part along the body's z axis
    pitched = HOVER._replace(attitude=Euler(0.0, 0.2, 0.0))
    assert Driver(law).engaged().step(pitched, (0.5, 0.0, 0.0))[2] == pytest.approx(
        TRIM[2] + 0.05 * math.sin(0.2)
    )
    law = only("vertical", "r_ref", "theta_t", 0.1)
    assert Driver(law).engaged().step(yaw_rate=0.5)[3] == pytest.approx(TRIM[3] + 0.05)


def test_authority_rises_in_two_seconds_and_falls_in_one() -> None:
    driver = Driver(STATIC)
    assert driver.step(flight=FlightState.RUN_UP) == pytest.approx(IDLE)
    for k in range(1, 201):
        command = driver.step()
        expected = [idle + min(1.0, k / 200.0) * (trim - idle) for idle, trim in zip(IDLE, TRIM, strict=True)]
        assert command == pytest.approx(expected, abs=1e-9)
    for k in range(1, 101):
        command = driver.step(flight=FlightState.RUN_DOWN)
        expected = [trim + k / 100.0 * (idle - trim) for idle, trim in zip(IDLE, TRIM, strict=True)]
        assert command == pytest.approx(expected, abs=1e-9)
    assert driver.step(flight=FlightState.RUN_DOWN) == IDLE


@pytest.mark.parametrize("flight", [FlightState.FAULT, FlightState.STOPPED])
def test_fault_and_end_are_idle_at_once(flight: FlightState) -> None:
    driver = Driver(LQ).engaged()
    assert driver.step(flight=flight) == IDLE
    assert driver.component.authority == 0.0


def test_unknown_pose_holds_the_law_and_takes_authority_back() -> None:
    driver = Driver(STATIC).engaged()
    moving = HOVER._replace(velocity=(0.05, 0.0, 0.0))
    before = driver.step(moving)
    after = driver.step(VehicleState(ZERO, Euler(0, 0, 0), ZERO, ZERO), known=False)
    expected = [b + 0.01 * (idle - b) for b, idle in zip(before, IDLE, strict=True)]
    assert after == pytest.approx(expected, abs=1e-12)
    never = Driver(LQ)
    assert never.step(known=False) == IDLE


def test_commands_stay_within_the_reach_of_the_servos() -> None:
    driver = Driver(LQ).engaged()
    wild = VehicleState(ZERO, Euler(0.0, -1.0, 1.0), (3.0, -3.0, 9.0), (3.0, 3.0, 9.0))
    degrees = [math.degrees(value) for value in driver.step(wild)]
    assert abs(degrees[0]) <= 10.0 + 1e-9
    assert abs(degrees[1]) <= 10.0 + 1e-9
    assert degrees[2] == pytest.approx(16.0)
    assert degrees[3] == pytest.approx(25.0)
    wild = wild._replace(velocity=(0.0, 0.0, -9.0), rates=(0.0, 0.0, -9.0))
    degrees = [math.degrees(value) for value in driver.step(wild)]
    assert degrees[2] == pytest.approx(-4.0)
    assert degrees[3] == pytest.approx(-5.0)


def test_release_forgets_the_past_commands() -> None:
    driver = Driver(LQ).engaged()
    for _ in range(10):
        driver.step(HOVER._replace(velocity=(0.3, 0.2, 0.1)))
    driver.step(flight=FlightState.FAULT)
    assert driver.engaged().step() == pytest.approx(TRIM, abs=1e-12)


def test_another_controller_takes_over_without_a_jump() -> None:
    driver = Driver(STATIC).engaged()
    state = HOVER._replace(velocity=(0.1, -0.1, 0.05), rates=(0.02, 0.0, 0.1))
    before = driver.step(state)
    stiff = replace(LqWeights(command_delay=0.0), u=20.0, w=5.0)
    target = design_lq(MODEL, stiff)
    driver.component.replace(target)
    commands = [before] + [driver.step(state) for _ in range(60)]
    jumps = np.abs(np.diff(np.array(commands), axis=0)).max(axis=0)
    whole = np.abs(np.array(commands[-1]) - before)
    assert (jumps <= whole / 50.0 + 1e-12).all()
    assert whole.max() > 0.01
    assert commands[-1] == pytest.approx(Driver(target).engaged().step(state), abs=1e-12)


def test_an_integral_does_not_wind_up_while_authority_rises() -> None:
    """On the stop a velocity error stays; the law is told what went out."""
    lag = StateSpace(
        ("i", "j"), ("w", "r"), ("theta_0", "theta_t"),
        np.eye(2), 0.1 * np.eye(2), np.eye(2), np.zeros((2, 2)),
    )  # fmt: skip
    told = replace(STATIC, vertical=ControllerAxis(lag, 0.5 * np.eye(2)))
    deaf = replace(STATIC, vertical=ControllerAxis(lag, np.zeros((2, 2))))
    sinking = HOVER._replace(velocity=(0.0, 0.0, 0.1))
    ends = []
    for law in (told, deaf):
        driver = Driver(law)
        for _ in range(150):
            command = driver.step(sinking)
        ends.append(command[2])
    # it settles where half of the quarter not applied is 0.01: 0.08 above idle, of which 0.06 act
    assert ends[0] == pytest.approx(IDLE[2] + 0.06, abs=0.01)
    assert ends[1] > IDLE[2] + 0.75 * (PARAMETERS.collective_maximum - IDLE[2]) - 1e-9


def test_the_first_command_of_another_controller_is_the_one_before() -> None:
    driver = Driver(LQ).engaged()
    state = HOVER._replace(velocity=(0.05, -0.05, 0.05), rates=(0.02, 0.0, 0.1))
    for _ in range(60):
        before = driver.step(state)
    driver.component.replace(design_lq(MODEL, replace(LqWeights(), u=20.0, w=5.0)))
    assert driver.step(state) == pytest.approx(before, abs=1e-9)


def test_the_plan_says_by_stamp_which_controller_flies() -> None:
    other = replace(design_lq(MODEL, replace(LqWeights(), u=4.0)), name="other")
    driver = Driver(LQ, other).engaged()
    assert driver.component.exchanged is None
    driver.step(planned=1)
    assert driver.component.exchanged == ((driver.tick - 1) * CONTROL_PERIOD_NS, "other")
    driver.component.replace(STATIC)  # in between: until the plan changes its own
    driver.step(planned=1)
    driver.step(planned=1)
    assert driver.component.exchanged == ((driver.tick - 2) * CONTROL_PERIOD_NS, "lq")
    driver.step(planned=0)
    assert driver.component.exchanged == ((driver.tick - 1) * CONTROL_PERIOD_NS, "lq")
    for planned in (2, 0.5, -1):
        with pytest.raises(
            ValueError, match=rf"flight_state: position\.controller {planned}.* is none of 0 \.\. 1"
        ):
            driver.step(planned=planned)  # type: ignore[arg-type]


def test_every_controller_of_the_plan_is_checked_at_the_start() -> None:
    impossible = replace(LQ, name="later", operating_point=replace(POINT, theta_0=0.5))
    with pytest.raises(InputError, match=r"later: operating_point\.theta_0"):
        Driver(LQ, impossible)


def test_replacing_on_the_ground_is_at_once() -> None:
    driver = Driver(STATIC)
    driver.step(flight=FlightState.IDLE)
    driver.component.replace(LQ)
    assert driver.engaged().step() == pytest.approx(TRIM, abs=1e-12)


def test_operating_point_outside_the_limits_is_refused() -> None:
    impossible = replace(LQ, operating_point=replace(POINT, theta_0=0.5))
    with pytest.raises(
        InputError, match=r"lq: operating_point\.theta_0: 0\.5 \(allowed: -0\.06981 \.\. 0\.2793"
    ):
        AttitudeController(impossible, PARAMETERS)
    driver = Driver(LQ)
    with pytest.raises(InputError):
        driver.component.replace(impossible)
    assert driver.engaged().step() == pytest.approx(TRIM, abs=1e-12)


@pytest.mark.parametrize("topic", AttitudeController.inputs)
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_is_not_finite_is_refused_by_name(topic: str, value: float) -> None:
    fields = TOPICS[topic].layout.fields
    for index, field in enumerate(fields):
        values = [0.0] * len(fields)
        values[index] = value
        with pytest.raises(ValueError) as caught:
            AttitudeController(LQ, PARAMETERS).receive(topic, 0, values)
        assert str(caught.value) == f"{topic}: {field} is {value}"


def test_a_command_that_is_not_finite_is_never_sent() -> None:
    both = only("horizontal", "u", "B_1s", 1e10).horizontal
    direct = replace(both.system, D=np.full(both.system.D.shape, 1e10))
    driver = Driver(replace(STATIC, horizontal=replace(both, system=direct)))
    with pytest.raises(ValueError, match=r"servo_command: position\.B_1s is nan"):
        driver.step(HOVER._replace(velocity=(1e300, -1e300, 0.0)))


def test_law_with_other_inputs_and_states_fits() -> None:
    lag = StateSpace(
        ("a", "b"), ("phi", "w_ref"), ("theta_t", "theta_0"),
        np.array([[0.5, 0.0], [0.0, 0.5]]), np.eye(2), np.eye(2), np.zeros((2, 2)),
    )  # fmt: skip
    law = FlightLaw(replace(STATIC, vertical=ControllerAxis(lag, np.zeros((2, 2)))))
    state = HOVER._replace(attitude=Euler(0.0, POINT.theta, POINT.phi + 0.2))
    assert law.step(state, (0.0, 0.0, 0.1), 0.0)[2:] == pytest.approx(TRIM[2:])
    assert law.step(state, (0.0, 0.0, 0.1), 0.0)[2:] == pytest.approx((TRIM[2] + 0.1, TRIM[3] + 0.2))
