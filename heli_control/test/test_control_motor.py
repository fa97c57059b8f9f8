from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.flight_state import FlightState, flight_state_values
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import TOPICS
from heli_control.motor_control import MotorController, MotorParameters, SpeedGovernor, governor_law

PARAMETERS = MotorParameters()
NOMINAL = 163.363
HOVER_TORQUE = 8.0 * 0.0150 * 54.7
"""Torque on the rotor shaft that takes 54.7 of the 60 A [N m]."""
TICK = 0.01


class Drive:
    """Supply, motor and rotor of spec 1.3; the load grows with the square of the speed.

    The command acts 5 ms after its sample; the measurement is low-passed as navigation does it.
    """

    def __init__(self, speed: float = 0.0, load: float = HOVER_TORQUE) -> None:
        self.speed, self.load = speed, load
        self.torque = 0.0
        if speed > 0.0:
            self.torque = load * (speed / NOMINAL) ** 2 / 8.0
        self.measured = speed
        self.voltage = 0.0
        self.current = 0.0

    def advance(self, command: float) -> float:
        """10 ms on; returns the measured speed."""
        inertia = 0.066446 + 0.001707 + 16.0 * 0.934e-4 + 64.0 * 1.2e-4
        step = 0.0005
        for k in range(20):
            if k == 10:
                self.voltage = command
            supply = min(max(4.0 * self.voltage, 0.0), 40.0)
            self.current = min(max((supply - 0.0150 * 8.0 * self.speed) / 0.0467, 0.0), 60.0)
            self.torque += step / 0.0134 * (0.0150 * self.current - self.torque)
            load = self.load * (self.speed / NOMINAL) ** 2
            self.speed += step / inertia * (8.0 * self.torque - load)
        self.measured += (1.0 - math.exp(-1.0)) * (self.speed - self.measured)
        return self.measured


def hovering() -> tuple[SpeedGovernor, Drive]:
    governor, drive = SpeedGovernor(PARAMETERS), Drive(NOMINAL)
    governor.integral = (0.12 * NOMINAL + 54.7 * 0.0467) / 4.0
    for _ in range(300):
        drive.advance(governor.step(NOMINAL, drive.measured))
    assert drive.speed == pytest.approx(NOMINAL, rel=1e-4)
    assert drive.current == pytest.approx(54.7, rel=1e-3)
    return governor, drive


def test_first_two_samples_by_hand() -> None:
    governor = SpeedGovernor(PARAMETERS)
    assert governor.step(1.0, 0.0) == pytest.approx(0.1)
    # integral: 0.1 / 0.2 * 1 * 0.01 = 0.005 V; 0.1 V lies within 0 .. 0.70 V, so no anti-windup
    assert governor.integral == pytest.approx(0.005)
    assert governor.step(1.0, 0.0) == pytest.approx(0.105)


def test_small_step_closes_at_13_radians_per_second() -> None:
    governor, drive = hovering()
    drive.load *= 0.95  # a little room in the current
    for _ in range(200):
        drive.advance(governor.step(NOMINAL, drive.measured))
    start, target = drive.speed, NOMINAL + 0.5
    speeds = [start]
    for _ in range(60):
        drive.advance(governor.step(target, drive.measured))
        speeds.append(drive.speed)
    rise = next(k for k, speed in enumerate(speeds) if speed - start > (1.0 - math.exp(-1.0)) * 0.5)
    assert 1.0 / 13.0 - 0.01 <= rise * TICK <= 1.0 / 13.0 + 0.035  # and the delays
    assert max(speeds) - target < 0.1 * 0.5


def test_run_up_from_rest_follows_the_ramp_without_winding_up() -> None:
    governor, drive = SpeedGovernor(PARAMETERS), Drive(load=0.35 * HOVER_TORQUE)
    speeds, lag = [], []
    for k in range(1100):
        reference = min(NOMINAL, NOMINAL / 6.0 * k * TICK)
        drive.advance(governor.step(reference, drive.measured))
        speeds.append(drive.speed)
        lag.append(reference - drive.speed)
    assert max(lag) < 5.0
    assert max(speeds) < 1.01 * NOMINAL
    assert speeds[-1] == pytest.approx(NOMINAL, rel=1e-3)


def test_reference_that_outruns_the_drive_does_not_wind_up() -> None:
    governor, drive = SpeedGovernor(PARAMETERS), Drive(load=0.35 * HOVER_TORQUE)
    speeds, currents = [], []
    for _ in range(600):
        drive.advance(governor.step(NOMINAL, drive.measured))
        speeds.append(drive.speed)
        currents.append(drive.current)
    assert currents[50] == pytest.approx(60.0)
    assert max(speeds) < 1.02 * NOMINAL
    assert speeds[-1] == pytest.approx(NOMINAL, rel=1e-3)


@pytest.mark.parametrize("factor", [0.8, 0.95, 1.04, 1.08])
def test_load_step_that_the_drive_can_hold_is_back_within_two_percent(factor: float) -> None:
    governor, drive = hovering()
    drive.load *= factor
    for k in range(300):
        drive.advance(governor.step(NOMINAL, drive.measured))
        assert abs(drive.speed - NOMINAL) < 0.06 * NOMINAL
        if k >= 100:
            assert abs(drive.speed - NOMINAL) < 0.02 * NOMINAL
    assert drive.speed == pytest.approx(NOMINAL, rel=2e-3)


