"""Grey-box structures: linear models whose entries are products of named parameters.

    x' = A(theta) x + B(theta) u,   y = C x

Every entry of A and B is a sum of terms  factor * theta_1^e_1 * theta_2^e_2 ..., so matrices and their
derivatives with respect to the parameters are closed formulas. The helicopter's own structures stand in
`helicopter_structures`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """One coefficient of a structure.

    Attributes:
        name: as in the source's equations.
        value: prior value, also the start of an estimation, SI.
        scale: expected size, positive; estimation works on value / scale (source 2.5.1, step 2).
        unit: of the value.
        free: whether it is estimated; otherwise it stays at its value.
        reason: why it is not estimated by default, empty if it is.
    """

    name: str
    value: float
    scale: float
    unit: str
    free: bool = True
    reason: str = ""


@dataclass(frozen=True)
class Term:
    """One summand of one entry: factor times powers of parameters.

    Attributes:
        row: name of a state, whose derivative the entry is part of.
        column: name of a state (entry of A) or of an input (entry of B).
        factor: constant.
        powers: parameter name and exponent, also none.
    """

    row: str
    column: str
    factor: float
    powers: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, eq=False)
class Structure:
    """A parametrised linear model; the value object everything in this package works on.

    Attributes:
        name: of the structure.
        states: n names.
        inputs: m names.
        outputs: p names of states that are measured.
        parameters: in the order of every parameter vector, r of them.
        terms: entries of A and B.
        stages: names of the parameters that are freed step by step, in this order (source 2.5.1, step 1).

    Raises:
        ValueError: a name twice, a term about an unknown name, a stage of an unknown parameter.
    """

    name: str
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    terms: tuple[Term, ...]
    stages: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        names = self.names
        if len(set(names)) != len(names):
            raise ValueError(f"{self.name}: a parameter occurs twice")
        for term in self.terms:
            if term.row not in self.states or term.column not in (*self.states, *self.inputs):
                raise ValueError(f"{self.name}: no entry {term.row}, {term.column}")
        used = [name for term in self.terms for name, _ in term.powers]
        for name in (*used, *(name for stage in self.stages for name in stage)):
            if name not in names:
                raise ValueError(f"{self.name}: {name!r} is none of {', '.join(names)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all parameters."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def free_names(self) -> tuple[str, ...]:
        """Names of the parameters that are estimated."""
        return tuple(parameter.name for parameter in self.parameters if parameter.free)

    @property
    def values(self) -> Array:
        """Values of all parameters, shape (r,)."""
        return np.array([parameter.value for parameter in self.parameters])

    @property
    def scales(self) -> Array:
        """Expected sizes of all parameters, shape (r,)."""
        return np.array([parameter.scale for parameter in self.parameters])

    def index(self, names: Sequence[str]) -> list[int]:
        """Positions of parameters.

        Raises:
            InputError: a name the structure does not have.
        """
        for name in names:
            if name not in self.names:
                raise InputError(f"no parameter {name!r}", allowed=", ".join(self.names), key=self.name)
        return [self.names.index(name) for name in names]

    def with_values(self, values: Mapping[str, float]) -> Structure:
        """The same structure with other values.

        Raises:
            InputError: a name the structure does not have.
        """
        self.index(tuple(values))
        changed = [replace(each, value=float(values.get(each.name, each.value))) for each in self.parameters]
        return replace(self, parameters=tuple(changed))

    def with_free(self, names: Sequence[str]) -> Structure:
        """The same structure with exactly these parameters free.

        Raises:
            InputError: a name the structure does not have.
        """
        self.index(names)
        changed = [replace(each, free=each.name in names) for each in self.parameters]
        return replace(self, parameters=tuple(changed))

    def matrices(self, values: Array) -> tuple[Array, Array]:
        """A, shape (n, n), and B, shape (n, m), of parameter values, shape (r,)."""
        a, b = np.zeros((len(self.states),) * 2), np.zeros((len(self.states), len(self.inputs)))
        known = dict(zip(self.names, values.tolist(), strict=True))
        for term in self.terms:
            product = term.factor
            for name, power in term.powers:
                product *= known[name] ** power
            matrix, column = self._place(term, a, b)
            matrix[self.states.index(term.row), column] += product
        return a, b

    def derivatives(self, values: Array) -> tuple[Array, Array]:
        """dA/dtheta, shape (r, n, n), and dB/dtheta, shape (r, n, m), at values, shape (r,)."""
        n, m = len(self.states), len(self.inputs)
        da, db = np.zeros((len(values), n, n)), np.zeros((len(values), n, m))
        known = dict(zip(self.names, values.tolist(), strict=True))
        for term in self.terms:
            row = self.states.index(term.row)
            for which, (name, power) in enumerate(term.powers):
                slope = term.factor * power * known[name] ** (power - 1)
                for other, (factor, exponent) in enumerate(term.powers):
                    if other != which:
                        slope *= known[factor] ** exponent
                index = self.names.index(name)
                matrix, column = self._place(term, da[index], db[index])
                matrix[row, column] += slope
        return da, db

    def output_matrix(self) -> Array:
        """C, shape (p, n): the states that are measured."""
        c = np.zeros((len(self.outputs), len(self.states)))
        for row, name in enumerate(self.outputs):
            c[row, self.states.index(name)] = 1.0
        return c

    def model(self, values: Array | None = None) -> StateSpace:
        """The continuous linear model of parameter values, shape (r,); by default of the structure's own."""
        a, b = self.matrices(self.values if values is None else values)
        c = self.output_matrix()
        return StateSpace(
            self.states, self.inputs, self.outputs, a, b, c, np.zeros((len(c), len(self.inputs)))
        )

    def from_model(self, model: StateSpace) -> Structure:
        """The structure with the values that a prior model has in its entries.

        Only parameters that alone make up an entry (factor 1, power 1) are read; the others keep their value.

        Raises:
            InputError: the model lacks a state or an input of the structure.
        """
        for wanted, known, key in (
            (self.states, model.states, "states"),
            (self.inputs, model.inputs, "inputs"),
        ):
            for name in wanted:
                if name not in known:
                    allowed = f"at least {', '.join(wanted)}"
                    raise InputError(f"{', '.join(known)} lacks {name!r}", allowed=allowed, key=key)
        part = model.part(self.states, self.inputs, ())
        read = {}
        for term in self.terms:
            alone = [t for t in self.terms if (t.row, t.column) == (term.row, term.column)] == [term]
            if alone and term.factor == 1.0 and len(term.powers) == 1 and term.powers[0][1] == 1:
                matrix, column = self._place(term, part.A, part.B)
                read[term.powers[0][0]] = float(matrix[self.states.index(term.row), column])
        return self.with_values(read)

    def _place(self, term: Term, a: Array, b: Array) -> tuple[Array, int]:
        if term.column in self.states:
            return a, self.states.index(term.column)
        return b, self.inputs.index(term.column)
