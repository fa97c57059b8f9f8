"""H force in the torque: by hand, and against blade elements summed over azimuth and radius."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from heli_bench_sim import rotor
from heli_bench_sim.h_force import (
    HForceConstants,
    HForceParameters,
    h_force_constants,
    h_force_per_speed,
    h_force_torque,
    section_drag,
)
from heli_bench_sim.parameters import constants, thesis
from heli_common.compiled import compiled
from heli_common.records import packed

Array = NDArray[np.float64]

P = thesis()
C = constants(P)
ON = h_force_constants(HForceParameters(active=1.0), P)
OFF = h_force_constants(HForceParameters(), P)
OMEGA = P.rotor_speed
HOVER = math.radians(9.69)
K_V = 3.0 * P.radius**2 / (2.0 * (P.radius**3 - P.cutout**3))

TURN = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
"""Azimuths of the blade, from the nose to the right; a mean over them is exact up to the 15th harmonic."""
GAUSS = np.polynomial.legendre.leggauss(8)
RADII = P.cutout + 0.5 * (P.radius - P.cutout) * (GAUSS[0] + 1.0)
WEIGHTS = 0.5 * (P.radius - P.cutout) * GAUSS[1]

SPEED = st.floats(-5.0, 5.0)
TILT = st.floats(-2e-3, 2e-3)


@compiled
def torque_in_compiled_code(u_a: float, a_1: float, h: HForceConstants) -> float:
    return h_force_torque(70.0, 0.17, 163.0, 4.2, u_a, 0.0, 0.0, a_1, 0.0, h)


class Blades(NamedTuple):
    """Sums over the blade elements of both blades, mean of a turn."""

    thrust: float
    torque: float
    flow_power: float
    """lift times the induced flow through the disc [W]"""
    force: Array
    """on the rotor, body FRD [N]"""
    c_d: float


def blades(
    theta_0: float, v_i: float, velocity: tuple[float, float, float], a_1: float, b_1: float
) -> Blades:
    """Numerical twin in shaft axes: flapping blades as vectors, forces across and along the local flow.

    The blade points along b, flapped by beta so that its tip draws the disc tilted by a_1 back and b_1 right,
    and turns to the left seen from the nose (anticlockwise from above). Its cyclic pitch is solved for, such
    that the lift has no moment about the flapping hinge that repeats once a turn.
    """
    cos, sin = np.cos(TURN), np.sin(TURN)
    beta = a_1 * cos - b_1 * sin
    # azimuth falls at the rate Omega, so d/dt = -Omega d/d(azimuth)
    beta_rate = -OMEGA * (-a_1 * sin - b_1 * cos)
    zero = np.zeros_like(TURN)
    ahead = np.stack([sin, -cos, zero])
    along = np.stack([np.cos(beta) * cos, np.cos(beta) * sin, -np.sin(beta)])
    up = np.stack([-np.sin(beta) * cos, -np.sin(beta) * sin, -np.cos(beta)])
    body = np.array(velocity)
    assert np.abs(np.cross(along, ahead, axis=0)[2] + np.cos(beta)).max() < 1e-12

    across = OMEGA * np.cos(beta)[:, None] * RADII + (body @ ahead)[:, None]
    induced = K_V * v_i * RADII
    down = beta_rate[:, None] * RADII + (body @ up)[:, None] + induced
    lift_per_angle = ON.lift * across**2

    def lift(pitch: Array) -> Array:
        forces: Array = lift_per_angle * pitch[:, None] - ON.lift * down * across
        return forces

    def hinge_moment(pitch: Array) -> Array:
        moment = (lift(pitch) * RADII) @ WEIGHTS
        return np.array([np.mean(moment * cos), np.mean(moment * sin)])

    level = np.full_like(TURN, theta_0)
    rest = hinge_moment(level)
    slopes = np.column_stack([hinge_moment(level + cos) - rest, hinge_moment(level + sin) - rest])
    cyclic = np.linalg.solve(slopes, -rest)
    forces_up = lift(theta_0 + cyclic[0] * cos + cyclic[1] * sin)

    c_d = section_drag(theta_0, OMEGA, v_i, ON)
    forces_back = ON.drag * c_d * across**2 + forces_up * down / across
    lifts, drags = forces_up @ WEIGHTS, forces_back @ WEIGHTS
    arm = np.cos(beta) * ((forces_back * RADII) @ WEIGHTS)
    return Blades(
        thrust=float(lifts.mean()),
        torque=float(arm.mean()),
        flow_power=float(((forces_up * induced) @ WEIGHTS).mean()),
        force=(lifts * up - drags * ahead).mean(axis=1),
        c_d=c_d,
    )


def extra(sums: Blades, w_a: float) -> float:
    """What is left of the twin's torque without hover's profile drag and the power of lift and inflow."""
    profile = ON.drag * sums.c_d * OMEGA**2 * ON.fourth
    return sums.torque - profile - (sums.flow_power - sums.thrust * w_a) / OMEGA


def test_profile_drag_by_hand() -> None:
    """No pitch, no inflow, 4 m/s: mean of r U_T^2 over a turn has s^2 / 2 more, times r from r_0 to R."""
    second = (0.725**2 - 0.12**2) / 2.0
    expected = 2.0 * 0.4899 * 1.2056 * 0.062 * 0.01449 * second * 16.0 / 2.0
    assert expected == pytest.approx(2.17e-3, abs=1e-5)
    assert h_force_torque(0.0, 0.0, OMEGA, 0.0, 0.0, -4.0, 0.0, 0.0, 0.0, ON) == pytest.approx(
        expected, rel=1e-12
    )
    # the H force of it: c_d times the surplus of the advancing blade over the retreating one
    force = h_force_per_speed(0.0, OMEGA, 0.0, 0.0, 0.01449, ON) * 4.0
    assert force == pytest.approx(2.0 * 0.4899 * 1.2056 * 0.062 * 0.01449 * 163.363 * 4.0 * second, rel=1e-12)


def test_pull_by_hand() -> None:
    """5 m/s ahead with 70 N tilted 0.02 rad forward: 7 W more from the shaft, and the same to the right."""
    for u_a, v_a, a_1, b_1 in ((5.0, 0.0, -0.02, 0.0), (0.0, 5.0, 0.0, 0.02)):
        pulled = h_force_torque(70.0, HOVER, OMEGA, 4.2, u_a, v_a, 0.0, a_1, b_1, ON)
        carried = h_force_torque(0.0, HOVER, OMEGA, 4.2, u_a, v_a, 0.0, a_1, b_1, ON)
        assert pulled - carried == pytest.approx(7.0 / 163.363, rel=1e-12)


def test_uniform_flow_by_hand() -> None:
    """Blade to the centre, descent w only: h - profile = eta rho c a W R (lambda - theta_0 / 3) / 2."""
    whole = ON._replace(
        first=P.radius, second=P.radius**2 / 2.0, third=P.radius**3 / 3.0, fourth=P.radius**4 / 4.0
    )
    flow, pitch = 3.0, 0.15
    expected = 0.5 * ON.lift * flow * P.radius * (flow / (OMEGA * P.radius) - pitch / 3.0)
    assert h_force_per_speed(pitch, OMEGA, 0.0, -flow, 0.0, whole) == pytest.approx(expected, rel=1e-12)


@settings(deadline=None, max_examples=60)
@given(u=SPEED, v=SPEED, w=st.floats(-2.0, 2.0), theta_0=st.floats(0.05, 0.17), v_i=st.floats(0.0, 6.0))
def test_torque_of_a_level_disc_is_that_of_its_blade_elements(
    u: float, v: float, w: float, theta_0: float, v_i: float
) -> None:
    """Numerical twin; left over is the fourth order in the advance ratio."""
    sums = blades(theta_0, v_i, (u, v, w), 0.0, 0.0)
    ours = h_force_torque(sums.thrust, theta_0, OMEGA, v_i, u, v, w, 0.0, 0.0, ON)
    square = u * u + v * v
    scale = (square / (OMEGA * P.radius) ** 2) * abs(sums.torque)
    assert ours == pytest.approx(extra(sums, w), abs=1e-2 * scale + 1e-12)


@settings(deadline=None, max_examples=60)
@given(u=SPEED, v=SPEED, a_1=TILT, b_1=TILT, theta_0=st.floats(0.1, 0.17), v_i=st.floats(2.0, 6.0))
def test_torque_of_a_tilted_disc_is_that_of_its_flapping_blades(
    u: float, v: float, a_1: float, b_1: float, theta_0: float, v_i: float
) -> None:
    """Numerical twin; left over are the square of the tilt and third orders in speed and tilt."""
    sums = blades(theta_0, v_i, (u, v, 0.0), a_1, b_1)
    level = blades(theta_0, v_i, (u, v, 0.0), 0.0, 0.0)
    ours = h_force_torque(sums.thrust, theta_0, OMEGA, v_i, u, v, 0.0, a_1, b_1, ON)
    flat = h_force_torque(level.thrust, theta_0, OMEGA, v_i, u, v, 0.0, 0.0, 0.0, ON)
    change = extra(sums, 0.0) - extra(level, 0.0)
    tilt, speed = math.hypot(a_1, b_1), math.hypot(u, v)
    bound = 2e-2 * tilt * speed * sums.thrust / OMEGA + tilt**2 * abs(sums.torque) + 1e-9
    assert ours - flat == pytest.approx(change, abs=bound)


@settings(deadline=None, max_examples=60)
@given(u=SPEED, v=SPEED, a_1=TILT, b_1=TILT)
def test_in_plane_force_is_that_of_the_blade_elements(u: float, v: float, a_1: float, b_1: float) -> None:
    """Force of the flapping blades along the body's axes: thrust tilted with the disc, less H."""
    sums = blades(HOVER, 4.2, (u, v, 0.0), a_1, b_1)
    h = h_force_per_speed(HOVER, OMEGA, 4.2, 0.0, sums.c_d, ON)
    bound = 1e-2 * h * math.hypot(u, v) + 1e-5 * sums.thrust * math.hypot(a_1, b_1) + 1e-9
    # what coning does to the side force is left out on both sides
    assert sums.force[0] == pytest.approx(-sums.thrust * a_1 - h * u, abs=bound)
    assert sums.force[1] == pytest.approx(sums.thrust * b_1 - h * v, abs=bound)


