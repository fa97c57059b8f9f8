"""Discrete-time state space: what a linear controller is while it flies, and how it is discretised.

    x+ = A x + B u,   y = C x + D u

Sums run in a fixed order on plain floats, so a replay gives the same bits.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from heli_common.linear_model import StateSpace

Array = NDArray[np.float64]
Rows = tuple[tuple[float, ...], ...]

Numbers = Sequence[float] | Array
"""Plain numbers in a node, an array in compiled code."""
Written = list[float] | Array
"""The same, to be overwritten."""
Matrix = Sequence[Sequence[float]] | Array


class DiscreteBlock:
    """A discrete-time linear system with its state.

    Args:
        system: matrices of the difference equation; names give the order of inputs and outputs.

    Attributes:
        inputs: names, in the order of `step`.
        outputs: names, in the order of its result.
    """

    def __init__(self, system: StateSpace) -> None:
        self.inputs = system.inputs
        self.outputs = system.outputs
        # one row per sum: [A B] for the next state, [C D] for the output
        self._next = rows_of(np.hstack((system.A, system.B)))
        self._output = rows_of(np.hstack((system.C, system.D)))
        self._rest = (0.0,) * len(system.states)
        self._state = self._rest
        self._column: tuple[float, ...] = ()  # of the last step, until the state has gone on by it

    @property
    def state(self) -> tuple[float, ...]:
        """State before the next step: worked out when it is asked for, so that no output waits for it."""
        if self._column:
            state = list(self._rest)
            multiply(self._next, self._column, state)
            self.place(tuple(state))
        return self._state

    def step(self, inputs: Sequence[float]) -> tuple[float, ...]:
        """Output of this sample; the state goes on to the next.

        Args:
            inputs: a number per name in `inputs`.

        Returns:
            a number per name in `outputs`.
        """
        if len(inputs) != len(self.inputs):
            raise ValueError(f"{len(inputs)} numbers for inputs {', '.join(self.inputs)}")
        column, output = (*self.state, *inputs), [0.0] * len(self.outputs)
        multiply(self._output, column, output)
        self._column = column
        return tuple(output)

    def place(self, state: tuple[float, ...]) -> None:
        """Go on from another state.

        Args:
            state: a number per state.

        Raises:
            ValueError: another number of states.
        """
        if len(state) != len(self._rest):
            raise ValueError(f"{len(state)} numbers for {len(self._rest)} states")
        self._state, self._column = state, ()

    def reset(self) -> None:
        """Back to state zero."""
        self.place(self._rest)


def zero_order_hold(a: Array, b: Array, period: float) -> tuple[Array, Array]:
    """Exact discretisation of x' = A x + B u with u held.

    Args:
        a: shape (n, n).
        b: shape (n, m).
        period: sample time [s]; zero gives the identity and no input.

    Returns:
        A_d, shape (n, n), and B_d, shape (n, m).
    """
    n, m = b.shape
    together = np.zeros((n + m, n + m))
    together[:n, :n], together[:n, n:] = a, b
    exponential: Array = expm(together * period)
    return exponential[:n, :n].copy(), exponential[:n, n:].copy()


def delayed_zero_order_hold(a: Array, b: Array, period: float, delay: float) -> tuple[Array, Array]:
    """The same with an input that acts late; the commands under way become states.

    A delay of d whole periods and a fraction f leaves u(k-d-1) acting for the first f of the period k and
    u(k-d) for the rest.

    Args:
        a: shape (n, n).
        b: shape (n, m).
        period: sample time [s].
        delay: of the input [s], not negative.

    Returns:
        A, shape (n + l m, n + l m), and B, shape (n + l m, m), for the state (x(k), u(k-1), ... u(k-l));
        l is the delay in periods, rounded up.

    Raises:
        ValueError: the delay is negative.
    """
    if delay < 0.0:
        raise ValueError(f"delay {delay} s is negative")
    n, m = b.shape
    periods = delay / period
    whole = int(np.floor(periods + 1e-9))
    fraction = max(0.0, delay - whole * period)
    if fraction < 1e-9 * period:
        fraction = 0.0
    first_a, first_b = zero_order_hold(a, b, fraction)
    second_a, second_b = zero_order_hold(a, b, period - fraction)
    late = whole + (1 if fraction else 0)
    columns = np.zeros((n, (late + 1) * m))  # of u(k), u(k-1) ... u(k-l)
    columns[:, whole * m : (whole + 1) * m] = second_b
    if fraction:
        columns[:, late * m :] += second_a @ first_b
    full_a = np.zeros((n + late * m, n + late * m))
    full_b = np.zeros((n + late * m, m))
    full_a[:n, :n] = second_a @ first_a
    full_a[:n, n:], full_b[:n] = columns[:, m:], columns[:, :m]
    if late:
        full_b[n : n + m] = np.eye(m)
        full_a[n + m :, n:-m] = np.eye((late - 1) * m)
    return full_a, full_b


def rows_of(matrix: Array) -> Rows:
    """A matrix as plain floats, row by row."""
    return tuple(tuple(row) for row in matrix.tolist())


def product(row: Numbers, column: Numbers) -> float:
    """Sum of the products, in order; compiled code may call it, as the next two."""
    total = 0.0
    for index in range(len(column)):
        total += row[index] * column[index]
    return total


def multiply(rows: Matrix, column: Numbers, result: Written) -> None:
    """A matrix times a vector: [A B] (x, u) is x+, and [C D] (x, u) is y.

    Args:
        rows: (n, m).
        column: (m,) numbers.
        result: (n,) written.
    """
    for index in range(len(result)):
        result[index] = product(rows[index], column)


def add_product(state: Written, rows: Matrix, column: Numbers) -> None:
    """x + E u, in place.

    Args:
        state: (n,) x, overwritten.
        rows: (n, m) E.
        column: (m,) u.
    """
    for index in range(len(state)):
        state[index] = state[index] + product(rows[index], column)
