"""Servos: mixing both ways, limits and their rule, pulse resolution, motion."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from heli_bench_sim.servos import (
    ServoParameters,
    mix,
    reach_shafts,
    require_finite_command,
    servo_constants,
    shaft_acceleration,
    unmix,
)

P = ServoParameters()
C = servo_constants(P)
DEG = math.pi / 180.0
Array = NDArray[np.float64]


class ServoCommand(NamedTuple):
    shafts: tuple[float, ...]
    saturated: bool


def command_shafts(b_1s: float, a_1s: float, theta_0: float, theta_t: float) -> ServoCommand:
    """As the bench does with a command."""
    require_finite_command((b_1s, a_1s, theta_0, theta_t))
    shafts = np.empty(4)
    saturated = reach_shafts(b_1s, a_1s, theta_0, theta_t, C, shafts)
    return ServoCommand(tuple(shafts.tolist()), bool(saturated))


def mixed(b_1s: float, a_1s: float, theta_0: float, theta_t: float) -> Array:
    out = np.empty(4)
    mix(b_1s, a_1s, theta_0, theta_t, C, out)
    return out


def unmixed(shafts: Array) -> Array:
    return np.array(unmix(shafts, 0, C))


def test_mixing_by_hand() -> None:
    """delta_i = 6 (theta_0 - 6 deg) + 6 (B_1s cos psi_i + A_1s sin psi_i), tail 4 (theta_t - 10 deg)."""
    assert mixed(0.0, 0.0, 6 * DEG, 10 * DEG) == pytest.approx(np.zeros(4), abs=1e-15)
    assert mixed(2 * DEG, 0.0, 8 * DEG, 12 * DEG) / DEG == pytest.approx([24.0, 6.0, 6.0, 8.0])
    root = math.sqrt(3.0)
    assert mixed(0.0, 1 * DEG, 6 * DEG, 10 * DEG) / DEG == pytest.approx([0.0, 3 * root, -3 * root, 0.0])


def test_ends_of_the_shafts_give_the_ranges_of_the_blades() -> None:
    end = 60 * DEG
    assert unmixed(np.full(4, end))[2:] / DEG == pytest.approx([16.0, 25.0])
    assert unmixed(np.full(4, -end))[2:] / DEG == pytest.approx([-4.0, -5.0])
    assert mixed(10 * DEG, 0.0, 6 * DEG, 10 * DEG)[0] == pytest.approx(end)


ANGLE = st.floats(-0.2, 0.2)


@settings(deadline=None, max_examples=50)
@given(ANGLE, ANGLE, st.floats(-0.1, 0.3), st.floats(-0.1, 0.45))
def test_unmixing_undoes_mixing(b_1s: float, a_1s: float, theta_0: float, theta_t: float) -> None:
    assert unmixed(mixed(b_1s, a_1s, theta_0, theta_t)) == pytest.approx(
        [b_1s, a_1s, theta_0, theta_t], abs=1e-14
    )


@settings(deadline=None, max_examples=50)
@given(st.lists(st.floats(-1.05, 1.05), min_size=4, max_size=4))
def test_mixing_undoes_unmixing(shafts: list[float]) -> None:
    assert mixed(*unmixed(np.array(shafts))) == pytest.approx(shafts, abs=1e-14)


def test_reachable_command_comes_through_to_half_a_pulse_step() -> None:
    command = command_shafts(1 * DEG, -2 * DEG, 9.7 * DEG, 11.1 * DEG)
    assert not command.saturated
    wanted = mixed(1 * DEG, -2 * DEG, 9.7 * DEG, 11.1 * DEG)
    assert np.abs(np.array(command.shafts) - wanted).max() <= 0.5 * 0.12 * DEG + 1e-12
    steps = np.array(command.shafts) / (0.12 * DEG)
    assert steps == pytest.approx(np.rint(steps), abs=1e-9)


@settings(deadline=None, max_examples=100)
@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(-0.3, 0.5), st.floats(-0.5, 0.8))
def test_limits_keep_collective_and_direction(
    b_1s: float, a_1s: float, theta_0: float, theta_t: float
) -> None:
    command = command_shafts(b_1s, a_1s, theta_0, theta_t)
    shafts = np.array(command.shafts)
    assert np.abs(shafts).max() <= 60 * DEG + 1e-12
    step = 0.12 * DEG
    reached = unmixed(shafts)
    assert reached[2] == pytest.approx(min(max(theta_0, -4 * DEG), 16 * DEG), abs=step / 6)
    assert reached[3] == pytest.approx(min(max(theta_t, -5 * DEG), 25 * DEG), abs=step / 4)
    size = math.hypot(b_1s, a_1s)
    across = reached[0] * a_1s - reached[1] * b_1s
    assert abs(across) <= step / 4 * size + 1e-12
    assert math.hypot(reached[0], reached[1]) <= size + step / 4
    if not command.saturated:
        assert reached == pytest.approx([b_1s, a_1s, theta_0, theta_t], abs=step / 4)
    else:
        ideal = mixed(b_1s, a_1s, theta_0, theta_t)
        assert np.abs(ideal).max() > 60 * DEG
        kept_level = -4 * DEG < theta_0 < 16 * DEG and np.abs(ideal[:3]).max() > 60 * DEG
        if kept_level:  # the servo worst off stands at its end: nothing is given away
            assert np.abs(shafts[:3]).max() == pytest.approx(60 * DEG, abs=step)


def test_six_degrees_of_cyclic_remain_at_hover() -> None:
    assert not command_shafts(6.25 * DEG, 0.0, 9.689 * DEG, 11.1 * DEG).saturated
    assert command_shafts(6.4 * DEG, 0.0, 9.689 * DEG, 11.1 * DEG).saturated


def test_tail_alone_saturates_without_touching_the_swash_plate() -> None:
    command = command_shafts(0.01, 0.02, 0.15, 0.6)
    assert command.saturated
    assert command.shafts[:3] == command_shafts(0.01, 0.02, 0.15, 0.2).shafts[:3]


@pytest.mark.parametrize(("place", "name"), [(0, "B_1s"), (1, "A_1s"), (2, "theta_0"), (3, "theta_t")])
def test_command_that_is_no_number_is_named(place: int, name: str) -> None:
    values = [0.0, 0.0, 0.1, 0.1]
    values[place] = math.inf
    with pytest.raises(ValueError, match=f"{name} is inf"):
        command_shafts(*values)


def respond(command: float, duration: float) -> Array:
    step = 1e-4
    angle, rate, path = 0.0, 0.0, []
    for _ in range(round(duration / step)):
        middle = rate + 0.5 * step * shaft_acceleration(angle, rate, command, C)
        rate += step * shaft_acceleration(angle + 0.5 * step * rate, middle, command, C)
        angle += step * middle
        path.append((angle, rate))
    return np.array(path)


def test_small_step_is_the_second_order_step_response() -> None:
    """Overshoot exp(-pi zeta / sqrt(1 - zeta^2)) = 4.6 % at pi / (omega sqrt(1 - zeta^2))."""
    path = respond(0.01, 0.08)[:, 0] / 0.01
    assert path.max() == pytest.approx(1.0 + math.exp(-math.pi * 0.7 / math.sqrt(0.51)), abs=1e-3)
    peak = (np.argmax(path) + 1) * 1e-4
    assert peak == pytest.approx(math.pi / (2.0 * math.pi * 25.0 * math.sqrt(0.51)), rel=0.02)
    assert path[-1] == pytest.approx(1.0, abs=2e-3)


def test_servo_is_exactly_linear_inside_its_rate_limit() -> None:
    omega = 2.0 * math.pi * 25.0
    expected = omega**2 * (0.03 - 0.01) - 2.0 * 0.7 * omega * 2.0
    assert shaft_acceleration(0.01, 2.0, 0.03, C) == pytest.approx(expected, rel=1e-12)


def test_large_step_runs_at_the_rate_limit() -> None:
    path = respond(1.0, 0.2)
    assert path[:, 1].max() <= 500 * DEG * (1.0 + 1e-9)
    assert path[400, 1] == pytest.approx(500 * DEG, rel=1e-3)
    assert path[-1, 0] == pytest.approx(1.0, abs=5e-3)
