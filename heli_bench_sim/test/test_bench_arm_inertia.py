"""Arm inertia against its energy: by hand on the axis, by differences, by Lagrange, in free motion."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from heli_bench_sim.arm_inertia import (
    ArmInertiaParameters,
    arm_inertia_constants,
    arm_mass_matrix,
    solve_three,
)
from heli_bench_sim.delta_arm import arm_angles, arm_constants
from heli_common.compiled import compiled
from heli_common.rig_geometry import ARM_AZIMUTH, RigGeometry

RIG = RigGeometry()
GEOMETRY = arm_constants(RIG)
ON = ArmInertiaParameters(active=1.0)
C = arm_inertia_constants(ON)
OFF = arm_inertia_constants(ArmInertiaParameters())
Array = NDArray[np.float64]

RADIUS = st.floats(0.0, 0.5)
BEARING = st.floats(-math.pi, math.pi)
HEIGHT = st.floats(0.45, 1.25)
VELOCITY = st.tuples(*[st.floats(-2.0, 2.0)] * 3)


def place(radius: float, bearing: float, height: float) -> Array:
    return np.array([radius * math.cos(bearing), radius * math.sin(bearing), 0.90 - height])


def inertia(position: Array, velocity: Array) -> tuple[Array, Array]:
    mass, force = np.full(9, np.nan), np.full(3, np.nan)
    (x, y, z), (vx, vy, vz) = position.tolist(), velocity.tolist()
    assert arm_mass_matrix(x, y, z, vx, vy, vz, GEOMETRY, C, mass, force)
    return mass.reshape(3, 3), force


def pivots_and_elbows(position: Array) -> list[tuple[Array, Array]]:
    """Base pivot and elbow of each arm, NED, from the arm angles of the bench's inverse kinematics."""
    points = []
    for azimuth, angle in zip(ARM_AZIMUTH, arm_angles(position, RIG), strict=True):
        outward = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        pivot = 0.30 * outward + [0.0, 0.0, 0.90]
        points.append((pivot, pivot + 0.75 * (math.cos(angle) * outward - [0.0, 0.0, math.sin(angle)])))
    return points


def energy(position: Array, velocity: Array) -> float:
    """Kinetic energy of all tubes as mass points at Gauss's places, exact for a straight rod.

    Elbow velocities by a central difference of the inverse kinematics, five points.
    """
    step = 1e-3
    around = [pivots_and_elbows(position + k * step * velocity) for k in (-2, -1, 1, 2)]
    total = 0.0
    for arm in range(3):
        a, b, c, d = (elbows[arm][1] for elbows in around)
        elbow = (a - 8.0 * b + 8.0 * c - d) / (12.0 * step)
        for share in (0.5 - math.sqrt(1.0 / 12.0), 0.5 + math.sqrt(1.0 / 12.0)):
            upper = share * elbow
            fore = (1.0 - share) * elbow + share * velocity
            total += 0.5 * float(0.5 * 0.35 * upper @ upper + 0.5 * 0.25 * fore @ fore)
    return total


def mass_from_energy(position: Array) -> Array:
    """M by polarisation: T(e_i + e_j) - T(e_i) - T(e_j); M_ii = 2 T(e_i)."""
    unit = np.eye(3)
    alone = [energy(position, each) for each in unit]
    mass = np.diag(2.0 * np.array(alone))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        mass[i, j] = mass[j, i] = energy(position, unit[i] + unit[j]) - alone[i] - alone[j]
    return mass


def test_on_the_axis_by_hand() -> None:
    """All upper arms 60 deg up, moving straight up: every elbow turns alike, by Pythagoras."""
    sine, cosine = math.sqrt(0.75), 0.5
    out = 0.30 + 0.75 * cosine - 0.06
    rise = math.sqrt(0.90**2 - out**2)
    position = np.array([0.0, 0.0, 0.90 - 0.75 * sine - rise])
    turning = rise / (0.75 * (out * sine + rise * cosine))  # alpha' at 1 m/s
    up = 0.75 * turning * cosine
    twice = 3.0 * (0.60 * 0.75**2 / 3.0 * turning**2 + 0.25 / 3.0 * (up + 1.0))
    mass, _ = inertia(position, np.zeros(3))
    assert mass[2, 2] == pytest.approx(twice, rel=1e-12)
    assert mass[0, 0] == pytest.approx(mass[1, 1], rel=1e-12)  # three arms, evenly spread
    assert mass - np.diag(np.diag(mass)) == pytest.approx(np.zeros((3, 3)), abs=1e-14)


