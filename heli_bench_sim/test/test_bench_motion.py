"""The bench: at rest, commands and readings, homing, step size, batches, ends of travel."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from heli_bench_sim import bench as bench_module
from heli_bench_sim.bench import REFINEMENT, Bench, BenchParameters
from heli_bench_sim.bench_parameters import bench_constants
from heli_bench_sim.motion import (
    AIR_SIZE,
    BENCH_STATE_SIZE,
    COMMAND_SIZE,
    WORK_ROWS,
    BenchState,
    advance_batch,
)
from heli_bench_sim.parameters import thesis
from heli_bench_sim.states import State
from heli_bench_sim.trim import trim
from heli_common.records import boxed
from heli_common.timing import SENSOR_PERIOD

Array = NDArray[np.float64]
HOVER = trim(thesis())


def work() -> Array:
    return np.empty((WORK_ROWS, BENCH_STATE_SIZE))


def run(bench: Bench, seconds: float) -> None:
    for _ in range(round(seconds / SENSOR_PERIOD)):
        bench.advance()


def hovering(**changes: float) -> Bench:
    bench = Bench()
    state = HOVER.state
    for name, value in changes.items():
        state[State[name]] = value
    bench.place(state, HOVER.inputs)
    return bench


def test_state_layout_has_no_gaps() -> None:
    places = [BenchState.shaft + k for k in range(4)] + [BenchState.shaft_rate + k for k in range(4)]
    places += [BenchState.bristle_north, BenchState.bristle_east, BenchState.bristle_yaw]
    assert sorted(places) == list(range(len(State), BENCH_STATE_SIZE))


def test_bench_begins_at_rest_and_stays_there() -> None:
    bench = Bench()
    run(bench, 1.0)
    assert bench.stamp_ns == 1_000_000_000
    assert bench.position == pytest.approx((0.0, 0.0, 0.45), abs=1e-9)
    assert bench.attitude == (0.0, 0.0, 0.0)
    assert np.abs([*bench.velocity, *bench.rates]).max() < 1e-9
    assert bench.rotor_speed == 0.0
    assert bench.on_stop
    assert bench.normal_force == pytest.approx(7.3 * 9.81, rel=1e-6)
    assert bench.encoder_reading().counts.tolist() == [0] * 6
    assert [violation.name for violation in bench.violations] == ["underspeed"]


def test_commands_reach_the_blades() -> None:
    bench = Bench()
    assert not bench.set_servo_command(0.02, -0.03, 0.1, 0.2)
    run(bench, 0.25)
    actuators = bench.actuator_state()
    assert actuators.angles == pytest.approx((0.02, -0.03, 0.1, 0.2), abs=4e-4)
    assert actuators.angle_rates == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=1e-6)
    assert not actuators.saturated
    assert bench.set_servo_command(0.5, 0.0, 0.1, 0.2)
    assert bench.actuator_state().saturated
    bench.set_motor_voltage(3.0)
    run(bench, 0.25)
    actuators = bench.actuator_state()
    assert actuators.motor_current == 60.0
    assert actuators.motor_torque == pytest.approx(0.9, rel=1e-3)
    assert actuators.motor_speed == pytest.approx(8.0 * bench.rotor_speed)


def test_angle_rates_are_the_slope_of_the_angles() -> None:
    bench = Bench()
    bench.set_servo_command(0.02, -0.03, 0.05, 0.1)
    run(bench, 0.02)
    before, rates = bench.actuator_state().angles, bench.actuator_state().angle_rates
    bench.advance()
    slope = (np.array(bench.actuator_state().angles) - before) / SENSOR_PERIOD
    mean = 0.5 * (np.array(rates) + bench.actuator_state().angle_rates)
    assert slope == pytest.approx(mean, rel=0.05, abs=0.02)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_commands_that_are_no_numbers_are_refused_and_change_nothing(bad: float) -> None:
    bench = Bench()
    before = bench.command
    with pytest.raises(ValueError, match="theta_0"):
        bench.set_servo_command(0.0, 0.0, bad, 0.0)
    with pytest.raises(ValueError, match="motor voltage"):
        bench.set_motor_voltage(bad)
    with pytest.raises(ValueError, match="wind"):
        bench.set_wind((0.0, bad, 0.0))
    assert (bench.command == before).all()


def test_readings_are_copies() -> None:
    bench = Bench()
    for reading in (bench.state, bench.whole_state, bench.command):
        reading[:] = 7.0
    assert bench.rotor_speed == 0.0
    assert bench.command.max() < 1.0


def test_placing_refuses_what_is_no_state() -> None:
    bench = Bench()
    with pytest.raises(ValueError, match="18 finite"):
        bench.place(np.zeros(17), HOVER.inputs)
    with pytest.raises(ValueError, match="5 finite"):
        bench.place(HOVER.state, np.full(5, np.nan))
    far = HOVER.state
    far[State.z] = -3.0
    with pytest.raises(ValueError, match="reach"):
        bench.place(far, HOVER.inputs)


def test_placed_at_trim_it_hovers() -> None:
    bench = hovering()
    run(bench, 1.0)
    assert bench.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert bench.rotor_speed == pytest.approx(163.363, rel=1e-9)
    assert bench.actuator_state().motor_current == pytest.approx(HOVER.I_motor, rel=1e-9)
    assert bench.violations == ()
    assert not bench.on_stop


def test_homing_takes_every_encoder_over_its_index_and_sets_down_gently() -> None:
    bench = Bench()
    rest = np.array([*np.radians([29.016] * 3), 0.0, 0.0, 0.0])
    highest, lowest, angles = np.zeros(6), np.zeros(6), np.zeros(6)
    bench.set_homing(True)
    seconds = 0.0
    while bench.homing:
        bench.advance()
        bench.set_homing(True)  # told again at every control tick, it must not begin anew
        seconds += SENSOR_PERIOD
        angles = bench._shaft_angles() - rest
        highest, lowest = np.maximum(highest, angles), np.minimum(lowest, angles)
        assert bench.normal_force < 2.0 * 7.3 * 9.81
    assert seconds == pytest.approx(7.1, abs=0.01)
    assert (highest >= math.radians(8.0)).all()
    assert (lowest[3:] <= -math.radians(8.0)).all()
    assert np.degrees(highest).max() < 12.0
    reading = bench.encoder_reading()
    assert reading.indexed.all()
    run(bench, 0.5)
    assert bench.position == pytest.approx((0.0, 0.0, 0.45), abs=1e-4)
    assert bench.attitude == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)
    assert bench.encoder_reading().angle == pytest.approx(rest, abs=math.radians(0.09) + 1e-4)
    bench.set_homing(False)
    assert not bench.homing


def test_homing_brings_a_misplaced_helicopter_back_to_the_middle() -> None:
    bench = Bench()
    away = np.zeros(len(State))
    away[[State.x, State.y, State.z, State.psi]] = 0.3, -0.2, 0.45, 1.0
    bench.place(away, np.zeros(5))
    bench.set_homing(True)
    run(bench, 7.6)
    assert bench.encoder_reading().indexed.all()
    assert bench.position == pytest.approx((0.0, 0.0, 0.45), abs=2e-3)
    assert bench.attitude == pytest.approx((0.0, 0.0, 0.0), abs=0.01)


def test_hand_that_lets_go_half_way_drops_it_on_the_stop() -> None:
    bench = Bench()
    bench.set_homing(True)
    run(bench, 3.0)
    assert bench.position[2] < 0.2
    bench.set_homing(False)
    run(bench, 2.0)
    assert bench.position == pytest.approx((0.0, 0.0, 0.45), abs=1e-3)
    assert np.abs([*bench.velocity, *bench.rates]).max() < 1e-3


def test_nobody_reaches_into_a_turning_rotor() -> None:
    bench = hovering()
    with pytest.raises(ValueError, match=r"163\.4 rad/s"):
        bench.set_homing(True)


def respond(refinement: int, monkeypatch: pytest.MonkeyPatch) -> Array:
    """10 s of open-loop flight from trim, shaken by the cyclic for 4 s."""
    monkeypatch.setattr(bench_module, "REFINEMENT", refinement)
    bench, path = hovering(), []
    b_1s, a_1s, theta_0, theta_t, voltage = HOVER.inputs[[0, 1, 2, 3, 4]]
    bench.set_motor_voltage(voltage)
    for tick in range(4000):
        if tick % 8 == 2:
            time = tick * SENSOR_PERIOD
            shaking = time < 4.0
            ahead = 0.0045 * np.sign(np.sin(2.0 * math.pi * time)) if shaking else 0.0
            aside = 0.003 * np.sign(np.sin(2.0 * math.pi * time / 0.7)) if shaking else 0.0
            bench.set_servo_command(b_1s + ahead, a_1s + aside, theta_0, theta_t)
        bench.advance()
        path.append(bench.position)
    return np.array(path)


def test_half_the_step_changes_ten_seconds_of_flight_by_less_than_a_tenth_of_a_millimetre(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chosen, halved = respond(REFINEMENT, monkeypatch), respond(2 * REFINEMENT, monkeypatch)
    assert np.ptp(chosen[:, 0]) > 0.2
    assert np.abs(chosen - halved).max() < 1e-4


def test_integration_is_of_fourth_order() -> None:
    """Smooth free flight: half the step, a sixteenth of the error."""
    box = boxed(bench_constants(BenchParameters()))
    begin = hovering(u=0.5, q=0.3, p=-0.2).whole_state
    command = hovering().command

    def flown(steps: int) -> Array:
        states = begin[np.newaxis].copy()
        advance_batch(states, command[np.newaxis], np.zeros((1, AIR_SIZE)), 0.2, steps, box, work())
        return np.asarray(states[0])

    exact = flown(4096)
    coarse, fine = (np.abs(flown(steps) - exact).max() for steps in (64, 128))
    assert coarse / fine == pytest.approx(16.0, rel=0.2)


def test_batch_equals_single_benches_bit_by_bit() -> None:
    box = boxed(bench_constants(BenchParameters()))
    benches = [hovering(u=0.1 * k, phi=0.05 * k, z=-0.1 * k) for k in range(3)]
    airs = np.array([[0.0, 0.0, 0.0, 0.0], [-2.0, 0.5, 0.0, 0.0], [1.0, 0.0, -0.3, 0.0]])
    states = np.array([bench.whole_state for bench in benches])
    commands = np.array([bench.command for bench in benches])
    assert commands.shape == (3, COMMAND_SIZE)
    for bench, air in zip(benches, airs, strict=True):
        bench.set_wind(tuple(air[:3]))
    for _ in range(200):
        advance_batch(states, commands, airs, SENSOR_PERIOD, REFINEMENT, box, work())
        for bench in benches:
            bench.advance()
    for row, bench in zip(states, benches, strict=True):
        assert row.tobytes() == bench.whole_state.tobytes()


def test_two_benches_do_the_same_to_the_last_bit() -> None:
    first, second = Bench(seed=1), Bench(seed=1)
    for bench in (first, second):
        bench.set_servo_command(0.01, 0.0, 0.05, 0.1)
        bench.set_motor_voltage(2.0)
        run(bench, 0.5)
    assert first.whole_state.tobytes() == second.whole_state.tobytes()


@pytest.mark.parametrize("push", ["u", "v", "w", "p", "q", "r"])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_stops_hold_a_runaway_helicopter(push: str, sign: float) -> None:
    """Thrown hard in each direction, rotor on, nobody at the controls: it stays in the cage, finite."""
    bench = hovering(**{push: sign * (2.0 if push in "uvw" else 3.0)})
    for _ in range(2000):
        bench.advance()
        north, east, down = bench.position
        assert math.hypot(north, east) < 0.6
        assert -0.42 < down < 0.49
        assert np.abs(np.degrees(bench.attitude[1:])).max() < 40.0
        assert abs(math.degrees(bench.attitude[0])) < 180.0
    assert bench.is_finite


def test_dead_helicopter_dropped_from_the_centre_comes_to_rest() -> None:
    bench = Bench()
    bench.place(np.zeros(len(State)), np.zeros(5))
    run(bench, 3.0)
    assert bench.position == pytest.approx((0.0, 0.0, 0.45), abs=1e-6)
    assert np.abs([*bench.velocity, *bench.rates]).max() < 1e-6


def test_meaningless_motion_is_told_and_leaves_the_encoders_alone() -> None:
    bench = hovering()
    before = bench.encoder_reading().counts
    bench._state[State.u] = math.nan
    bench.advance()
    assert not bench.is_finite
    assert (bench.encoder_reading().counts == before).all()
