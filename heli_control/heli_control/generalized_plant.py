"""The generalised plant of an H-infinity problem (source eq. 3.19, 3.20), its scalings and its closed loop.

    x' = A  x + B1  w + B2  u        w disturbances, u controls
    z  = C1 x + D11 w + D12 u        z errors to be kept small
    y  = C2 x + D21 w + D22 u        y measurements

The controller is u = K y: any minus sign of a feedback belongs to the plant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from heli_common.linear_model import StateSpace
from heli_control.realisation import Array, Complex, Realisation, balanced, response, unnamed


@dataclass(frozen=True, eq=False)
class GeneralizedPlant:
    """P from (w, u) to (z, y).

    Attributes:
        A: shape (n, n). B1: (n, m1). B2: (n, m2). C1: (p1, n). C2: (p2, n).
        D11: shape (p1, m1). D12: (p1, m2). D21: (p2, m1). D22: (p2, m2).
        controls: m2 names of u; u_1, u_2 ... when not given.
        measurements: p2 names of y; y_1, y_2 ... when not given.

    Raises:
        ValueError: shapes that do not belong together, numbers that are not finite, no u or no y.
    """

    A: Array
    B1: Array
    B2: Array
    C1: Array
    C2: Array
    D11: Array
    D12: Array
    D21: Array
    D22: Array
    controls: tuple[str, ...] = ()
    measurements: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        p1, m1 = np.atleast_2d(self.D11).shape
        p2, m2 = np.atleast_2d(self.D22).shape
        n = len(self.A)
        if m2 == 0 or p2 == 0:
            raise ValueError(f"{m2} controls and {p2} measurements; allowed: at least one of each")
        shapes = {
            "A": (n, n), "B1": (n, m1), "B2": (n, m2), "C1": (p1, n), "C2": (p2, n),
            "D11": (p1, m1), "D12": (p1, m2), "D21": (p2, m1), "D22": (p2, m2),
        }  # fmt: skip
        for name, shape in shapes.items():
            matrix = np.array(getattr(self, name), dtype=np.float64)
            if matrix.size != shape[0] * shape[1]:
                raise ValueError(f"{name} has shape {matrix.shape}; allowed: {shape}")
            if not np.isfinite(matrix).all():
                raise ValueError(f"{name} holds a number that is not finite; allowed: finite numbers")
            matrix = matrix.reshape(shape)
            matrix.setflags(write=False)
            object.__setattr__(self, name, matrix)
        for name, letter, count in (("controls", "u", m2), ("measurements", "y", p2)):
            given = tuple(getattr(self, name)) or tuple(f"{letter}_{index + 1}" for index in range(count))
            if len(given) != count:
                raise ValueError(f"{len(given)} {name}; allowed: {count}")
            object.__setattr__(self, name, given)

    @property
    def whole(self) -> Realisation:
        """From (w, u) to (z, y) as one system."""
        b, c = np.hstack((self.B1, self.B2)), np.vstack((self.C1, self.C2))
        return Realisation(self.A, b, c, np.block([[self.D11, self.D12], [self.D21, self.D22]]))

    @property
    def sizes(self) -> tuple[int, int, int, int]:
        """Numbers of disturbances, controls, errors and measurements: m1, m2, p1, p2."""
        return self.B1.shape[1], self.B2.shape[1], self.C1.shape[0], self.C2.shape[0]

    def with_whole(self, system: Realisation) -> GeneralizedPlant:
        """The plant of the same signals with other matrices."""
        m1, _, p1, _ = self.sizes
        a, b, c, d = system
        return replace(
            self, A=a, B1=b[:, :m1], B2=b[:, m1:], C1=c[:p1], C2=c[p1:],
            D11=d[:p1, :m1], D12=d[:p1, m1:], D21=d[p1:, :m1], D22=d[p1:, m1:],
        )  # fmt: skip


def partitioned(system: StateSpace, controls: Sequence[str], measurements: Sequence[str]) -> GeneralizedPlant:
    """A system with names as a generalised plant; other inputs are disturbances, other outputs errors.

    Raises:
        ValueError: a name the system does not have.
    """
    inputs = [name for name in system.inputs if name not in controls]
    outputs = [name for name in system.outputs if name not in measurements]
    ordered = system.part(system.states, (*inputs, *controls), (*outputs, *measurements))
    return from_whole(unnamed(ordered), tuple(controls), tuple(measurements))


def from_whole(
    system: Realisation, controls: tuple[str, ...], measurements: tuple[str, ...]
) -> GeneralizedPlant:
    """The plant whose last inputs are `controls` and whose last outputs are `measurements`."""
    m1, p1 = system.B.shape[1] - len(controls), system.C.shape[0] - len(measurements)
    a, b, c, d = system
    return GeneralizedPlant(
        a, b[:, :m1], b[:, m1:], c[:p1], c[p1:],
        d[:p1, :m1], d[:p1, m1:], d[p1:, :m1], d[p1:, m1:], controls, measurements,
    )  # fmt: skip


def with_balanced_states(plant: GeneralizedPlant) -> GeneralizedPlant:
    """The same plant with states scaled by powers of two; the controller needs no scaling back."""
    return plant.with_whole(balanced(plant.whole)[0])


@dataclass(frozen=True, eq=False)
class Normalised:
    """A plant with D12 = [0; I], D21 = [0 I], D22 = 0, and the way back.

    z and w are turned by orthogonal matrices, which leaves the norm as it is.
    u = `control` u', y' = `measure` y.
    """

    plant: GeneralizedPlant
    control: Array
    measure: Array
    d22: Array

    def controller(self, inner: Realisation) -> Realisation:
        """The controller of the plant as given from that of the normalised one.

        Raises:
            ValueError: the loop through D22 is not well posed.
        """
        a, b = inner.A, inner.B @ self.measure
        c, d = self.control @ inner.C, self.control @ inner.D @ self.measure
        # u = K (y - D22 u)
        loop = np.eye(d.shape[0]) + d @ self.d22
        if np.linalg.cond(loop) > 1e12:
            raise ValueError("I + D_K D22 is singular: the loop through D22 is not well posed")
        back = np.linalg.inv(loop)
        rest = self.d22 @ back
        return Realisation(a - b @ rest @ c, b - b @ rest @ d, back @ c, back @ d)


def normalised(plant: GeneralizedPlant) -> Normalised:
    """Scale u and y, turn z and w (Glover and Doyle 1988; Zhou 1996, sec. 17.2).

    Raises:
        ValueError: D12 has no full column rank or D21 no full row rank.
    """
    m1, m2, p1, p2 = plant.sizes
    for name, matrix, rank in (("D12", plant.D12, m2), ("D21", plant.D21, p2)):
        if min(matrix.shape) < rank or np.linalg.matrix_rank(matrix) < rank:
            raise ValueError(f"{name} of shape {matrix.shape} has no rank {rank}")
    left, s12, control = np.linalg.svd(plant.D12)
    error_turn = np.vstack((left[:, m2:].T, left[:, :m2].T))
    to_control = control.T / s12
    measure, s21, right = np.linalg.svd(plant.D21)
    to_measure = measure.T / s21[:, None]
    turn = np.vstack((right[p2:], right[:p2])).T
    inner = replace(
        plant,
        B1=plant.B1 @ turn,
        B2=plant.B2 @ to_control,
        C1=error_turn @ plant.C1,
        C2=to_measure @ plant.C2,
        D11=error_turn @ plant.D11 @ turn,
        D12=np.vstack((np.zeros((p1 - m2, m2)), np.eye(m2))),
        D21=np.hstack((np.zeros((p2, m1 - p2)), np.eye(p2))),
        D22=np.zeros((p2, m2)),
    )
    return Normalised(inner, to_control, to_measure, plant.D22)


def lower_lft(plant: GeneralizedPlant, controller: Realisation) -> Realisation:
    """The closed loop from w to z with u = K y (source eq. 3.20); states of plant, then controller.

    Raises:
        ValueError: I - D22 D_K is singular, or the controller has other inputs and outputs than the plant.
    """
    if controller.D.shape != (plant.sizes[1], plant.sizes[3]):
        raise ValueError(f"controller of {controller.D.shape}; allowed: {(plant.sizes[1], plant.sizes[3])}")
    loop = np.eye(plant.sizes[3]) - plant.D22 @ controller.D
    if np.linalg.cond(loop) > 1e12:
        raise ValueError("I - D22 D_K is singular: the loop is not well posed")
    through = np.linalg.inv(loop)
    # u = direct (C2 x + D21 w) + own x_K,   y = through (C2 x + D21 w + D22 C_K x_K)
    direct = controller.D @ through
    own = controller.C + direct @ plant.D22 @ controller.C
    into = controller.B @ through
    a = np.block(
        [
            [plant.A + plant.B2 @ direct @ plant.C2, plant.B2 @ own],
            [into @ plant.C2, controller.A + into @ plant.D22 @ controller.C],
        ]
    )
    b = np.vstack((plant.B1 + plant.B2 @ direct @ plant.D21, into @ plant.D21))
    c = np.hstack((plant.C1 + plant.D12 @ direct @ plant.C2, plant.D12 @ own))
    return Realisation(a, b, c, plant.D11 + plant.D12 @ direct @ plant.D21)


def closed_response(plant: GeneralizedPlant, controller: Realisation, omega: Array) -> Complex:
    """The closed loop at j omega from the responses of plant and controller, without a common state space.

    Args:
        plant: without poles at these frequencies, nor the controller.
        controller: u = K y.
        omega: shape (k,) [rad/s].

    Returns:
        shape (k, p1, m1).
    """
    m1, _, p1, p2 = plant.sizes
    p, k = response(plant.whole, omega), response(controller, omega)
    loop = np.eye(p2) - p[:, p1:, m1:] @ k
    return np.asarray(
        p[:, :p1, :m1] + p[:, :p1, m1:] @ k @ np.linalg.solve(loop, p[:, p1:, :m1]), dtype=np.complex128
    )
