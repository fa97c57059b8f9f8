"""H-infinity synthesis by two Riccati equations for any D11 (Glover and Doyle 1988; Zhou 1996, theorem 17.1).

On the normalised plant, D12 = [0; I], D21 = [0 I], D22 = 0, a controller with a norm below gamma exists iff

    gamma > max( |[D1111 D1112]|, |[D1111' D1121']| ),
    X >= 0 solves the first equation, Y >= 0 the second, and the spectral radius of X Y is below gamma^2.

The optimal gamma is the infimum of those, found by bisection; the central controller of a larger gamma has a
closed form.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import schur

from heli_control.assumptions import feedthrough_floor
from heli_control.generalized_plant import GeneralizedPlant, normalised
from heli_control.realisation import Array, Realisation

_HIGHEST = 1e9
_NOTHING = 1e-7
_POSITIVE = 1e-8
NO_OPTIMUM = "the errors can be made as small as one likes: there is no optimal gamma"


class NoController(ValueError):
    """No controller for this gamma, or none to be found; the message says why.

    Args:
        reason: in one line.
        final: no scaling and no other gamma will help.
    """

    def __init__(self, reason: str, *, final: bool = False) -> None:
        super().__init__(reason)
        self.final = final


class _Solution(NamedTuple):
    """Both solutions of a normalised plant with gamma, and the gains F (m, n) and L (n, p) of them."""

    X: Array
    Y: Array
    F: Array
    L: Array


def optimal_gamma(plant: GeneralizedPlant, tolerance: float = 2e-5) -> float:
    """The smallest gamma for which a controller exists, from above.

    Args:
        plant: that meets A1 to A5.
        tolerance: relative.

    Raises:
        NoController: none up to 1e9, no lower bound, or the plant cannot be normalised.
    """
    try:
        inner = normalised(plant).plant
    except ValueError as error:
        raise NoController(str(error)) from None
    floor = feedthrough_floor(inner)
    low, high = floor, max(1.0, 2.0 * floor)
    while not admissible(inner, high):
        low, high = high, 8.0 * high
        if high > _HIGHEST:
            raise NoController(f"no controller with gamma up to {_HIGHEST:g}: {_reason(inner, _HIGHEST)}")
    start = high
    while high - low > tolerance * high and high > _NOTHING * start:
        # the first steps down are large, for the floor may be far off, or zero
        middle = low + (high - low) / 8.0 if low == floor else math.sqrt(low * high)
        if admissible(inner, middle):
            high = middle
        else:
            low = middle
    if high <= _NOTHING * start:
        raise NoController(NO_OPTIMUM, final=True)
    return high


def admissible(inner: GeneralizedPlant, gamma: float) -> bool:
    """Whether a normalised plant has a controller with a norm below gamma."""
    return _reason(inner, gamma) == ""


def central_controller(plant: GeneralizedPlant, gamma: float) -> Realisation:
    """The central controller, u = K y.

    Args:
        plant: that meets A1 to A5.
        gamma: above the optimum.

    Returns:
        n states.

    Raises:
        NoController: gamma is too small, or the loop through D22 is not well posed.
    """
    try:
        scaled = normalised(plant)
    except ValueError as error:
        raise NoController(str(error)) from None
    inner = scaled.plant
    m1, m2, p1, p2 = inner.sizes
    x, y, f, obs = _solve(inner, gamma)
    _check(x, y, gamma)
    m, p = m1 - p2, p1 - m2
    d1111, d1112 = inner.D11[:p, :m], inner.D11[:p, m:]
    d1121, d1122 = inner.D11[p:, :m], inner.D11[p:, m:]
    f12, f2 = f[m:m1], f[m1:]
    l12, l2 = obs[:, p:p1], obs[:, p1:]
    square = gamma**2
    d11 = -d1121 @ d1111.T @ np.linalg.solve(square * np.eye(p) - d1111 @ d1111.T, d1112) - d1122
    z = np.linalg.inv(np.eye(len(x)) - y @ x / square)
    b1 = z @ (-l2 + (inner.B2 + l12) @ d11)
    c1 = f2 - d11 @ (inner.C2 + f12)
    a = inner.A + np.hstack((inner.B1, inner.B2)) @ f - b1 @ (inner.C2 + f12)
    try:
        return scaled.controller(Realisation(a, b1, c1, d11))
    except ValueError as error:
        raise NoController(str(error)) from None


def riccati(a: Array, r: Array, q: Array) -> Array:
    """The stabilising solution of A'X + X A + X R X + Q = 0.

    Args:
        a: shape (n, n). r, q: symmetric, shape (n, n), of any sign.

    Returns:
        X, symmetric, with A + R X stable.

    Raises:
        NoController: the Hamiltonian has eigenvalues on the imaginary axis, or X is infinite.
    """
    n = len(a)
    if n == 0:
        return np.zeros((0, 0))
    # X = share X' with blocks of like size. A tiny Q must not be blown up: it may be rounding alone
    size = float(np.abs(r).max())
    share = (
        max(math.sqrt(size * float(np.abs(q).max())), float(np.abs(a).max())) / size if size > 0.0 else 1.0
    )
    share = share or 1.0
    hamiltonian = np.block([[a, share * r], [-q / share, -a.T]])
    _, basis, stable = schur(hamiltonian, sort="lhp")
    if stable != n:
        raise NoController("the Hamiltonian has eigenvalues on the imaginary axis")
    top, bottom = basis[:n, :n], basis[n:, :n]
    skew = top.T @ bottom
    if np.abs(skew - skew.T).max() > 1e-7:
        raise NoController("the Hamiltonian has eigenvalues on the imaginary axis")
    if np.linalg.cond(top) > 1e13:
        raise NoController("the Riccati equation has no finite solution")
    x = share * np.linalg.solve(top.T, bottom.T).T
    return 0.5 * (x + x.T)


def _solve(inner: GeneralizedPlant, gamma: float) -> _Solution:
    m1, _, p1, _ = inner.sizes
    b, c = np.hstack((inner.B1, inner.B2)), np.vstack((inner.C1, inner.C2))
    d1, d_1 = np.hstack((inner.D11, inner.D12)), np.vstack((inner.D11, inner.D21))
    r = d1.T @ d1
    r[:m1, :m1] -= gamma**2 * np.eye(m1)
    r_dual = d_1 @ d_1.T
    r_dual[:p1, :p1] -= gamma**2 * np.eye(p1)
    x, f = _regulator(inner.A, b, inner.C1, d1, r)
    y, obs = _regulator(inner.A.T, c.T, inner.B1.T, d_1.T, r_dual)
    return _Solution(x, y, f, obs.T)


def _regulator(a: Array, b: Array, c: Array, d: Array, r: Array) -> tuple[Array, Array]:
    """X of the problem with errors c x + d u and the indefinite weight r, and F = -R^-1 (d'c + b'X)."""
    try:
        solved = np.linalg.solve(r, np.hstack((d.T @ c, b.T)))
    except np.linalg.LinAlgError:
        raise NoController("gamma is a singular value of D11") from None
    n = len(a)
    rest, weighted = solved[:, :n], solved[:, n:]
    x = riccati(a - b @ rest, -b @ weighted, c.T @ (c - d @ rest))
    return x, -rest - weighted @ x


def _check(x: Array, y: Array, gamma: float) -> None:
    for name, solution in (("X", x), ("Y", y)):
        values = np.linalg.eigvalsh(solution)
        if values.size and values[0] < -_POSITIVE * max(1.0, abs(values[-1])):
            raise NoController(f"{name} is not positive semidefinite: smallest eigenvalue {values[0]:.3g}")
    if len(x):
        radius = float(np.abs(np.linalg.eigvals(x @ y)).max())
        if radius >= gamma**2:
            raise NoController(f"the spectral radius of X Y is {radius:.6g}, gamma^2 {gamma**2:.6g}")


def _reason(inner: GeneralizedPlant, gamma: float) -> str:
    """Why a normalised plant has no controller with gamma; empty if it has one."""
    floor = feedthrough_floor(inner)
    if gamma <= floor:
        return f"gamma {gamma:.6g} is not above {floor:.6g}, which D11 sets (A2)"
    try:
        x, y, _, _ = _solve(inner, gamma)
        _check(x, y, gamma)
    except NoController as error:
        return str(error)
    except np.linalg.LinAlgError as error:
        return f"the Hamiltonian has no Schur form: {error}"
    return ""
