"""Bare matrices of a continuous linear system, and how such systems are joined.

    x' = A x + B u,   y = C x + D u

Synthesis works on many small systems whose signals have no names; `StateSpace` is what goes in and out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import matrix_balance

from heli_common.linear_model import StateSpace

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Realisation(NamedTuple):
    """A shape (n, n), B (n, m), C (p, n), D (p, m)."""

    A: Array
    B: Array
    C: Array
    D: Array

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.A)


def realisation(a: Any, b: Any, c: Any, d: Any) -> Realisation:
    """From anything that numpy reads as matrices.

    Raises:
        ValueError: shapes that do not belong together, or a number that is not finite.
    """
    d = np.atleast_2d(np.asarray(d, dtype=np.float64))
    a = np.asarray(a, dtype=np.float64)
    n = len(a)
    shapes = {"A": (n, n), "B": (n, d.shape[1]), "C": (d.shape[0], n)}
    made = {}
    for (name, shape), value in zip(shapes.items(), (a, b, c), strict=True):
        matrix = np.asarray(value, dtype=np.float64)
        if matrix.size != shape[0] * shape[1] or (matrix.size and matrix.shape != shape):
            raise ValueError(f"{name} has shape {matrix.shape}; allowed: {shape}")
        made[name] = matrix.reshape(shape)
    for name, matrix in [*made.items(), ("D", d)]:
        if not np.isfinite(matrix).all():
            raise ValueError(f"{name} holds a number that is not finite; allowed: finite numbers")
    return Realisation(made["A"], made["B"], made["C"], d)


def unnamed(system: StateSpace) -> Realisation:
    """The matrices of a system with names."""
    return Realisation(system.A, system.B, system.C, system.D)


def named(system: Realisation, inputs: tuple[str, ...], outputs: tuple[str, ...], state: str) -> StateSpace:
    """With names; states are called `state`_1, `state`_2 and so on."""
    states = tuple(f"{state}_{index + 1}" for index in range(system.order))
    return StateSpace(states, inputs, outputs, *system)


def gain(matrix: Any) -> Realisation:
    """A system without states."""
    d = np.atleast_2d(np.asarray(matrix, dtype=np.float64))
    return realisation(np.zeros((0, 0)), np.zeros((0, d.shape[1])), np.zeros((d.shape[0], 0)), d)


def first_order(high: float, zero: float, pole: float) -> Realisation:
    """(high s + zero) / (s + pole); pole zero is an integrator."""
    return realisation([[-pole]], [[1.0]], [[zero - high * pole]], [[high]])


def rational(numerator: Sequence[float], denominator: Sequence[float]) -> Realisation:
    """A proper transfer function in controller form, coefficients with the highest power of s first.

    Raises:
        ValueError: the denominator begins with zero, or the numerator is of higher order.
    """
    bottom, top = np.asarray(denominator, dtype=np.float64), np.asarray(numerator, dtype=np.float64)
    if bottom[0] == 0.0:
        raise ValueError("the denominator begins with 0.0; allowed: not zero, else the order is another")
    order, spare = len(bottom) - 1, len(top) - len(bottom)
    if spare > 0 and top[:spare].any():
        raise ValueError(f"a numerator of order {len(top) - 1} over {order}; allowed: no higher order")
    full = np.concatenate((np.zeros(max(-spare, 0)), top[max(spare, 0) :])) / bottom[0]
    bottom = bottom / bottom[0]
    if not order:
        return gain(full[0])
    a = np.vstack((-bottom[1:], np.eye(order)[:-1]))
    return realisation(a, np.eye(order)[:, :1], (full[1:] - full[0] * bottom[1:])[None], full[:1, None])


def diagonal(*blocks: Realisation) -> Realisation:
    """Systems side by side, each with inputs and outputs of its own."""
    made = []
    for matrices in zip(*blocks, strict=True):
        rows, columns = sum(part.shape[0] for part in matrices), sum(part.shape[1] for part in matrices)
        matrix = np.zeros((rows, columns))
        row = column = 0
        for part in matrices:
            matrix[row : row + part.shape[0], column : column + part.shape[1]] = part
            row, column = row + part.shape[0], column + part.shape[1]
        made.append(matrix)
    return Realisation(*made)


def series(second: Realisation, first: Realisation) -> Realisation:
    """second(s) first(s): the output of the first is the input of the second."""
    n1, n2 = first.order, second.order
    a = np.block([[second.A, second.B @ first.C], [np.zeros((n1, n2)), first.A]])
    b = np.vstack((second.B @ first.D, first.B))
    return Realisation(a, b, np.hstack((second.C, second.D @ first.C)), second.D @ first.D)


def balanced(system: Realisation) -> tuple[Realisation, Array]:
    """The same system with its states scaled by powers of two, so that rows and columns are alike in size.

    Args:
        system: n states.

    Returns:
        the system in x / t, and t, shape (n,).
    """
    n, m, p = system.order, system.B.shape[1], system.C.shape[0]
    whole = np.zeros((n + m + p, n + m + p))
    whole[:n, :n], whole[:n, n : n + m], whole[n + m :, :n] = system.A, system.B, system.C
    scales = np.asarray(matrix_balance(whole, permute=False, separate=True)[1][0])
    t = scales[:n]
    scaled = Realisation(system.A * t / t[:, None], system.B / t[:, None], system.C * t, system.D)
    return scaled, t


def response(system: Realisation, omega: Array) -> Complex:
    """Transfer matrix at j omega, shape (k, p, m) for k frequencies [rad/s]; infinity gives D."""
    finite = np.isfinite(omega)
    s = 1j * np.where(finite, omega, 0.0)
    pencil = s[:, None, None] * np.eye(system.order) - system.A
    wide = np.broadcast_to(system.B, (omega.size, *system.B.shape)).astype(np.complex128)
    if not finite.all():
        pencil[~finite], wide[~finite] = np.eye(system.order), 0.0
    return np.asarray(system.C @ np.linalg.solve(pencil, wide) + system.D, dtype=np.complex128)