def test_twin_is_the_benchs_own_rotor() -> None:
    assert ON.inflow_gradient == C.inflow_gradient == pytest.approx(K_V, rel=1e-12)
    assert ON.fade_speed == C.fade_speed
    sums = blades(HOVER, 4.2, (1.0, -2.0, 0.5), 0.0, 0.0)
    assert sums.thrust == pytest.approx(rotor.thrust(HOVER, OMEGA, 4.2, 1.0, -2.0, 0.5, C), rel=2e-3)
    hover = blades(HOVER, 4.2, (0.0, 0.0, 0.0), 0.0, 0.0)
    torque = rotor.torque(0.0, HOVER, OMEGA, 4.2, 0.0, C)
    assert ON.drag * hover.c_d * OMEGA**2 * ON.fourth == pytest.approx(torque, rel=1e-12)
    assert extra(hover, 0.0) == pytest.approx(0.0, abs=1e-12)


@given(theta_0=st.floats(-0.1, 0.3), v_i=st.floats(-1.0, 8.0), w_a=st.floats(-3.0, 3.0), tilt=TILT)
@settings(deadline=None)
def test_hover_and_climb_do_not_change(theta_0: float, v_i: float, w_a: float, tilt: float) -> None:
    assert h_force_torque(70.0, theta_0, OMEGA, v_i, 0.0, 0.0, w_a, tilt, -tilt, ON) == 0.0