def test_overload_sags_and_comes_back_without_winding_up() -> None:
    governor, drive = hovering()
    drive.load *= 1.5
    for _ in range(50):
        drive.advance(governor.step(NOMINAL, drive.measured))
    assert 0.85 * NOMINAL < drive.speed < 0.97 * NOMINAL
    drive.load /= 1.5
    speeds = []
    for _ in range(300):
        drive.advance(governor.step(NOMINAL, drive.measured))
        speeds.append(drive.speed)
    assert max(speeds) < 1.01 * NOMINAL
    assert speeds[-1] == pytest.approx(NOMINAL, rel=2e-3)


def test_lasting_overload_leaves_the_integral_at_the_limit() -> None:
    governor, drive = hovering()
    drive.load *= 1.5
    for _ in range(2000):
        command = governor.step(NOMINAL, drive.measured)
        drive.advance(command)
    assert drive.current == pytest.approx(60.0)
    assert drive.speed < 0.98 * NOMINAL
    # asked for no more than a few tenths of a volt beyond what the current limit lets through
    assert command < 0.03 * drive.speed + 0.7 + 0.1 * (NOMINAL - drive.speed) + 0.1


def test_braking_cannot_wind_down() -> None:
    governor, drive = hovering()
    for _ in range(400):
        drive.advance(governor.step(0.8 * NOMINAL, drive.measured))
    assert drive.speed == pytest.approx(0.8 * NOMINAL, rel=2e-3)
    lowest = NOMINAL
    for _ in range(400):
        drive.advance(governor.step(0.8 * NOMINAL, drive.measured))
        lowest = min(lowest, drive.speed)
    assert lowest > 0.79 * NOMINAL


@settings(deadline=None, max_examples=50)
@given(st.lists(st.tuples(st.floats(0.0, 250.0), st.floats(0.0, 250.0)), min_size=1, max_size=80))
def test_voltage_stays_in_its_range_and_the_integral_bounded(samples: list[tuple[float, float]]) -> None:
    governor = SpeedGovernor(PARAMETERS)
    for reference, speed in samples:
        assert 0.0 <= governor.step(reference, speed) <= 10.0
        assert abs(governor.integral) < 40.0


def send(component: MotorController, tick: int, state: FlightState, reference: float, speed: float) -> float:
    stamp = tick * CONTROL_PERIOD_NS
    assert component.receive("flight_state", stamp, flight_state_values(state, reference)) == []
    (message,) = component.receive("rotor_state", stamp, (0.0, speed, 0.0))
    assert (message.topic, message.stamp_ns) == ("motor_command", stamp)
    assert len(message.values) == len(TOPICS["motor_command"].layout.fields)
    assert message.values[:2] == (0.0, 0.0)
    return float(message.values[2])


@pytest.mark.parametrize(
    ("state", "reference"),
    [
        (FlightState.IDLE, 163.0),
        (FlightState.STOPPED, 163.0),
        (FlightState.FAULT, 163.0),
        (FlightState.RUN_DOWN, 0.0),
        (FlightState.FLYING, -1.0),
    ],
)
def test_no_reference_idle_and_end_are_exactly_zero_volts_and_reset(
    state: FlightState, reference: float
) -> None:
    component = MotorController(PARAMETERS)
    first = send(component, 0, FlightState.RUN_UP, 10.0, 5.0)
    assert first == pytest.approx(0.5)
    assert send(component, 1, FlightState.RUN_UP, 10.0, 5.0) > first
    assert send(component, 2, state, reference, 5.0) == 0.0
    assert send(component, 3, FlightState.RUN_UP, 10.0, 5.0) == first


@pytest.mark.parametrize("topic", MotorController.inputs)
def test_a_number_that_is_not_finite_is_refused_by_name(topic: str) -> None:
    fields = TOPICS[topic].layout.fields
    for index, field in enumerate(fields):
        values = [0.0] * len(fields)
        values[index] = math.inf
        with pytest.raises(ValueError, match=f"{topic}: {field} is inf"):
            MotorController(PARAMETERS).receive(topic, 0, values)


def test_linear_law_steps_as_the_governor_within_its_limits() -> None:
    law = governor_law(PARAMETERS, 100.0, "Omega")
    assert (law.inputs, law.outputs) == (("Omega",), ("U_mot",))
    governor, wide = SpeedGovernor(PARAMETERS), 0.5 * (5.54 + 4.9)
    governor.integral = hover = wide
    filtered, x = 0.0, np.zeros(2)
    for deviation in (0.3, -0.2, 0.5, 0.4, -0.6, 0.0):
        # the low-pass y+ = y + (1 - e^-1) (x - y) of 100 rad/s
        filtered += (1.0 - math.exp(-1.0)) * (deviation - filtered)
        voltage = governor.step(NOMINAL, NOMINAL + filtered)
        (linear,) = law.C @ x + law.D @ [deviation]
        assert voltage - hover == pytest.approx(linear, abs=1e-12)
        x = law.A @ x + law.B @ [deviation]
