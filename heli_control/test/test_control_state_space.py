from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from heli_common.linear_model import StateSpace
from heli_control.state_space import DiscreteBlock, delayed_zero_order_hold, zero_order_hold

SMALL = st.floats(-2.0, 2.0)


def names(letter: str, count: int) -> tuple[str, ...]:
    return tuple(f"{letter}{index}" for index in range(count))


def system(a: object, b: object, c: object, d: object) -> StateSpace:
    n, m, p = len(np.array(b)), np.array(d).shape[1], np.array(d).shape[0]
    matrices = (
        np.array(entry, dtype=float).reshape(shape)
        for entry, shape in ((a, (n, n)), (b, (n, m)), (c, (p, n)), (d, (p, m)))
    )
    return StateSpace(names("x", n), names("u", m), names("y", p), *matrices)


def test_accumulator_by_hand() -> None:
    block = DiscreteBlock(system([[1.0]], [[2.0]], [[1.0]], [[0.5]]))
    assert [block.step([u])[0] for u in (1.0, 0.0, 3.0)] == [0.5, 2.0, 3.5]
    assert block.state == (8.0,)
    block.reset()
    assert block.step([1.0]) == (0.5,)


def test_gain_without_states() -> None:
    direct = np.array([[1.0, 2.0], [0.0, -1.0]])
    empty = (np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((2, 0)))
    gain = StateSpace((), ("a", "b"), ("y", "z"), *empty, direct)
    assert DiscreteBlock(gain).step([3.0, 4.0]) == (11.0, -4.0)


def test_wrong_number_of_inputs_is_refused() -> None:
    with pytest.raises(ValueError, match="2 numbers for inputs u0"):
        DiscreteBlock(system([[1.0]], [[2.0]], [[1.0]], [[0.5]])).step([1.0, 2.0])


@settings(deadline=None, max_examples=30)
@given(
    arrays(float, (3, 3), elements=SMALL), arrays(float, (3, 2), elements=SMALL),
    arrays(float, (2, 3), elements=SMALL), arrays(float, (2, 2), elements=SMALL),
    arrays(float, (5, 2), elements=SMALL),
)  # fmt: skip
def test_step_agrees_with_matrix_products(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, inputs: np.ndarray
) -> None:
    block = DiscreteBlock(system(a, b, c, d))
    x = np.zeros(3)
    for u in inputs:
        np.testing.assert_allclose(block.step(u.tolist()), c @ x + d @ u, atol=1e-9)
        x = a @ x + b @ u
        np.testing.assert_allclose(block.state, x, atol=1e-9)


def test_hold_of_a_double_integrator_and_a_lag_by_hand() -> None:
    a, b = zero_order_hold(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), 0.1)
    np.testing.assert_allclose(a, [[1.0, 0.1], [0.0, 1.0]], atol=1e-15)
    np.testing.assert_allclose(b, [[0.005], [0.1]], atol=1e-15)
    a, b = zero_order_hold(np.array([[-3.0]]), np.array([[3.0]]), 0.2)
    np.testing.assert_allclose([a[0, 0], b[0, 0]], [math.exp(-0.6), 1.0 - math.exp(-0.6)])


def test_integrator_with_half_a_period_of_delay_by_hand() -> None:
    # x+ = x + 0.05 u(k-1) + 0.05 u(k)
    a, b = delayed_zero_order_hold(np.zeros((1, 1)), np.ones((1, 1)), 0.1, 0.05)
    np.testing.assert_allclose(a, [[1.0, 0.05], [0.0, 0.0]], atol=1e-15)
    np.testing.assert_allclose(b, [[0.05], [1.0]], atol=1e-15)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 35), arrays(float, (2, 2), elements=SMALL), arrays(float, (8, 2), elements=SMALL))
def test_delayed_hold_agrees_with_small_steps(tenths: int, a: np.ndarray, inputs: np.ndarray) -> None:
    period, b = 0.1, np.array([[1.0, 0.5], [-0.3, 2.0]])
    late_a, late_b = delayed_zero_order_hold(a, b, period, tenths * period / 10.0)
    x = np.zeros(len(late_a))
    small_a, small_b = zero_order_hold(a, b, period / 10.0)
    y = np.zeros(2)
    for k, u in enumerate(inputs):
        np.testing.assert_allclose(x[:2], y, atol=1e-9)
        x = late_a @ x + late_b @ u
        for tenth in range(10):
            origin = 10 * k + tenth - tenths
            y = small_a @ y + small_b @ (inputs[origin // 10] if origin >= 0 else np.zeros(2))


@pytest.mark.parametrize("delay", [0.01, 0.02, 0.03])
def test_whole_delays_add_one_state_per_period_and_input(delay: float) -> None:
    a, _ = delayed_zero_order_hold(np.zeros((3, 3)), np.ones((3, 2)), 0.01, delay)
    assert len(a) == 3 + 2 * round(delay / 0.01)


def test_negative_delay_is_refused() -> None:
    with pytest.raises(ValueError, match="negative"):
        delayed_zero_order_hold(np.zeros((1, 1)), np.ones((1, 1)), 0.1, -0.01)
