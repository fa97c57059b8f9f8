"""Induced velocity, drive and drag: by hand, and at the borders of their regimes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_bench_sim import airframe, drive, inflow
from heli_bench_sim.parameters import constants, thesis
from heli_bench_sim.states import State
from heli_bench_sim.trim import trim
from heli_bench_sim.validity import violations

P = thesis()
C = constants(P)
WEIGHT = 7.3 * 9.81
HOVER = math.sqrt(WEIGHT / (2.0 * 1.2056 * math.pi * 0.725**2))


def test_hover_inflow_by_hand() -> None:
    assert pytest.approx(4.241, abs=0.02) == HOVER  # source Table 2.3
    assert inflow.steady_inflow(WEIGHT, 0.0, C) == pytest.approx(HOVER, rel=1e-14)
    assert inflow.rate(HOVER - 0.3, WEIGHT, 0.0, C) == pytest.approx(0.3 / 0.15, rel=1e-12)
    tail = math.sqrt(6.842 / (2.0 * 1.2056 * math.pi * 0.15**2))
    assert inflow.tail_rate(tail - 0.2, 6.842, C) == pytest.approx(0.2 / 0.10, rel=1e-12)


@settings(deadline=None, max_examples=40)
@given(thrust=st.floats(-50.0, 150.0), w_a=st.floats(-10.0, 30.0))
def test_hover_and_climb_follow_the_source_s_linear_law(thrust: float, w_a: float) -> None:
    hover = HOVER * thrust / WEIGHT
    steady = inflow.steady_inflow(thrust, w_a, C)
    if w_a <= 0.5 * hover or thrust <= 0.0:
        assert steady == pytest.approx(hover, rel=1e-12, abs=1e-12)
    assert math.isfinite(steady)
    assert abs(steady) <= 2.5 * abs(hover) + 1e-12


def test_steady_inflow_is_continuous_over_all_regimes() -> None:
    descent = np.linspace(0.0, 5.0 * HOVER, 20001)  # steepest where the windmill branch begins
    steady = np.array([inflow.steady_inflow(WEIGHT, w, C) for w in descent])
    assert np.abs(np.diff(steady)).max() < 25.0 * (descent[1] - descent[0])


def test_branches_are_momentum_theory() -> None:
    """Eq. 2.24: V (V - w) = V_h^2 at the full ring; eq. 2.25: V (w - V) = V_h^2 well beyond 2 V_h."""
    ring = inflow.steady_inflow(WEIGHT, HOVER, C)
    assert ring * (ring - HOVER) == pytest.approx(HOVER**2, rel=1e-12)
    fast = 4.0 * HOVER
    mill = inflow.steady_inflow(WEIGHT, fast, C)
    assert mill * (fast - mill) == pytest.approx(HOVER**2, rel=1e-2)
    assert mill < HOVER < ring


def test_vanishing_thrust_in_a_fast_descent_is_finite() -> None:
    assert inflow.steady_inflow(5e-324, 20.0, C) == pytest.approx(0.0, abs=1e-9)


def test_validity_flags() -> None:
    point = trim(P)
    state, inputs = point.state, point.inputs

    def flags(**change: float) -> set[str]:
        moved = state.copy()
        for name, value in change.items():
            moved[State[name]] = value
        return {violation.name for violation in violations(moved, inputs, np.zeros(3), C)}

    assert flags() == set()
    assert flags(w=1.0) == set()
    assert "vortex_ring" in flags(w=3.5)
    assert "windmill" in flags(w=30.0)
    assert flags(Omega=10.0) == {"underspeed"}
    assert "stall" in flags(V_i=-5.0)


def test_a_violation_names_quantity_value_and_bound() -> None:
    point = trim(P)
    state = point.state
    state[State.Omega] = 10.0
    (violation,) = violations(state, point.inputs, np.zeros(3), C)
    assert violation.bound == pytest.approx(0.2 * 163.363)
    assert str(violation) == "underspeed: rotor speed [rad/s] 10 is below 32.7"


def test_current_by_hand_and_its_limits() -> None:
    omega = 163.363
    assert drive.current(5.5, omega, C) == pytest.approx((22.0 - 0.0150 * 8.0 * omega) / 0.0467, rel=1e-12)
    assert drive.current(10.0, 0.0, C) == 60.0
    assert drive.current(0.0, omega, C) == 0.0
    assert drive.current(50.0, 330.0, C) == pytest.approx((40.0 - 0.12 * 330.0) / 0.0467, rel=1e-9)


def test_drive_inertia_and_acceleration_by_hand() -> None:
    inertia = 0.066446 + 0.001707 + 16.0 * 0.934e-4 + 64.0 * 1.2e-4
    gained = drive.rotor_acceleration(0.8, 6.0, 0.1, C)
    assert gained == pytest.approx((6.4 - 6.0 - 0.4) / inertia, abs=1e-12)
    assert drive.rotor_acceleration(0.9, 6.0, 0.1, C) == pytest.approx(0.8 / inertia, rel=1e-12)
    assert drive.torque_rate(0.8, 55.0, C) == pytest.approx((0.825 - 0.8) / 0.0134, rel=1e-9)


def test_drag_by_hand_and_against_the_motion() -> None:
    assert airframe.drag(5.0, 0.0, 0.0, C)[0] == pytest.approx(-0.5 * 1.2056 * 0.166 * 25.0, rel=1e-12)
    force = np.array(airframe.drag(1.0, -2.0, 3.0, C))
    assert np.cross(force, [1.0, -2.0, 3.0]) == pytest.approx(np.zeros(3), abs=1e-12)
    assert airframe.drag(0.0, 0.0, 0.0, C) == (0.0, 0.0, 0.0)
