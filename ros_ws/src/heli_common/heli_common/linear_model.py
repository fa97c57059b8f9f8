"""Linear models with named signals, and the operating point about which they hold; SI and radians."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x' = A x + B u (or x+ = A x + B u), y = C x + D u, with a name for every signal.

    Attributes:
        states: n names, also none.
        inputs: m names.
        outputs: p names.
        A: shape (n, n). B: shape (n, m). C: shape (p, n). D: shape (p, m). Read-only copies.

    Raises:
        InputError: a name twice or empty, a wrong shape, a number that is not finite; its key is the
            attribute.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    A: Array
    B: Array
    C: Array
    D: Array

    def __post_init__(self) -> None:
        for key in ("states", "inputs", "outputs"):
            object.__setattr__(self, key, _names(getattr(self, key), key))
        n, m, p = len(self.states), len(self.inputs), len(self.outputs)
        for key, rows, columns in (("A", n, n), ("B", n, m), ("C", p, n), ("D", p, m)):
            object.__setattr__(self, key, fixed_matrix(getattr(self, key), rows, columns, key))

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of A, shape (n,), fastest first, the upper one of a pair before the lower."""
        values: NDArray[np.complex128] = np.linalg.eigvals(self.A).astype(np.complex128)
        order = np.lexsort((-values.imag, np.round(-np.abs(values), 9)))
        return np.asarray(values[order], dtype=np.complex128)

    def part(self, states: Sequence[str], inputs: Sequence[str], outputs: Sequence[str]) -> StateSpace:
        """The sub-model of the named states, inputs and outputs; all other deviations are held at zero.

        Raises:
            ValueError: a name the model does not have.
        """
        rows = positions(states, self.states, "state")
        columns = positions(inputs, self.inputs, "input")
        seen = positions(outputs, self.outputs, "output")
        return StateSpace(
            tuple(states),
            tuple(inputs),
            tuple(outputs),
            self.A[np.ix_(rows, rows)],
            self.B[np.ix_(rows, columns)],
            self.C[np.ix_(seen, rows)],
            self.D[np.ix_(seen, columns)],
        )

    def mapping(self) -> dict[str, Any]:
        """Names and nested lists, as they stand in a file."""
        names = {key: list(getattr(self, key)) for key in ("states", "inputs", "outputs")}
        return names | {key: getattr(self, key).tolist() for key in "ABCD"}


@dataclass(frozen=True)
class OperatingPoint:
    """Hover trim (source Table 2.3) in SI: angles [rad], velocities [m/s], torque [N m], current [A].

    Attributes:
        theta_0: collective [rad].
        theta_t: tail collective [rad].
        phi: roll [rad].
        theta: pitch [rad].
        B_1s: longitudinal cyclic [rad].
        A_1s: lateral cyclic [rad].
        a_1p: longitudinal flapping of the servo rotor [rad].
        b_1p: lateral flapping of the servo rotor [rad].
        V_i: induced velocity of the main rotor [m/s].
        V_t: induced velocity of the tail rotor [m/s].
        M_A: motor torque [N m].
        U_mot: control voltage of the motor supply [V].
        I_motor: motor current [A].
        Omega: rotor speed [rad/s].
    """

    theta_0: float
    theta_t: float
    phi: float
    theta: float
    B_1s: float
    A_1s: float
    a_1p: float
    b_1p: float
    V_i: float
    V_t: float
    M_A: float
    U_mot: float
    I_motor: float
    Omega: float

    def __post_init__(self) -> None:
        for key, value in asdict(self).items():
            object.__setattr__(self, key, _number(value, key))


def positions(names: Sequence[str], known: Sequence[str], kind: str) -> list[int]:
    """Where the names stand among the known ones.

    Raises:
        ValueError: a name that is not among them; `kind` says what it is a name of.
    """
    for name in names:
        if name not in known:
            raise ValueError(f"{kind} {name!r} is none of {', '.join(known)}")
    return [known.index(name) for name in names]


def fixed_matrix(value: Any, rows: int, columns: int, key: str) -> Array:
    """A read-only matrix of the given shape from an array or nested lists.

    Args:
        value: from code or from a file.
        rows: number of rows, also none.
        columns: number of columns, also none.
        key: names the matrix in errors.

    Raises:
        InputError: a wrong shape, or an entry that is no finite number; its key names the entry.
    """
    nested = value.tolist() if isinstance(value, np.ndarray) else value
    allowed = f"{rows} rows of {columns} numbers"
    if not isinstance(nested, (list, tuple)) or len(nested) != rows:
        found = f"{len(nested)} rows" if isinstance(nested, (list, tuple)) else short(nested)
        raise InputError(f"holds {found}", allowed=allowed, key=key)
    matrix = np.empty((rows, columns))
    for i, row in enumerate(nested):
        if not isinstance(row, (list, tuple)) or len(row) != columns:
            found = f"{len(row)} numbers" if isinstance(row, (list, tuple)) else short(row)
            raise InputError(f"holds {found}", allowed=allowed, key=f"{key}[{i}]")
        for j, number in enumerate(row):
            matrix[i, j] = _number(number, f"{key}[{i}][{j}]")
    matrix.setflags(write=False)
    return matrix


def _names(value: Any, key: str) -> tuple[str, ...]:
    if not isinstance(value, (list, tuple)):
        raise InputError(f"{short(value)} is no list", allowed="a list of names", key=key)
    for index, name in enumerate(value):
        if not isinstance(name, str) or not name.strip():
            raise InputError(f"{short(name)} is no name", allowed="a text", key=f"{key}[{index}]")
        if name in value[:index]:
            raise InputError(f"{name!r} occurs twice", allowed="every name once", key=f"{key}[{index}]")
    return tuple(value)


def _number(value: Any, key: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{short(value)} is not a number", allowed="a number such as 1.0e-3", key=key)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{short(value)} is not finite", allowed="a finite number", key=key)
    return number


def short(value: object) -> str:
    """The value as it is shown in an error, cut to 60 characters."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
