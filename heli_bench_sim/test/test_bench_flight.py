"""A whole flight in closed loop: run-up on the skids, take-off, hover, landing, run-down.

The controller is an ideal state feedback written here from the linear model alone; it shows that the bench
can be flown, not how.
"""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_are

from heli_bench_sim.bench import Bench, BenchParameters
from heli_bench_sim.linearize import linearize
from heli_bench_sim.parameters import PARAMETER_SETS, HelicopterParameters
from heli_bench_sim.states import Input, State
from heli_bench_sim.trim import Trim, trim
from heli_common.timing import is_control_tick, is_pwm_tick

Array = NDArray[np.float64]

LOW_PITCH = np.array([0.0, 0.0, 0.03, 0.06])
"""B_1s, A_1s, theta_0, theta_t while the helicopter stands on its skids [rad]."""

STATE_SCALE = np.array([0.2] * 8 + [1.0, 1.0, 1.0, 1.0, 0.2, 1.0, 5.0, 1.0, 1.0, 1.0])
INPUT_SCALE = np.array([0.02, 0.02, 0.02, 0.25, 2.0])
"""Source Table 2.4."""


def feedback(parameters: HelicopterParameters, point: Trim) -> Array:
    model = linearize(parameters, point)
    weighted = {"x", "y", "z", "psi", "u", "v", "w", "r", "Omega"}
    share = [1.0 if name in weighted else 0.01 for name in model.states]
    state_weight = np.diag(np.array(share) / STATE_SCALE**2)
    input_weight = np.diag(4.0 / INPUT_SCALE**2)
    riccati = solve_continuous_are(model.A, model.B, state_weight, input_weight)
    return np.asarray(np.linalg.solve(input_weight, model.B.T @ riccati))


@dataclass(repr=False)
class Log:
    time: list[float] = field(default_factory=list)
    position: list[tuple[float, float, float]] = field(default_factory=list)
    attitude: list[tuple[float, float, float]] = field(default_factory=list)
    speed: list[float] = field(default_factory=list)
    current: list[float] = field(default_factory=list)
    normal: list[float] = field(default_factory=list)

    def add(self, bench: Bench) -> None:
        self.time.append(bench.stamp_ns * 1e-9)
        self.position.append(bench.position)
        self.attitude.append(bench.attitude)
        self.speed.append(bench.rotor_speed)
        self.current.append(bench.actuator_state().motor_current)
        self.normal.append(bench.normal_force)

    def between(self, begin: float, end: float) -> dict[str, Array]:
        chosen = slice(*np.searchsorted(self.time, [begin, end]))
        return {
            name: np.array(getattr(self, name)[chosen])
            for name in ("position", "attitude", "speed", "current", "normal")
        }


RUN_UP, TAKE_OFF, HOVER, DESCENT, END = 0.0, 6.0, 11.0, 16.0, 26.0
TOUCH_DOWN = 0.445
"""NED z from which the helicopter stands on the stop [m]."""


def fly(parameters: HelicopterParameters) -> Log:
    point = trim(parameters)
    gain, level = feedback(parameters, point), point.state
    bench, log = Bench(BenchParameters(helicopter=parameters)), Log()
    servo, integral, landed = LOW_PITCH, 0.0, math.inf
    while (time := bench.stamp_ns * 1e-9) < END:
        if is_control_tick(bench.stamp_ns):
            error = point.Omega - bench.rotor_speed
            if time < TAKE_OFF or time > landed + 1.0:
                asked = 0.3 * error + integral
                target = 0.0 if time > landed + 1.0 else asked
                if 0.0 < asked < 8.0:
                    integral += 0.3 * error * 0.01
                servo, voltage = LOW_PITCH, min(max(target, 0.0), 8.0)
            else:
                down = min(max(time - TAKE_OFF, 0.0) / 4.0, 1.0)
                height = 0.45 * (1.0 - down) + max(time - DESCENT, 0.0) * 0.15
                wanted = level.copy()
                wanted[State.z] = min(height, 0.47)
                change = np.clip(-gain @ (bench.state - wanted), -5.0 * INPUT_SCALE, 5.0 * INPUT_SCALE)
                if time > DESCENT and bench.position[2] > TOUCH_DOWN:
                    landed = min(landed, time)
                flying = min(max(time - TAKE_OFF, 0.0), 1.0) - min(max(time - landed, 0.0), 1.0)
                inputs = point.inputs + change
                servo = LOW_PITCH + max(flying, 0.0) * (inputs[: Input.U_mot] - LOW_PITCH)
                voltage = float(inputs[Input.U_mot])
            bench.set_motor_voltage(voltage)
            log.add(bench)
        if is_pwm_tick(bench.stamp_ns):
            bench.set_servo_command(*servo)
        bench.advance()
        assert bench.is_finite
    return log


@pytest.fixture(scope="module", params=sorted(PARAMETER_SETS))
def flight(request: pytest.FixtureRequest) -> Log:
    return fly(PARAMETER_SETS[request.param]())


def test_run_up_takes_a_few_seconds_and_the_skids_hold(flight: Log) -> None:
    run_up = flight.between(RUN_UP, TAKE_OFF)
    reached = int(np.argmax(run_up["speed"] > 0.98 * 163.363)) * 0.01
    assert 1.5 < reached < 4.0
    assert run_up["speed"][-1] == pytest.approx(163.363, rel=0.01)
    assert run_up["speed"].max() < 1.05 * 163.363
    assert run_up["normal"].min() > 30.0
    assert np.abs(run_up["position"][:, :2]).max() < 0.01
    assert np.degrees(np.abs(run_up["attitude"][:, 1:])).max() < 1.0
    assert np.degrees(np.abs(run_up["attitude"][:, 0])).max() < 5.0


def test_it_lifts_off_and_climbs_without_dragging_sideways(flight: Log) -> None:
    climb = flight.between(TAKE_OFF, HOVER)
    assert climb["normal"][-1] == 0.0
    assert np.abs(climb["position"][:, :2]).max() < 0.10
    assert np.degrees(np.abs(climb["attitude"])).max() < 12.0


def test_it_hovers_at_the_trim_current(flight: Log) -> None:
    hover = flight.between(HOVER + 3.0, DESCENT)
    assert np.abs(hover["position"]).max() < 0.02
    assert np.degrees(np.abs(hover["attitude"][:, 0])).max() < 0.5
    assert hover["speed"] == pytest.approx(163.363, rel=2e-3)
    assert hover["current"].mean() == pytest.approx(54.6, abs=0.4)
    assert hover["current"].max() < 60.0


def test_it_lands_and_settles(flight: Log) -> None:
    ground = flight.between(END - 1.0, END)
    assert ground["normal"] == pytest.approx(7.3 * 9.81, rel=0.2)
    assert ground["position"][:, 2] == pytest.approx(0.45, abs=2e-3)
    assert np.abs(ground["position"][:, :2]).max() < 0.05
    assert np.degrees(np.abs(ground["attitude"][:, 1:])).max() < 1.0
    assert np.ptp(ground["position"], axis=0).max() < 1e-3
    assert ground["speed"][-1] < ground["speed"][0] < 125.0
    touching = flight.between(DESCENT, END)
    assert touching["normal"].max() < 4.0 * 7.3 * 9.81
