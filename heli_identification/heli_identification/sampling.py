"""Exact sampling of a grey-box model, with the derivatives of the sampled matrices.

    x(k+1) = A_d x(k) + B_d u(k)                     input held (a command that a digital output holds)
    x(k+1) = A_d x(k) + B_0 u(k) + B_1 u(k+1)        input linear between samples (a measured actuator)
    x(k+1) = A_d x(k) + B_0 u(k) + B_1 u(k-1)        input changes in the middle of the period (a command
                                                     that takes effect half a period late)

Both come from one exponential of an augmented matrix (C. Van Loan, 1978); its derivative with respect to a
parameter is that of the block matrix [[M, dM], [0, M]] (R. Mathias, 1996).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from heli_identification.structures import Structure

Array = NDArray[np.float64]


class Hold(Enum):
    """What the input does between two samples."""

    ZERO = "zero"
    LINEAR = "linear"
    LATE = "late"
    """held, and changing in the middle of the period"""


@dataclass(frozen=True, eq=False)
class Sampled:
    """A sampled model with its sensitivities to r parameters.

    Attributes:
        A: shape (n, n).
        B: shape (n, m), or (n, 2 m): columns of u(k), then of u(k+1) for a linear input,
            of u(k-1) for a late one.
        dA: shape (r, n, n).
        dB: like B for every parameter, shape (r, n, m) or (r, n, 2 m).
        N: shape (n, n): effect of a constant on the right hand side of x', over one period [s].
        dN: shape (r, n, n).
    """

    A: Array
    B: Array
    dA: Array
    dB: Array
    N: Array
    dN: Array


def sample(structure: Structure, values: Array, period: float, hold: Hold = Hold.ZERO) -> Sampled:
    """Sample a structure at parameter values.

    Args:
        structure: with n states, m inputs and r parameters.
        values: of all parameters, shape (r,).
        period: sample time [s].
        hold: of the input.
    """
    if hold is Hold.LATE:
        return _late(structure, values, period)
    a, b = structure.matrices(values)
    da, db = structure.derivatives(values)
    n, m = b.shape
    # states, input, its slope per period; a constant on every state's derivative
    size = 2 * n + (2 * m if hold is Hold.LINEAR else m)
    first = slice(n, n + m)
    constant = slice(size - n, size)

    def augmented(a_part: Array, b_part: Array) -> Array:
        matrix = np.zeros((size, size))
        matrix[:n, :n], matrix[:n, first] = a_part * period, b_part * period
        return matrix

    whole = augmented(a, b)
    whole[:n, constant] = np.eye(n) * period
    if hold is Hold.LINEAR:
        whole[first, n + m : n + 2 * m] = np.eye(m)
    rows = np.zeros((len(values), n, size))
    exponential = expm(whole)[:n]
    active = [index for index in range(len(values)) if np.any(da[index]) or np.any(db[index])]
    if active:
        pairs = np.zeros((len(active), 2 * size, 2 * size))
        pairs[:, :size, :size] = pairs[:, size:, size:] = whole
        for row, index in enumerate(active):
            pairs[row, :size, size:] = augmented(da[index], db[index])
        rows[active] = expm(pairs)[:, :n, size:]

    def inputs(block: Array) -> Array:
        value = block[..., :, first]
        if hold is Hold.ZERO:
            return np.ascontiguousarray(value)
        slope = block[..., :, n + m : n + 2 * m]
        return np.concatenate((value - slope, slope), axis=-1)

    return Sampled(
        A=exponential[:, :n].copy(),
        B=inputs(exponential),
        dA=np.ascontiguousarray(rows[:, :, :n]),
        dB=inputs(rows),
        N=exponential[:, constant].copy(),
        dN=np.ascontiguousarray(rows[:, :, constant]),
    )


def _late(structure: Structure, values: Array, period: float) -> Sampled:
    """Two halves one after the other: the first with the input before, the second with the new one."""
    half = sample(structure, values, 0.5 * period, Hold.ZERO)
    a, b, n = half.A, half.B, half.N
    da, db, dn = half.dA, half.dB, half.dN
    return Sampled(
        A=a @ a,
        B=np.hstack((b, a @ b)),
        dA=da @ a + a @ da,
        dB=np.concatenate((db, da @ b + a @ db), axis=-1),
        N=n + a @ n,
        dN=dn + da @ n + a @ dn,
    )


def held_inputs(inputs: Array, hold: Hold) -> Array:
    """The input columns that belong to `Sampled.B`.

    Args:
        inputs: shape (N, m).
        hold: of the input.

    Returns:
        shape (N, m), or (N, 2 m) with the next sample beside each, or the one before for a late input; at the
        end a sample repeats itself.
    """
    if hold is Hold.ZERO:
        return inputs
    if hold is Hold.LATE:
        return np.hstack((inputs, np.vstack((inputs[:1], inputs[:-1]))))
    following = np.vstack((inputs[1:], inputs[-1:]))
    return np.hstack((inputs, following))