def test_switched_off_is_nothing() -> None:
    mass, force = np.full(9, np.nan), np.full(3, np.nan)
    assert arm_mass_matrix(0.1, 0.2, 0.3, 1.0, 2.0, 3.0, GEOMETRY, OFF, mass, force)
    assert mass.tolist() == [0.0] * 9
    assert force.tolist() == [0.0] * 3


def test_half_a_switch_is_refused() -> None:
    with pytest.raises(ValueError, match=r"0\.5 is no switch"):
        arm_inertia_constants(ArmInertiaParameters(active=0.5))


@settings(deadline=None, max_examples=30)
@given(RADIUS, BEARING, HEIGHT)
def test_mass_is_the_energys(radius: float, bearing: float, height: float) -> None:
    position = place(radius, bearing, height)
    mass, force = inertia(position, np.zeros(3))
    assert mass == pytest.approx(mass_from_energy(position), abs=1e-7)
    assert force.tolist() == [0.0, 0.0, 0.0]


@settings(deadline=None, max_examples=20)
@given(RADIUS, BEARING, HEIGHT, VELOCITY)
def test_force_is_lagranges(
    radius: float, bearing: float, height: float, velocity: tuple[float, float, float]
) -> None:
    """h = (d/dt M) v - 1/2 grad (v.M v), both by differences of the mass got from the energy."""
    position, v, step = place(radius, bearing, height), np.array(velocity), 1e-3

    def slope(direction: Array) -> Array:
        a, b, c, d = (mass_from_energy(position + k * step * direction) for k in (-2, -1, 1, 2))
        return np.asarray((a - 8.0 * b + 8.0 * c - d) / (12.0 * step))

    gradient = [v @ slope(axis) @ v for axis in np.eye(3)]
    expected = slope(v) @ v - 0.5 * np.array(gradient)
    _, force = inertia(position, v)
    assert force == pytest.approx(expected, abs=1e-6 * (1.0 + v @ v))


@settings(deadline=None, max_examples=100)
@given(RADIUS, BEARING, HEIGHT, VELOCITY)
def test_positive_definite_symmetric_and_square_in_speed(
    radius: float, bearing: float, height: float, velocity: tuple[float, float, float]
) -> None:
    position, v = place(radius, bearing, height), np.array(velocity)
    mass, force = inertia(position, v)
    assert mass.tolist() == mass.T.tolist()
    # a rod with its joint end moving at v has at least m v^2 / 8, whatever the elbow does
    assert np.linalg.eigvalsh(mass).min() >= 3.0 * 0.25 / 4.0
    assert inertia(position, -v)[1] == pytest.approx(force, rel=1e-12, abs=1e-14)
    assert inertia(position, 2.0 * v)[1] == pytest.approx(4.0 * force, rel=1e-12, abs=1e-14)


