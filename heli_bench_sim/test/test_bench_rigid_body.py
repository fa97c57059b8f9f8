"""Rigid body: rotations, Euler's equations, conservation laws, mirror symmetry."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from heli_bench_sim import rigid_body
from heli_bench_sim.helicopter import derivative
from heli_bench_sim.parameters import constants, thesis
from heli_bench_sim.states import INPUT_SIZE, STATE_SIZE, State

Array = NDArray[np.float64]

ANGLE = st.floats(-1.2, 1.2)
NUMBER = st.floats(-3.0, 3.0)
COUPLED = dataclasses.replace(thesis(), inertia_xz=0.03, drag_area=0.0)
C = constants(COUPLED)
INERTIA = np.array([[0.0938, 0.0, -0.03], [0.0, 0.2357, 0.0], [-0.03, 0.0, 0.4004]])
STILL = np.zeros(3)


def rates(state: Array, c: object = C, wind: Array = STILL) -> Array:
    out = np.empty(STATE_SIZE)
    derivative(state, np.zeros(INPUT_SIZE), wind, STILL, STILL, c, out)  # type: ignore[arg-type]
    return out


def test_quarter_turns_by_hand() -> None:
    """Heading east, north lies to the left; nose up, gravity pulls backwards."""
    assert rigid_body.body_from_earth(1.0, 0.0, 0.0, math.pi / 2, 0.0, 0.0) == pytest.approx((0, -1, 0))
    assert rigid_body.body_from_earth(0.0, 0.0, 1.0, 0.0, math.pi / 2, 0.0) == pytest.approx((-1, 0, 0))
    assert rigid_body.body_from_earth(0.0, 0.0, 1.0, 0.0, 0.0, math.pi / 2) == pytest.approx((0, 1, 0))


@settings(deadline=None, max_examples=50)
@given(NUMBER, NUMBER, NUMBER, ANGLE, ANGLE, ANGLE)
def test_rotation_agrees_with_the_matrix(
    x: float, y: float, z: float, psi: float, theta: float, phi: float
) -> None:
    matrix = Rotation.from_euler("ZYX", [psi, theta, phi]).as_matrix()
    body = rigid_body.body_from_earth(x, y, z, psi, theta, phi)
    assert body == pytest.approx(matrix.T @ [x, y, z], abs=1e-12)
    assert rigid_body.earth_from_body(*body, psi, theta, phi) == pytest.approx((x, y, z), abs=1e-12)


@settings(deadline=None, max_examples=30)
@given(NUMBER, NUMBER, NUMBER, ANGLE, ANGLE)
def test_euler_rates_move_the_rotation_as_the_body_rates_do(
    p: float, q: float, r: float, theta: float, phi: float
) -> None:
    turning = rigid_body.euler_rates(p, q, r, theta, phi)
    step = 1e-5

    def attitude(time: float) -> Rotation:
        return Rotation.from_euler("ZYX", np.array([0.0, theta, phi]) + time * np.array(turning))

    moved = (attitude(-step).inv() * attitude(step)).as_rotvec() / (2.0 * step)
    assert moved == pytest.approx(np.array([p, q, r]), abs=1e-6)


@settings(deadline=None, max_examples=30)
@given(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, ANGLE, ANGLE)
def test_gimbal_torques_have_the_power_of_the_body_moment(
    yaw: float, pitch: float, roll: float, p: float, q: float, r: float, theta: float, phi: float
) -> None:
    turning = rigid_body.euler_rates(p, q, r, theta, phi)
    moment = rigid_body.body_moment(yaw, pitch, roll, theta, phi)
    assert np.dot(moment, [p, q, r]) == pytest.approx(np.dot([yaw, pitch, roll], turning), abs=1e-10)


@settings(deadline=None, max_examples=30)
@given(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER)
def test_angular_accelerations_solve_euler_s_equation(
    moment_x: float, moment_y: float, moment_z: float, p: float, q: float, r: float
) -> None:
    moment, omega = np.array([moment_x, moment_y, moment_z]), np.array([p, q, r])
    twin = np.linalg.solve(INERTIA, moment - np.cross(omega, INERTIA @ omega))
    found = rigid_body.angular_accelerations(moment_x, moment_y, moment_z, p, q, r, C)
    assert found == pytest.approx(twin, abs=1e-9)


def fly(state: Array, duration: float, steps: int) -> Array:
    h = duration / steps
    for _ in range(steps):
        first = rates(state)
        second = rates(state + 0.5 * h * first)
        third = rates(state + 0.5 * h * second)
        fourth = rates(state + h * third)
        state = state + h / 6.0 * (first + 2.0 * (second + third) + fourth)
    return state


def test_dead_helicopter_conserves_energy_and_angular_momentum() -> None:
    """Rotor stopped, no drag: a rigid body thrown in gravity."""
    state = np.zeros(STATE_SIZE)
    state[[State.u, State.v, State.w]] = 1.0, -0.5, -2.0
    state[[State.p, State.q, State.r]] = 1.2, -0.8, 0.9
    state[[State.psi, State.theta, State.phi]] = 0.3, -0.2, 0.1

    def conserved(now: Array) -> tuple[float, Array]:
        velocity, omega = now[[State.u, State.v, State.w]], now[[State.p, State.q, State.r]]
        moment = INERTIA @ omega
        energy = 0.5 * 7.3 * velocity @ velocity + 0.5 * omega @ moment - 7.3 * 9.81 * now[State.z]
        angles = now[[State.psi, State.theta, State.phi]]
        return float(energy), Rotation.from_euler("ZYX", angles).as_matrix() @ moment

    energy, momentum = conserved(state)
    flown = fly(state, 1.0, 1000)
    assert np.abs(flown - state).max() > 0.5
    assert conserved(flown)[0] == pytest.approx(energy, rel=1e-8)
    assert conserved(flown)[1] == pytest.approx(momentum, rel=1e-8, abs=1e-10)


def test_dead_helicopter_falls_by_hand() -> None:
    state = fly(np.zeros(STATE_SIZE), 0.5, 10)
    assert state[State.z] == pytest.approx(0.5 * 9.81 * 0.25, rel=1e-12)
    assert state[State.w] == pytest.approx(9.81 * 0.5, rel=1e-12)


@settings(deadline=None, max_examples=30)
@given(st.lists(NUMBER, min_size=9, max_size=9), ANGLE, ANGLE, ANGLE)
def test_airframe_mirrored_left_to_right_moves_mirrored(
    numbers: list[float], psi: float, theta: float, phi: float
) -> None:
    """Without the rotors nothing tells left from right, wind and drag included."""
    c = constants(thesis())
    odd = [State.y, State.v, State.psi, State.phi, State.p, State.r, State.b_1p]
    state = np.zeros(STATE_SIZE)
    state[[State.u, State.v, State.w, State.p, State.q, State.r]] = numbers[:6]
    state[[State.psi, State.theta, State.phi]] = psi, theta, phi
    wind = np.array(numbers[6:])
    mirror = np.ones(STATE_SIZE)
    mirror[odd] = -1.0
    mirrored = rates(mirror * state, c, wind * [1.0, -1.0, 1.0])
    assert mirrored == pytest.approx(mirror * rates(state, c, wind), abs=1e-9)


@settings(deadline=None, max_examples=20)
@given(ANGLE, NUMBER, NUMBER)
def test_heading_and_place_do_not_matter(turn: float, x: float, y: float) -> None:
    """The same flight in another corner and heading: body accelerations are the same."""
    state = np.zeros(STATE_SIZE)
    state[[State.u, State.v, State.w, State.theta, State.phi, State.Omega]] = 1.0, 0.5, -0.2, 0.1, -0.1, 160.0
    moved = state.copy()
    moved[[State.x, State.y, State.psi]] = x, y, turn
    keep = [index for index in State if index not in (State.x, State.y)]
    assert rates(moved)[keep] == pytest.approx(rates(state)[keep], abs=1e-10)
