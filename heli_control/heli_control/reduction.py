"""Order reduction of a continuous system by balancing, with its error bound (Moore 1981, Glover 1984).

The part that does not decay, integrators included, is split off and kept. Of the rest, the states are turned
so that they are as controllable as observable; leaving out the last of them changes the response by

    |G - G_r|  <=  2 (sigma_(r+1) + ... + sigma_n)          sigma: Hankel singular values

at every frequency. Instead of being left out they may be held at rest (Liu and Anderson 1989): the same
bound, but exact at s = 0 instead of infinity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import schur, solve_continuous_lyapunov, solve_sylvester

from heli_control.hinf_norm import hinf_norm
from heli_control.realisation import Array, Realisation, diagonal

_DECAYS = 1e-8
"""A mode decays when its real part is below -_DECAYS times the norm of A; slower ones are kept."""

_NOTHING = 1e-13
"""Hankel singular values below this share of the largest are rounding."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """A system of lower order and what that costs.

    Attributes:
        system: reduced; the modes that do not decay come last.
        order: states before.
        kept: modes that do not decay, all in `system`.
        hankel: singular values of the decaying part, descending, shape (order - kept,).
        bound: of the error, twice the sum of those left out.
        error: H-infinity norm of the difference, measured.
        norm: H-infinity norm of the decaying part, for comparison.
    """

    system: Realisation
    order: int
    kept: int
    hankel: Array
    bound: float
    error: float
    norm: float


@dataclass(frozen=True, eq=False)
class Balancing:
    """A system in two parts, ready to be cut at any order.

    Attributes:
        decaying: balanced, states in the order of `hankel`; carries the direct feedthrough.
        lasting: the part that does not decay.
        hankel: singular values of `decaying`, descending.
        norm: H-infinity norm of `decaying`.
    """

    decaying: Realisation
    lasting: Realisation
    hankel: Array
    norm: float


def parts(system: Realisation) -> tuple[Realisation, Realisation]:
    """The decaying part, with D, and the part that does not decay; their sum is the system."""
    m, p = system.B.shape[1], system.C.shape[0]
    nothing = Realisation(np.zeros((0, 0)), np.zeros((0, m)), np.zeros((p, 0)), np.zeros((p, m)))
    if not system.order:
        return system, nothing
    limit = -_DECAYS * float(np.linalg.norm(system.A, 2))
    form, basis, count = schur(system.A, sort=lambda real, _: real < limit)
    if count == system.order:
        return system, nothing
    if count == 0:
        return nothing._replace(D=system.D), system._replace(D=np.zeros((p, m)))
    a, coupling, other = form[:count, :count], form[:count, count:], form[count:, count:]
    # x_1 = z + T x_2 takes the coupling away: A_1 T - T A_2 = -coupling
    turn = solve_sylvester(a, -other, -coupling)
    b, c = basis.T @ system.B, system.C @ basis
    lasting = Realisation(other, b[count:], c[:, count:] + c[:, :count] @ turn, np.zeros((p, m)))
    return Realisation(a, b[:count] - turn @ b[count:], c[:, :count], system.D), lasting


def balancing(system: Realisation) -> Balancing:
    """Hankel singular values of the decaying part and its balanced states (square-root method).

    States that neither input nor output sees are left out at once.
    """
    decaying, lasting = parts(system)
    if not decaying.order:
        return Balancing(decaying, lasting, np.zeros(0), hinf_norm(decaying).value)
    a, b, c, d = decaying
    reach = _root(solve_continuous_lyapunov(a, -b @ b.T))
    seen = _root(solve_continuous_lyapunov(a.T, -c.T @ c))
    left, hankel, right = np.linalg.svd(seen.T @ reach)
    count = int(np.count_nonzero(hankel > _NOTHING * max(float(hankel[0]), np.finfo(float).tiny)))
    scale = 1.0 / np.sqrt(hankel[:count])
    into, out = reach @ right[:count].T * scale, (seen @ left[:, :count] * scale).T
    balanced = Realisation(out @ a @ into, out @ b, c @ into, d)
    return Balancing(balanced, lasting, np.asarray(hankel, dtype=np.float64), hinf_norm(decaying).value)


def reduced(system: Realisation, order: int, *, at_rest: bool = False) -> Reduction:
    """The system with `order` states at most, the lasting modes among them.

    Args:
        system: continuous.
        order: of the result, at least the number of modes that do not decay.
        at_rest: hold the states left out at rest instead of leaving them out: keeps the gain at s = 0.

    Raises:
        ValueError: an order that is negative or leaves a lasting mode out.
    """
    form = balancing(system)
    if not form.lasting.order <= order:
        raise ValueError(f"order {order}; allowed: at least the {form.lasting.order} modes that do not decay")
    return _cut(system, form, order - form.lasting.order, at_rest)


def reduced_within(system: Realisation, tolerance: float, *, at_rest: bool = False) -> Reduction:
    """The lowest order whose error bound stays within a share of the decaying part's norm.

    Args:
        system: continuous.
        tolerance: relative, above 0.
        at_rest: see `reduced`.

    Raises:
        ValueError: a tolerance that is not positive.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance {tolerance}; allowed: above 0")
    form = balancing(system)
    bounds = np.array([_bound(form.hankel, count) for count in range(form.decaying.order + 1)])
    enough = np.flatnonzero(bounds <= tolerance * form.norm)
    count = int(enough[0]) if enough.size else form.decaying.order
    return _cut(system, form, count, at_rest)


def _cut(system: Realisation, form: Balancing, count: int, at_rest: bool) -> Reduction:
    count = min(count, form.decaying.order)
    a, b, c, d = form.decaying
    short = Realisation(a[:count, :count], b[:count], c[:, :count], d)
    if at_rest and count < form.decaying.order:
        rest = a[count:, count:]
        back = np.linalg.solve(rest, np.hstack((a[count:, :count], b[count:])))
        x, u = back[:, :count], back[:, count:]
        coupling, seen = a[:count, count:], c[:, count:]
        short = Realisation(
            short.A - coupling @ x, short.B - coupling @ u, short.C - seen @ x, short.D - seen @ u
        )
    whole, lasting = parts(system)[0], form.lasting
    both = diagonal(whole, short)
    error = hinf_norm(
        Realisation(
            both.A,
            np.vstack((whole.B, short.B)),
            np.hstack((whole.C, -short.C)),
            whole.D - short.D,
        )
    )
    together = diagonal(short, lasting)
    result = Realisation(
        together.A, np.vstack((short.B, lasting.B)), np.hstack((short.C, lasting.C)), short.D
    )
    bound = _bound(form.hankel, count)
    return Reduction(result, system.order, lasting.order, form.hankel, bound, error.value, form.norm)


def _bound(hankel: Array, count: int) -> float:
    return 2.0 * float(hankel[count:].sum())


def _root(gramian: Array) -> Array:
    """L with L L' the matrix, which is symmetric and, but for rounding, not negative."""
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)), dtype=np.float64)
