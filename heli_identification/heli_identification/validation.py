"""Whether a model holds on other data: free simulation, residuals, frequency responses, poles (source 2.5.2).

Fit as in the field: 100 (1 - |y - y_sim| / |y - mean y|) % per output, in free simulation over short segments
whose initial state (and nothing else) is fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve

from heli_common.errors import InputError
from heli_identification.records import Record
from heli_identification.sampling import Hold, held_inputs, sample
from heli_identification.structures import Structure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Fit:
    """Free simulation against measurement.

    Attributes:
        outputs: p names.
        percent: fit over all segments, shape (p,).
        segments: fit of every segment, shape (s, p).
        simulated: shape (N', p), the segments one after the other.
        measured: shape (N', p).
    """

    outputs: tuple[str, ...]
    percent: Array
    segments: Array
    simulated: Array
    measured: Array


def fit(
    structure: Structure,
    records: Sequence[Record],
    *,
    hold: Hold = Hold.ZERO,
    segment: float = 10.0,
    offsets: bool = True,
) -> Fit:
    """Fit of a structure's model in free simulation.

    Args:
        structure: with the values to be judged.
        records: data that were not estimated from.
        hold: of the input.
        segment: length of a simulation [s].
        offsets: whether a constant on the measured states' derivatives is fitted with the initial state: what
            is wrong with the operating point is no error of the dynamics.

    Raises:
        InputError: no record is as long as a segment.
    """
    measured, simulated, single = [], [], []
    for record in records:
        count = round(segment / record.period)
        for begin in range(0, len(record) - count + 1, count):
            piece = record.piece(begin, begin + count)
            found = simulate(structure, piece, hold, offsets=offsets)
            measured.append(piece.y)
            simulated.append(found)
            single.append(_percent(piece.y, found, piece.y.mean(axis=0)))
    if not measured:
        longest = max((record.duration for record in records), default=0.0)
        problem = f"{longest:.1f} s of validation data"
        raise InputError(problem, allowed=f"at least {segment:g} s in one piece", key="validate")
    y, y_sim = np.vstack(measured), np.vstack(simulated)
    means = np.vstack([np.tile(part.mean(axis=0), (len(part), 1)) for part in measured])
    return Fit(structure.outputs, _percent(y, y_sim, means), np.array(single), y_sim, y)


def simulate(structure: Structure, record: Record, hold: Hold, *, offsets: bool) -> Array:
    """Outputs of the model driven by the measured input alone, shape (N, p); initial state fitted.

    Args:
        structure: with values.
        record: N samples.
        hold: of the input.
        offsets: whether constants on the measured states' derivatives are fitted, too.
    """
    sampled = sample(structure, structure.values, record.period, hold)
    seen = [structure.states.index(name) for name in structure.outputs]
    n, steps = len(structure.states), len(record)
    forced = held_inputs(record.u, hold) @ sampled.B.T
    size = 2 * n if offsets else n
    # columns: the forced motion, what every initial state does, what every constant does
    motion: Array = np.zeros((n, 1 + size))
    motion[:, 1 : 1 + n] = np.eye(n)
    found = np.zeros((steps, len(seen), 1 + size))
    for step in range(steps):
        found[step] = motion[seen]
        motion = sampled.A @ motion
        motion[:, 0] += forced[step]
        if offsets:
            motion[:, 1 + n :] += sampled.N
    used = [*range(1, 1 + n), *(1 + n + index for index in seen)] if offsets else list(range(1, 1 + n))
    weights = 1.0 / np.maximum(record.y.std(axis=0), 1e-12)
    left = ((record.y - found[:, :, 0]) * weights).ravel()
    right = (found[:, :, used] * weights[:, None]).reshape(-1, len(used))
    unknown, *_ = np.linalg.lstsq(right, left, rcond=1e-12)
    simulated: Array = found[:, :, 0] + found[:, :, used] @ unknown
    return simulated


def _percent(measured: Array, simulated: Array, mean: Array) -> Array:
    error = np.sqrt(np.sum((measured - simulated) ** 2, axis=0))
    size = np.maximum(np.sqrt(np.sum((measured - mean) ** 2, axis=0)), 1e-300)
    return np.asarray(100.0 * (1.0 - error / size), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Response:
    """Frequency responses of a model with their uncertainty.

    Attributes:
        frequencies: [rad/s], shape (f,).
        values: shape (f, p, m).
        deviation: standard deviation of the complex value (root of the sum of both parts' variances), shape
            (f, p, m), by linear propagation of the parameters' covariance.
    """

    frequencies: Array
    values: ComplexArray
    deviation: Array


def response(structure: Structure, covariance: Array, frequencies: Array) -> Response:
    """C (j omega - A)^-1 B with its uncertainty.

    Args:
        structure: with values; its free parameters are those of the covariance.
        covariance: shape (r, r).
        frequencies: [rad/s], shape (f,).
    """
    free = structure.index(structure.free_names)
    a, b = structure.matrices(structure.values)
    da, db = (part[free] for part in structure.derivatives(structure.values))
    c = structure.output_matrix()
    values = np.zeros((len(frequencies), len(c), b.shape[1]), dtype=np.complex128)
    deviation = np.zeros(values.shape)
    usable = np.where(np.isfinite(covariance), covariance, 0.0)
    for index, omega in enumerate(frequencies):
        pencil = 1j * omega * np.eye(len(a)) - a
        state = solve(pencil, b)
        values[index] = c @ state
        slopes = c @ np.linalg.solve(pencil, da @ state + db)
        variance = np.einsum("rpm,rs,spm->pm", slopes, usable, slopes.conj()).real
        deviation[index] = np.sqrt(np.maximum(variance, 0.0))
    return Response(frequencies, values, deviation)
