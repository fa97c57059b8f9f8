"""Least squares in Euler form: start values for everything else (source eq. 2.70-2.74).

    (x(k+1) - x(k)) / T = A x(k) + B u(k) + c + noise

is linear in the coefficients, row by row, once all states are known. States that are not measured are
reconstructed from the measured ones with the coefficients as they are (the servo rotor's equations hold
nothing but k). The estimate is biased by noise in x, the more the faster the sampling: average the
data before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.signal import dlsim

from heli_common.errors import InputError
from heli_identification.parametrisation import Noise
from heli_identification.prediction_error import Estimate
from heli_identification.records import Record
from heli_identification.residual_tests import residuals_white
from heli_identification.structures import Structure, Term
from heli_identification.uncertainty import weaknesses

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """Result of the regression.

    Attributes:
        structure: with the estimated values.
        names: of the estimated parameters, r of them.
        values: shape (r,).
        covariance: shape (r, r), of white equation errors.
        variance: of the equation error of every measured state, per step, shape (p,).
    """

    structure: Structure
    names: tuple[str, ...]
    values: Array
    covariance: Array
    variance: Array


def least_squares(structure: Structure, records: Sequence[Record]) -> LeastSquares:
    """Regress the free parameters that stand alone, to first power, in rows of measured states.

    Args:
        structure: what is to be estimated, its values for all other parameters.
        records: data, every piece with a constant of its own.

    Raises:
        InputError: the data do not determine a row.
    """
    free = set(structure.free_names)
    values = dict(zip(structure.names, structure.values.tolist(), strict=True))
    names: list[str] = []
    estimates: list[float] = []
    blocks: list[Array] = []
    variance = np.zeros(len(structure.outputs))
    known = [_all_states(structure, record) for record in records]
    for output, state in enumerate(structure.outputs):
        terms = [term for term in structure.terms if term.row == state]
        wanted = list(dict.fromkeys(n for t in terms for n, e in t.powers if n in free and _alone(t)))
        left, right = _row(structure, terms, wanted, values, state, records, known)
        unit = np.sqrt(np.mean(right**2, axis=0))
        if np.any(unit == 0.0):
            name = [*wanted, *("a constant",) * len(records)][int(np.argmin(unit))]
            raise InputError(f"nothing in the data moves {name}", allowed="excited data", key=f"{state}'")
        solution, _, rank, _ = np.linalg.lstsq(right / unit, left, rcond=1e-10)
        if rank < right.shape[1]:
            allowed = "inputs and states that move independently"
            raise InputError(
                f"{', '.join(wanted)} cannot be told apart in these data", allowed=allowed, key=f"{state}'"
            )
        error = left - (right / unit) @ solution
        spread = float(error @ error) / max(1, len(left) - right.shape[1])
        variance[output] = spread * records[0].period ** 2
        if wanted:
            count = len(wanted)
            inverse = np.linalg.inv((right / unit).T @ (right / unit))
            names += wanted
            estimates += (solution / unit)[:count].tolist()
            blocks.append(spread * (inverse / np.outer(unit, unit))[:count, :count])
    covariance = np.zeros((len(names), len(names)))
    place = 0
    for block in blocks:
        covariance[place : place + len(block), place : place + len(block)] = block
        place += len(block)
    started = structure.with_values(dict(zip(names, estimates, strict=True)))
    return LeastSquares(started, tuple(names), np.array(estimates), covariance, variance)


def _alone(term: Term) -> bool:
    return len(term.powers) == 1 and term.powers[0][1] == 1


def _row(
    structure: Structure,
    terms: Sequence[Term],
    wanted: Sequence[str],
    values: dict[str, float],
    state: str,
    records: Sequence[Record],
    known: Sequence[Array],
) -> tuple[Array, Array]:
    """Left hand side, shape (N,), and regressors, shape (N, wanted + constants), of one row."""
    left, right = [], []
    for place, (record, states) in enumerate(zip(records, known, strict=True)):
        signals = {name: states[:-1, i] for i, name in enumerate(structure.states)}
        signals |= {name: record.u[:-1, i] for i, name in enumerate(record.inputs)}
        side = np.diff(states[:, structure.states.index(state)]) / record.period
        columns = np.zeros((len(side), len(wanted) + len(records)))
        columns[:, len(wanted) + place] = 1.0
        for term in terms:
            signal = term.factor * signals[term.column]
            if _alone(term) and term.powers[0][0] in wanted:
                columns[:, wanted.index(term.powers[0][0])] += signal
            else:
                for name, power in term.powers:
                    signal = signal * values[name] ** power
                side = side - signal
        left.append(side)
        right.append(columns)
    return np.concatenate(left), np.vstack(right)


def _all_states(structure: Structure, record: Record) -> Array:
    """Measured states as they are, the others from their own equations, shape (N, n)."""
    a, b = structure.matrices(structure.values)
    seen = [structure.states.index(name) for name in structure.outputs]
    hidden = [index for index in range(len(structure.states)) if index not in seen]
    states = np.zeros((len(record), len(structure.states)))
    states[:, seen] = record.y
    if hidden:
        own, drive = a[np.ix_(hidden, hidden)], np.hstack((a[np.ix_(hidden, seen)], b[hidden]))
        size = len(own)
        whole = np.zeros((size + drive.shape[1],) * 2)
        whole[:size, :size], whole[:size, size:] = own, drive
        held = expm(whole * record.period)
        system = (held[:size, :size], held[:size, size:], np.eye(size), np.zeros((size, drive.shape[1])), 1.0)
        _, _, found = dlsim(system, np.hstack((record.y, record.u)))
        states[:, hidden] = found
    return states


def regression_estimate(result: LeastSquares, records: Sequence[Record]) -> Estimate:
    """The regression as an estimate like any other; its residuals are those of the equations.

    Args:
        result: of `least_squares`.
        records: it was computed from.
    """
    structure = result.structure.with_free(result.names)
    order = [result.names.index(name) for name in structure.free_names]
    residuals = tuple(_equation_errors(structure, record) for record in records)
    moment = np.sum([part.T @ part for part in residuals], axis=0) / sum(len(part) for part in residuals)
    covariance = result.covariance[np.ix_(order, order)]
    n = len(structure.states)
    values = result.values[order]
    return Estimate(
        structure=structure,
        names=structure.free_names,
        values=values,
        fisher=covariance,
        robust=covariance,
        white=residuals_white(residuals),
        noise=Noise.OUTPUT_ERROR,
        noise_names=(),
        noise_values=np.zeros(0),
        K=np.zeros((n, len(structure.outputs))),
        weighting=moment,
        residuals=residuals,
        starts=tuple(_all_states(structure, record)[0] for record in records),
        offsets=tuple(np.zeros(len(structure.outputs)) for _ in records),
        converged=True,
        steps=(),
        weak=weaknesses(
            structure.free_names, covariance, structure.scales[structure.index(structure.free_names)]
        ),
    )


def _equation_errors(structure: Structure, record: Record) -> Array:
    """What Euler's step leaves of every measured state, per step, mean removed, shape (N - 1, p)."""
    a, b = structure.matrices(structure.values)
    states = _all_states(structure, record)
    seen = [structure.states.index(name) for name in structure.outputs]
    slope = (states[:-1] @ a.T + record.u[:-1] @ b.T)[:, seen]
    error = np.diff(states[:, seen], axis=0) - record.period * slope
    centred: Array = error - error.mean(axis=0)
    return centred
