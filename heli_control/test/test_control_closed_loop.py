"""Both flight controllers around the linear plant with what the design left out.

The plant has all eight horizontal and four vertical states, arm friction, servos of 25 Hz, pulse frames of
20 ms that take the newest command 5 ms old, and the low-passes of navigation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from heli_common.flight_state import FlightState, flight_state_values
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_common.rotations import Euler, Vector3, matrix_from_euler, rotate
from heli_common.timing import COMMAND_LATENCY_NS, SENSOR_PERIOD_NS, is_control_tick, is_pwm_tick
from heli_common.vehicle_state import VehicleState, odometry_values, pose_values
from heli_control.attitude_control import AttitudeController, AttitudeParameters
from heli_control.controller_file import ControllerFile
from heli_control.lq import LqWeights, design_lq
from heli_control.position_control import PositionController, PositionParameters
from heli_control.state_space import zero_order_hold

MODEL = ModelFile.read(Path(__file__).parent / "data" / "hover_model.yaml")
LQ = design_lq(MODEL, LqWeights())
POINT = MODEL.operating_point
TRIM = np.array([POINT.B_1s, POINT.A_1s, POINT.theta_0, POINT.theta_t])
STEP = SENSOR_PERIOD_NS * 1e-9
FRICTION = {"u": 7.7 / 7.3, "v": 8.6 / 7.3, "w": 5.0 / 7.3}
SERVO, SERVO_DAMPING = 2.0 * math.pi * 25.0, 0.7
VELOCITY_BANDWIDTH, RATE_BANDWIDTH = 40.0, 100.0


def second_order(omega: float, damping: float) -> tuple[np.ndarray, np.ndarray]:
    a = np.array([[0.0, 1.0], [-omega * omega, -2.0 * damping * omega]])
    return zero_order_hold(a, np.array([[0.0], [omega * omega]]), STEP)


@dataclass
class Bench:
    """Linear helicopter, servos and navigation; states are deviations from trim."""

    friction: bool = True
    gain: float = 1.0
    extra_delay_ns: int = 0
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    psi: float = 0.0

    def __post_init__(self) -> None:
        self.parts = [self._part(MODEL.horizontal), self._part(MODEL.vertical)]
        self.states = [np.zeros(8), np.zeros(4)]
        self.servo, self.shafts = second_order(SERVO, SERVO_DAMPING), np.zeros((2, 4))
        self.filters = [second_order(w, math.sqrt(0.5)) for w in (VELOCITY_BANDWIDTH, RATE_BANDWIDTH)]
        self.filtered = np.zeros((2, 2, 3))
        self.pulse = np.zeros(4)

    def _part(self, plant: StateSpace) -> tuple[np.ndarray, np.ndarray]:
        a = np.array(plant.A)
        for name, value in FRICTION.items() if self.friction else ():
            if name in plant.states:
                a[plant.states.index(name), plant.states.index(name)] -= value
        return zero_order_hold(a, self.gain * plant.B, STEP)

    def advance(self) -> None:
        a, b = self.servo
        self.shafts = a @ self.shafts + b * self.pulse
        for index, (late, direct) in enumerate(self.parts):
            self.states[index] = (
                late @ self.states[index] + direct @ self.shafts[0, 2 * index : 2 * index + 2]
            )
        theta, phi, u, v, q, p = self.states[0][:6]
        w, r = self.states[1][:2]
        attitude = Euler(self.psi, POINT.theta + theta, POINT.phi + phi)
        self.position = self.position + STEP * np.array(rotate(matrix_from_euler(attitude), (u, v, w)))
        yaw_rate = (r * math.cos(attitude.phi) + q * math.sin(attitude.phi)) / math.cos(attitude.theta)
        self.psi += STEP * yaw_rate
        for index, signals in enumerate(((u, v, w), (p, q, r))):
            a, b = self.filters[index]
            self.filtered[index] = a @ self.filtered[index] + b * np.array(signals)

    def measured(self) -> VehicleState:
        theta, phi = self.states[0][:2]
        velocity, rates = self.filtered[:, 0].tolist()
        attitude = Euler(self.psi, POINT.theta + theta, POINT.phi + phi)
        x, y, z = self.position.tolist()
        return VehicleState((x, y, z), attitude, tuple(velocity), tuple(rates))


def fly(
    bench: Bench,
    controller: ControllerFile,
    seconds: float,
    target: Vector3 = (0.0, 0.0, 0.0),
    psi: float = 0.0,
) -> np.ndarray:
    """Position, heading, pitch and roll deviation at every control tick, shape (n, 6)."""
    position = PositionController(PositionParameters())
    attitude = AttitudeController(controller, AttitudeParameters(engage_time=0.01))
    sent: list[tuple[int, np.ndarray]] = []
    track = []
    for stamp in range(0, round(seconds * 1e9), SENSOR_PERIOD_NS):
        if is_control_tick(stamp):
            odometry = odometry_values(bench.measured(), (1e-6,) * 6, (1e-6,) * 6)
            flight = flight_state_values(FlightState.FLYING, 163.0)
            position.receive("odometry", stamp, odometry)
            position.receive("reference", stamp, pose_values(target, Euler(psi, 0.0, 0.0)))
            (velocity,) = position.receive("flight_state", stamp, flight)
            attitude.receive("odometry", stamp, odometry)
            attitude.receive("flight_state", stamp, flight)
            (command,) = attitude.receive("velocity_reference", stamp, velocity.values)
            sent.append((stamp, np.array(command.values[:4]) - TRIM))
            track.append([*bench.position, bench.psi, *bench.states[0][:2]])
        if is_pwm_tick(stamp):
            acting = [value for at, value in sent if at + COMMAND_LATENCY_NS + bench.extra_delay_ns <= stamp]
            bench.pulse = acting[-1] if acting else bench.pulse
            sent = sent[-6:]
        bench.advance()
    return np.array(track)


def disturbed(bench: Bench) -> Bench:
    bench.states[0][:6] = [0.05, -0.05, 0.2, -0.2, 0.3, 0.3]
    bench.states[1][:2] = [0.2, 0.3]
    return bench


@pytest.mark.parametrize("friction", [True, False])
def test_disturbed_hover_comes_to_rest(friction: bool) -> None:
    track = fly(disturbed(Bench(friction)), LQ, 15.0)
    assert np.abs(track[-1, :3]).max() < 0.02
    assert abs(track[-1, 3]) < 0.02
    assert np.abs(track[-100:, 4:]).max() < 0.01
    assert np.abs(track[:, :2]).max() < 0.3


@pytest.mark.parametrize(("gain", "delay_ms"), [(2.0, 0.0), (0.5, 0.0), (1.0, 10.0), (1.2, 10.0)])
def test_gain_and_delay_margins_hold(gain: float, delay_ms: float) -> None:
    bench = disturbed(Bench(gain=gain, extra_delay_ns=round(delay_ms * 1e6)))
    track = fly(bench, LQ, 12.0)
    assert np.abs(track[-200:, 4:]).max() < 0.02
    assert np.abs(track[-1, :3]).max() < 0.05


def test_static_gains_have_less_margin() -> None:
    """Why the shipped controller is designed with the delay: static gains do not bear 6 dB."""
    static = design_lq(MODEL, LqWeights(command_delay=0.0))
    assert np.abs(fly(disturbed(Bench(gain=2.0)), LQ, 4.0)[-100:, 4:]).max() < 0.03
    oscillating = fly(disturbed(Bench(gain=2.0)), static, 4.0)
    assert np.abs(oscillating[-100:, 4:]).max() > 0.03


@pytest.mark.parametrize("axis", [0, 1])
def test_position_step(axis: int) -> None:
    target = [0.0, 0.0, 0.0]
    target[axis] = 0.3
    track = fly(Bench(), LQ, 15.0, (target[0], target[1], target[2]))
    along, across = track[:, axis], track[:, 1 - axis]
    assert np.argmax(along > 0.27) < 200
    assert along.max() < 0.3 * 1.1
    assert np.abs(along[600:] - 0.3).max() < 0.02
    assert np.abs(across).max() < 0.05
    assert np.abs(track[:, 4:]).max() < math.radians(10.0)


def test_height_and_heading_steps_without_upset() -> None:
    track = fly(Bench(), LQ, 12.0, (0.0, 0.0, -0.2), 0.3)
    assert track[-1, 2] == pytest.approx(-0.2, abs=0.05)
    assert track[-1, 3] == pytest.approx(0.3, abs=0.03)
    assert np.abs(track[:, :2]).max() < 0.1


def test_other_weights_fly_too() -> None:
    weights = replace(LqWeights(), u=4.0, v=2.0)
    track = fly(disturbed(Bench()), design_lq(MODEL, weights), 15.0)
    assert np.abs(track[-1, :3]).max() < 0.03
