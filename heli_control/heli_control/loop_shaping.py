"""H-infinity loop shaping: robust stabilisation of normalised left coprime factors (source sec. 3.4).

The shaped plant G_s = W_2 G W_1 = M^-1 N with N N~ + M M~ = I. The smallest

    gamma = | [K; I] (I - G_s K)^-1 M^-1 |    is    gamma_min = sqrt(1 + lambda_max(X Z))     (eq. 3.36-3.38)

with X and Z of two Riccati equations, without iteration; the controller of a larger gamma has a closed form
(eq. 3.39). The feedback is positive here, u = K y with K = W_1 K_inf W_2, as in the source.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from heli_control.certificate import Certificate, certify
from heli_control.certified import SynthesisRefused
from heli_control.generalized_plant import GeneralizedPlant
from heli_control.pole_region import NYQUIST
from heli_control.realisation import Array, Realisation, balanced, gain, series
from heli_control.riccati_synthesis import NoController, riccati


@dataclass(frozen=True, eq=False)
class CoprimeFactors:
    """Normalised left coprime factors of a shaped plant.

    Attributes:
        plant: G_s with n states, m inputs, p outputs; states are balanced.
        X: control solution, shape (n, n). Z: filter solution, shape (n, n).
        S: I + D'D, shape (m, m). R: I + D D', shape (p, p).
        F: -S^-1 (D'C + B'X), shape (m, n). H: -(Z C' + B D') R^-1, shape (n, p).
        gamma_min: smallest gamma of eq. 3.36.
        scales: the states as given are these times those of `plant`, shape (n,).
    """

    plant: Realisation
    X: Array
    Z: Array
    S: Array
    R: Array
    F: Array
    H: Array
    gamma_min: float
    scales: Array


@dataclass(frozen=True, eq=False)
class Observer:
    """The controller of a strictly proper G_s as observer and state feedback (Sefton and Glover 1990).

        x' = A x + B u_s + H (C x - y_s),   u_s = F x

    In flight u_s in the first equation is what the limited actuators really got, taken back through W_1: so
    it does not wind up.

    Attributes:
        A, B, C: of G_s. H: shape (n, p). F: shape (m, n).
    """

    A: Array
    B: Array
    C: Array
    H: Array
    F: Array

    @property
    def controller(self) -> Realisation:
        """As one system from y_s to u_s, without saturation."""
        a = self.A + self.B @ self.F + self.H @ self.C
        return Realisation(a, -self.H, self.F, np.zeros((len(self.F), self.H.shape[1])))


@dataclass(frozen=True, eq=False)
class LoopShaping:
    """A certified one-degree-of-freedom design.

    Attributes:
        factors: of the shaped plant.
        gamma: asked for.
        inner: K_inf of the shaped plant, u_s = K_inf y_s.
        controller: W_1 K_inf W_2, u = K y.
        observer: the same K_inf for anti-windup; None if G_s has a direct feedthrough.
        certificate: closed loop of G_s with K_inf, recomputed.
    """

    factors: CoprimeFactors
    gamma: float
    inner: Realisation
    controller: Realisation
    observer: Observer | None
    certificate: Certificate


def coprime_factors(shaped: Realisation) -> CoprimeFactors:
    """Normalised left coprime factors and gamma_min of a shaped plant (eq. 3.34, 3.38).

    Raises:
        SynthesisRefused: a mode that does not decay is hidden from the input or the output (A1).
    """
    plant, scales = balanced(shaped)
    a, b, c, d = plant
    s, r = np.eye(d.shape[1]) + d.T @ d, np.eye(d.shape[0]) + d @ d.T
    inner = a - b @ np.linalg.solve(s, d.T @ c)
    b_s, c_r = b @ np.linalg.solve(s, b.T), c.T @ np.linalg.solve(r, c)
    try:
        x, z = riccati(inner, -b_s, c_r), riccati(inner.T, -c_r, b_s)
    except (NoController, np.linalg.LinAlgError) as error:
        raise SynthesisRefused(f"A1: the shaped plant cannot be stabilised and detected: {error}") from None
    largest = float(np.linalg.eigvals(x @ z).real.max(initial=0.0))
    f = -np.asarray(np.linalg.solve(s, d.T @ c + b.T @ x), dtype=np.float64)
    h = -np.asarray(np.linalg.solve(r, c @ z + d @ b.T), dtype=np.float64).T
    return CoprimeFactors(plant, x, z, s, r, f, h, math.sqrt(1.0 + max(largest, 0.0)), scales)


def loop_shaping(
    plant: Realisation,
    w_1: Realisation | None = None,
    w_2: Realisation | None = None,
    *,
    factor: float = 1.1,
    fastest_pole: float = NYQUIST,
) -> LoopShaping:
    """The central controller for gamma = factor gamma_min, certified.

    Args:
        plant: G, m inputs and p outputs; a minus sign of the feedback belongs to it or to the user of K.
        w_1: m inputs and outputs; None is the identity.
        w_2: p inputs and outputs; None is the identity.
        factor: above 1.
        fastest_pole: of K_inf [rad/s].

    Raises:
        SynthesisRefused: hidden modes, or the closed loop is not what it should be.
        ValueError: a factor not above 1.
    """
    if not 1.0 < factor < math.inf:
        raise ValueError(f"factor {factor}; allowed: above 1")
    before, after = with_identity(plant, w_1, w_2)
    factors = coprime_factors(series(after, series(plant, before)))
    gamma = factor * factors.gamma_min
    inner = central(factors, gamma)
    certificate = certify(four_blocks(factors.plant), inner, gamma, fastest_pole)
    if certificate.fault:
        raise SynthesisRefused(f"loop shaping with gamma_min {factors.gamma_min:.6g}: {certificate.fault}")
    observer = None if factors.plant.D.any() else observer_form(factors, gamma)
    whole = series(before, series(inner, after))
    return LoopShaping(factors, gamma, inner, whole, observer, certificate)


def central(factors: CoprimeFactors, gamma: float) -> Realisation:
    """K_inf of a gamma above gamma_min (eq. 3.39)."""
    _, b, c, d = factors.plant
    n = factors.plant.order
    z = gamma**2 * np.linalg.solve(((1.0 - gamma**2) * np.eye(n) + factors.X @ factors.Z).T, factors.Z)
    into = z @ c.T
    a = factors.plant.A + b @ factors.F + into @ (c + d @ factors.F)
    return Realisation(a, into, b.T @ factors.X, -d.T)


def observer_form(factors: CoprimeFactors, gamma: float) -> Observer:
    """Observer and state feedback of a gamma above gamma_min.

    Raises:
        ValueError: G_s has a direct feedthrough.
    """
    a, b, c, d = factors.plant
    if d.any():
        raise ValueError("the shaped plant has a direct feedthrough; allowed: strictly proper")
    inverse = (1.0 - gamma**-2) * np.eye(len(a)) - gamma**-2 * factors.X @ factors.Z
    return Observer(a, b, c, -factors.Z @ c.T, -b.T @ np.linalg.solve(inverse, factors.X))


def four_blocks(shaped: Realisation) -> GeneralizedPlant:
    """[K; I] (I - G_s K)^-1 [I G_s]: its norm is that of eq. 3.36, as [M N] is co-inner."""
    a, b, c, d = shaped
    p, m = d.shape
    return GeneralizedPlant(
        A=a, B1=np.hstack((np.zeros((len(a), p)), b)), B2=b,
        C1=np.vstack((np.zeros((m, len(a))), c)), C2=c,
        D11=np.block([[np.zeros((m, p)), np.zeros((m, m))], [np.eye(p), d]]),
        D12=np.vstack((np.eye(m), d)), D21=np.hstack((np.eye(p), d)), D22=d,
    )  # fmt: skip


def with_identity(
    plant: Realisation, w_1: Realisation | None, w_2: Realisation | None
) -> tuple[Realisation, Realisation]:
    """W_1 and W_2, the identity for None.

    Raises:
        ValueError: a weight whose size is not that of the plant.
    """
    p, m = plant.D.shape
    before, after = w_1 or gain(np.eye(m)), w_2 or gain(np.eye(p))
    for name, weight, size in (("w_1", before, m), ("w_2", after, p)):
        if weight.D.shape != (size, size):
            raise ValueError(f"{name} of {weight.D.shape}; allowed: {(size, size)}")
    return before, after
