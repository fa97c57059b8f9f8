"""Friction of the rig: by hand, against the motion, and found again in the linear model's derivatives."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_bench_sim.arm_friction import (
    NO_ARM_FRICTION,
    ArmFrictionParameters,
    arm_friction_constants,
    gimbal_friction,
    platform_friction,
)
from heli_bench_sim.bench import Bench
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.parameters import thesis
from heli_bench_sim.states import State
from heli_bench_sim.trim import trim

F = arm_friction_constants(ArmFrictionParameters())
SPEED = st.floats(-3.0, 3.0)


def test_by_hand_at_one_metre_a_second() -> None:
    north, east, down = platform_friction(1.0, 0.0, 0.0, F)
    assert north == pytest.approx(-(7.7 + 0.2), abs=1e-5)
    assert (east, down) == (0.0, 0.0)
    assert platform_friction(0.0, -1.0, 0.0, F)[1] == pytest.approx(8.6 + 0.2, abs=1e-5)
    assert platform_friction(0.0, 0.0, 2.0, F)[2] == pytest.approx(-(10.0 + 0.2), abs=1e-5)
    assert gimbal_friction(1.0, F) == pytest.approx(-0.005, rel=1e-3)


@settings(deadline=None, max_examples=100)
@given(SPEED, SPEED, SPEED)
def test_friction_takes_energy_and_is_odd(north: float, east: float, down: float) -> None:
    force = platform_friction(north, east, down, F)
    assert force[0] * north + force[1] * east + force[2] * down <= 0.0
    assert platform_friction(-north, -east, -down, F) == tuple(-part for part in force)
    assert gimbal_friction(north, F) * north <= 0.0


def test_none_is_none() -> None:
    none = arm_friction_constants(NO_ARM_FRICTION)
    assert platform_friction(1.0, 2.0, 3.0, none) == (0.0, 0.0, 0.0)
    assert gimbal_friction(1.0, none) == 0.0


def slowed(friction: ArmFrictionParameters) -> float:
    """Loss of forward speed [m/s] in the first 2.5 ms of drifting forward at 1 m/s in trim."""
    bench = Bench(BenchParameters(friction=friction))
    point = trim(thesis())
    state = point.state
    state[State.u] = 1.0
    bench.place(state, point.inputs)
    before = bench.velocity
    bench.advance()
    return before[0] - bench.velocity[0]


def test_it_is_the_sources_speed_damping() -> None:
    # X_u = -(viscous + Coulomb at 1 m/s) / m; the source identified -1.07 (Table 2.6)
    difference = (slowed(ArmFrictionParameters()) - slowed(NO_ARM_FRICTION)) / 2.5e-3
    mass = thesis().mass
    assert difference == pytest.approx((7.7 + 0.2) / mass, rel=0.01)
    assert 7.7 / mass == pytest.approx(1.07, abs=0.02)
    assert 8.6 / mass == pytest.approx(1.19, abs=0.02)
    assert math.isfinite(difference)
    assert np.isfinite(slowed(NO_ARM_FRICTION))