@settings(deadline=None, max_examples=50)
@given(RADIUS, BEARING, HEIGHT, VELOCITY)
def test_a_third_of_a_turn_and_a_mirror_change_nothing(
    radius: float, bearing: float, height: float, velocity: tuple[float, float, float]
) -> None:
    third = 2.0 * math.pi / 3.0
    turn = np.array(
        [
            [math.cos(third), -math.sin(third), 0.0],
            [math.sin(third), math.cos(third), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    position, v = place(radius, bearing, height), np.array(velocity)
    mass, force = inertia(position, v)
    for moved in (turn, np.diag([1.0, -1.0, 1.0])):
        mass_there, force_there = inertia(moved @ position, moved @ v)
        assert mass_there == pytest.approx(moved @ mass @ moved.T, rel=1e-9, abs=1e-12)
        assert force_there == pytest.approx(moved @ force, rel=1e-9, abs=1e-12)


@compiled
def coast(
    state: Array, step: float, steps: int, mass: Array, force: Array, slopes: Array, energies: Array
) -> bool:
    """Platform without a mass of its own, carried on by the arms alone: M a + h = 0, Runge and Kutta."""
    start, trial = state.copy(), state.copy()
    for count in range(steps):
        start[:] = state
        trial[:] = state
        for stage in range(4):
            if not arm_mass_matrix(
                trial[0], trial[1], trial[2], trial[3], trial[4], trial[5], GEOMETRY, C, mass, force
            ):
                return False
            if stage == 0:
                energies[count] = 0.0
                for i in range(3):
                    for j in range(3):
                        energies[count] += 0.5 * trial[3 + i] * mass[3 * i + j] * trial[3 + j]
            if not solve_three(mass, force, force):
                return False
            weight = 1.0 if stage in (0, 3) else 2.0
            ahead = step if stage == 2 else 0.5 * step
            for i in range(3):
                slopes[i], slopes[3 + i] = trial[3 + i], -force[i]
            for i in range(6):
                state[i] += step / 6.0 * weight * slopes[i]
                trial[i] = start[i] + ahead * slopes[i]
    return True


@pytest.mark.parametrize(
    "start",
    [(0.0, 0.0, 0.0, 0.8, 0.3, -0.2), (-0.3, 0.2, 0.3, 0.9, -0.7, -1.0), (0.2, 0.3, -0.3, -0.8, 0.1, 1.0)],
)
def test_coasting_keeps_its_energy(start: tuple[float, ...]) -> None:
    state, energies = np.array(start), np.empty(400)
    assert coast(state, 1e-3, 400, np.empty(9), np.empty(3), np.empty(6), energies)
    assert np.abs(energies / energies[0] - 1.0).max() < 1e-8
    straight = np.array(start[:3]) + 0.4 * np.array(start[3:])
    assert np.abs(state[:3] - straight).max() > 0.003  # the arms did bend the path: h is at work


@pytest.mark.parametrize(
    "position", [(0.0, 0.0, -1.0), (1.5, 0.0, 0.0), (0.0, -0.9, -0.3), (0.0, math.nan, 0.0)]
)
def test_out_of_reach_is_said_and_gives_nothing(position: tuple[float, float, float]) -> None:
    mass, force = np.full(9, np.nan), np.full(3, np.nan)
    assert not arm_mass_matrix(*position, 1.0, 1.0, 1.0, GEOMETRY, C, mass, force)
    assert mass.tolist() == [0.0] * 9
    assert force.tolist() == [0.0] * 3


def test_beyond_the_stops_it_still_holds() -> None:
    for bearing in np.linspace(-math.pi, math.pi, 37):
        for height in (0.42, 0.9, 1.3):
            mass, _ = inertia(place(0.6, float(bearing), height), np.ones(3))
            assert np.linalg.eigvalsh(mass).min() > 0.1
            assert np.linalg.eigvalsh(mass).max() < 10.0


@settings(deadline=None, max_examples=100)
@given(
    st.lists(st.floats(-2.0, 2.0), min_size=9, max_size=9),
    st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3),
)
def test_solve_three_solves(root: list[float], right: list[float]) -> None:
    half = np.array(root).reshape(3, 3)
    matrix = half @ half.T + 0.1 * np.eye(3)
    out = np.full(3, np.nan)
    assert solve_three(matrix.ravel(), np.array(right), out)
    assert matrix @ out == pytest.approx(right, abs=1e-9)
    same = np.array(right)
    assert solve_three(matrix.ravel(), same, same)
    assert same.tolist() == out.tolist()


@pytest.mark.parametrize(
    "diagonal", [(0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 0.0), (math.nan, 1.0, 1.0)]
)
def test_solve_three_refuses_what_is_not_positive_definite(diagonal: tuple[float, float, float]) -> None:
    out = np.full(3, 7.0)
    assert not solve_three(np.diag(diagonal).ravel(), np.ones(3), out)
    assert out.tolist() == [7.0] * 3
