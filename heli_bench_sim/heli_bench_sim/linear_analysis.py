"""What a linear model looks like: scaling, singular values, condition number, modes, zeros (source sec. 2.4).

Nothing here knows the helicopter: it works on any `StateSpace`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from heli_common.linear_model import StateSpace

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

RANK_TOLERANCE = 1e-9
"""A singular value below this share of the largest counts as zero."""


def scaled(model: StateSpace, scales: Mapping[str, float]) -> StateSpace:
    """The model in units of its scales (source eq. 2.61, 2.62).

    Args:
        model: in SI.
        scales: typical deviation of every state, input and output, SI; all positive.

    Raises:
        ValueError: a name without a scale, or a scale that is not positive.
    """

    def of(names: tuple[str, ...]) -> Array:
        for name in names:
            if not scales.get(name, 0.0) > 0.0:
                raise ValueError(f"scale of {name!r} is {scales.get(name)!r}, not a positive number")
        return np.array([scales[name] for name in names])

    states, inputs, outputs = of(model.states), of(model.inputs), of(model.outputs)
    return StateSpace(
        model.states,
        model.inputs,
        model.outputs,
        model.A * states / states[:, None],
        model.B * inputs / states[:, None],
        model.C * states / outputs[:, None],
        model.D * inputs / outputs[:, None],
    )


def frequency_response(model: StateSpace, frequencies: Array) -> ComplexArray:
    """(f, outputs, inputs) of G(j omega).

    Args:
        model: linear model.
        frequencies: (f,) omega [rad/s], not the frequency of a pole on the imaginary axis.
    """
    resolvent = 1j * frequencies[:, None, None] * np.eye(len(model.states)) - model.A
    through = np.linalg.solve(resolvent, np.broadcast_to(model.B, (len(frequencies), *model.B.shape)))
    return np.asarray(model.C @ through + model.D, dtype=np.complex128)


def singular_values(model: StateSpace, frequencies: Array) -> Array:
    """(f, min(outputs, inputs)) singular values of G(j omega), largest first (source eq. 2.63).

    Args:
        model: linear model.
        frequencies: (f,) omega [rad/s], not the frequency of a pole on the imaginary axis.
    """
    response = frequency_response(model, frequencies)
    return np.asarray(np.linalg.svd(response, compute_uv=False), dtype=np.float64)


def condition_numbers(values: Array) -> Array:
    """(f,) largest by smallest singular value (source eq. 2.64).

    Args:
        values: (f, n) singular values, largest first.
    """
    numbers: Array = values[:, 0] / values[:, -1]
    return numbers


@dataclass(frozen=True, eq=False)
class Mode:
    """One pole with its eigenvector and the share of each state in it."""

    pole: complex
    """[rad/s]"""
    shape: ComplexArray
    """(n,) eigenvector in the model's units, length 1, its largest component real and positive"""
    participation: Array
    """(n,) share of each state in the mode, without a unit; the shares sum to about 1"""


def modes(model: StateSpace) -> tuple[Mode, ...]:
    """The modes of a model without repeated poles, fastest first, of a pair the upper one first.

    Args:
        model: linear model; eigenvectors depend on its units, poles and participation do not.
    """
    poles, right = np.linalg.eig(model.A)
    left = np.linalg.inv(right)
    order = np.lexsort((-poles.imag, np.round(-np.abs(poles), 9)))
    found = []
    for index in order:
        vector = right[:, index].astype(np.complex128)
        largest = vector[np.abs(vector).argmax()]
        shape = vector / np.linalg.norm(vector) * (abs(largest) / largest)
        found.append(Mode(complex(poles[index]), shape, np.abs(right[:, index] * left[index])))
    return tuple(found)


def transmission_zeros(model: StateSpace) -> ComplexArray:
    """(z,) frequencies that no output sees for a suitable input [rad/s]; at least as many outputs as inputs.

    Outputs are first mixed down to as many as there are inputs; of the zeros of that square model only those
    are kept at which the whole system matrix loses rank. Scale the model before.

    Args:
        model: linear model.

    Raises:
        ValueError: fewer outputs than inputs.
    """
    states, inputs, outputs = len(model.states), len(model.inputs), len(model.outputs)
    if outputs < inputs:
        raise ValueError(f"{outputs} outputs are fewer than {inputs} inputs")
    # any mix without structure does; this one is the same on every machine
    mix = np.cos(1.0 + np.outer(np.arange(1, inputs + 1), np.arange(1, outputs + 1) ** 1.5))
    if outputs == inputs:
        mix = np.eye(inputs)
    mass = np.zeros((states + inputs, states + inputs))
    mass[:states, :states] = np.eye(states)
    square = np.block([[model.A, model.B], [mix @ model.C, mix @ model.D]])
    candidates = scipy.linalg.eigvals(square, mass)
    whole = np.block([[model.A, model.B], [model.C, model.D]])
    selector = np.zeros_like(whole)
    selector[:states, :states] = np.eye(states)
    size = float(np.linalg.norm(whole, 2))
    zeros = []
    for zero in candidates[np.isfinite(candidates)]:
        if abs(zero) > size / RANK_TOLERANCE**0.5:
            continue  # infinite but for rounding
        values = np.linalg.svd(whole - zero * selector, compute_uv=False)
        if values[-1] < RANK_TOLERANCE * size:
            zeros.append(complex(zero))
    return np.array(sorted(zeros, key=lambda zero: (-abs(zero), -zero.imag)), dtype=np.complex128)
