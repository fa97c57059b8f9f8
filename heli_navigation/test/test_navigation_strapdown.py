"""Dead reckoning: matrices by hand, derivatives against differences, accuracy of one sample."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.rotations import Euler, matrix_from_euler
from heli_navigation.filter_memory import SIZE, Estimate, Work
from heli_navigation.strapdown import bend, lean, orient, reckon

TILT = st.floats(-0.4, 0.4)
YAW = st.floats(-3.0, 3.0)
RATE = st.floats(-3.0, 3.0)


def oriented(psi: float, theta: float, phi: float) -> np.ndarray:
    work = np.zeros(Work.end)
    orient(psi, theta, phi, work)
    return work


def body(work: np.ndarray) -> np.ndarray:
    return work[Work.body : Work.rates].reshape(3, 3)


def euler_rates(angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
    return oriented(*angles)[Work.rates : Work.bend].reshape(3, 3) @ rates


def test_level_is_simple() -> None:
    work = oriented(0.0, 0.0, 0.0)
    assert np.array_equal(body(work), np.eye(3))
    # roll follows p, pitch q, yaw r
    assert np.array_equal(work[Work.rates : Work.bend].reshape(3, 3), np.eye(3)[::-1])


@settings(deadline=None, max_examples=50)
@given(YAW, TILT, TILT)
def test_the_matrix_is_the_common_one(psi: float, theta: float, phi: float) -> None:
    assert body(oriented(psi, theta, phi)) == pytest.approx(
        np.array(matrix_from_euler(Euler(psi, theta, phi)))
    )


@settings(deadline=None, max_examples=50)
@given(YAW, TILT, TILT, RATE, RATE, RATE)
def test_bend_is_the_derivative_of_the_euler_rates(
    psi: float, theta: float, phi: float, p: float, q: float, r: float
) -> None:
    angles, rates, step = np.array([psi, theta, phi]), np.array([p, q, r]), 1e-6
    work = oriented(*angles)
    turning = euler_rates(angles, rates)
    bend(turning[0], turning[1], work)
    for axis in range(3):
        shift = step * np.eye(3)[axis]
        slope = (euler_rates(angles + shift, rates) - euler_rates(angles - shift, rates)) / (2.0 * step)
        assert work[Work.bend : Work.lean].reshape(3, 3)[:, axis] == pytest.approx(slope, abs=1e-6)


@settings(deadline=None, max_examples=50)
@given(YAW, TILT, TILT)
def test_lean_is_the_derivative_of_a_vector_of_the_body(psi: float, theta: float, phi: float) -> None:
    angles, vector, step = np.array([psi, theta, phi]), np.array([0.3, -0.5, -9.0]), 1e-6
    work = oriented(*angles)
    lean(*(body(work) @ vector), work)
    for axis in range(3):
        shift = step * np.eye(3)[axis]
        slope = (
            (body(oriented(*(angles + shift))) - body(oriented(*(angles - shift)))) @ vector / (2.0 * step)
        )
        assert work[Work.lean : Work.rate].reshape(3, 3)[:, axis] == pytest.approx(slope, abs=1e-6)


def test_free_fall_and_rest_by_hand() -> None:
    estimate, work = np.zeros(SIZE), np.zeros(Work.end)
    reckon(estimate, 0.5, 10.0, work)  # nothing felt: falling
    assert estimate[Estimate.velocity + 2] == pytest.approx(5.0)
    assert estimate[Estimate.position + 2] == pytest.approx(1.25)
    estimate[:] = 0.0
    work[Work.push + 2] = -10.0
    reckon(estimate, 0.5, 10.0, work)
    assert estimate == pytest.approx(np.zeros(SIZE), abs=1e-15)


def test_a_turn_about_the_bodys_axes_is_exact_to_third_order() -> None:
    # the same turn in n steps: the error falls with the square of the step
    rates = np.array([1.5, -1.0, 2.0])

    def end(steps: int) -> np.ndarray:
        estimate, work = np.zeros(SIZE), np.zeros(Work.end)
        work[Work.rate : Work.push] = rates
        for _ in range(steps):
            reckon(estimate, 0.2 / steps, 9.81, work)
        return estimate[Estimate.angle : Estimate.gyro_bias]

    angle = 0.2 * np.linalg.norm(rates)
    x, y, z = rates / np.linalg.norm(rates)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross  # Rodrigues
    errors = [np.abs(body(oriented(*end(steps))) - turned).max() for steps in (10, 20, 80)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[2] < 2e-6