@given(u=SPEED, v=SPEED, turn=st.floats(-math.pi, math.pi))
@settings(deadline=None)
def test_no_direction_is_special(u: float, v: float, turn: float) -> None:
    """Turn the air speed and the tilt together, and nothing changes; the rotor has no front."""

    def torque(angle: float) -> float:
        cos, sin = math.cos(angle), math.sin(angle)
        forward, side = cos * u - sin * v, sin * u + cos * v
        lean_x, lean_y = cos * -0.02 - sin * 0.01, sin * -0.02 + cos * 0.01
        # the disc's lean is (-a_1, b_1) along x and y
        return h_force_torque(70.0, HOVER, OMEGA, 4.2, forward, side, 0.3, -lean_x, lean_y, ON)

    assert torque(turn) == pytest.approx(torque(0.0), rel=1e-9, abs=1e-12)


def test_off_is_nothing_at_all() -> None:
    assert h_force_torque(70.0, HOVER, OMEGA, 4.2, 5.0, -3.0, 1.0, 0.05, -0.05, OFF) == 0.0
    assert torque_in_compiled_code(5.0, -0.02, packed(OFF)) == 0.0
    on = h_force_torque(70.0, 0.17, 163.0, 4.2, 5.0, 0.0, 0.0, -0.02, 0.0, ON)
    assert torque_in_compiled_code(5.0, -0.02, packed(ON)) == on > 0.0


def test_no_singularity_from_rest_to_flight() -> None:
    """Wind of 8 m/s on a rotor that runs up: nothing at rest, bounded and without a jump on the way."""
    speeds = np.linspace(0.0, OMEGA, 4001)
    found = np.array([h_force_torque(0.0, 0.1, float(o), 0.0, 8.0, 0.0, 0.0, 0.01, 0.0, ON) for o in speeds])
    assert found[0] == 0.0
    assert np.isfinite(found).all() and np.abs(found).max() < 0.1
    assert np.abs(np.diff(found)).max() < 1e-3
    assert h_force_torque(10.0, 0.1, -5.0, 0.0, 8.0, 0.0, 0.0, 0.01, 0.0, ON) == 0.0
