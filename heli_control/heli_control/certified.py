"""H-infinity synthesis that can be believed: two routes, and no result without its own certificate (spec 3.6).

Each route, the Riccati equations of this package and the library, proposes a controller for a gamma a little above
its optimum. The closed loop is then put together again from plant and controller, and

    its poles are computed                           all must decay
    its norm is bounded from above                   Hamiltonian method, on the joined state space
    its norm is bounded from below                   on a frequency grid, from the responses of P and K alone
    the poles of the controller are computed         none faster than the sampling rate bears

A proposal that misses its gamma by more than 1e-3, or whose bounds contradict each other, is refused with the reason
and tried again: balanced, with a slightly larger gamma, without its fast modes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_common.linear_model import StateSpace
from heli_control.assumptions import violations
from heli_control.generalized_plant import (
    GeneralizedPlant,
    closed_response,
    lower_lft,
    with_balanced_states,
)
from heli_control.hinf_norm import hinf_norm, largest_singular_values, natural_frequencies
from heli_control.library_synthesis import library_controller, library_gamma
from heli_control.pole_region import NYQUIST, fastest, without_fast_modes
from heli_control.realisation import Realisation, balanced, named
from heli_control.riccati_synthesis import AGREEMENT, NoController, central_controller, optimal_gamma

Poles = NDArray[np.complex128]


class Certificate(NamedTuple):
    """What the closed loop of a plant and a controller is, recomputed.

    Attributes:
        norm: upper bound by the Hamiltonian method; infinite if unstable.
        grid_norm: lower bound from the frequency responses.
        frequency: of the peak [rad/s].
        poles: of the closed loop, slowest to decay first.
        fastest_pole: of the controller, absolute value [rad/s].
        fault: why it is no certificate, or empty.
    """

    norm: float
    grid_norm: float
    frequency: float
    poles: Poles
    fastest_pole: float
    fault: str


@dataclass(frozen=True)
class Attempt:
    """One proposal and its fate.

    Attributes:
        route: `riccati` or `library`.
        measures: what was done to it: `as given`, `balanced`, `gamma x 1.1`, `fast modes at rest`.
        optimal_gamma: of the route; nan if it found none.
        gamma: asked for; nan likewise.
        norm: certified; nan if there was no controller.
        refused: the reason; empty if it was certified.
    """

    route: str
    measures: str
    optimal_gamma: float
    gamma: float
    norm: float
    refused: str


@dataclass(frozen=True, eq=False)
class Synthesis:
    """A certified controller.

    Attributes:
        controller: u = K y, continuous, with the names of the plant.
        gamma: level it was made for: the closed loop's norm is at most (1 + 1e-3) times it.
        optimal_gamma: smallest level that the route found.
        certified_norm: upper bound of the closed loop's norm.
        peak_frequency: where it is reached [rad/s].
        poles: of the closed loop.
        route: `riccati` or `library`.
        disagreement: relative difference of both routes' optimal gamma; None if one was refused.
        attempts: all, in their order, with the reasons of those refused.
    """

    controller: StateSpace
    gamma: float
    optimal_gamma: float
    certified_norm: float
    peak_frequency: float
    poles: Poles
    route: str
    disagreement: float | None
    attempts: tuple[Attempt, ...]


class SynthesisRefused(ValueError):
    """No controller could be certified; `reason` is the line to show, `attempts` what was tried."""

    def __init__(self, reason: str, attempts: tuple[Attempt, ...] = ()) -> None:
        super().__init__(reason)
        self.reason, self.attempts = reason, attempts


class _Route(NamedTuple):
    name: str
    optimum: Callable[[GeneralizedPlant], float]
    controller: Callable[[GeneralizedPlant, float], Realisation]


class _Proposal(NamedTuple):
    attempt: Attempt
    controller: Realisation
    certificate: Certificate


_ROUTES = (
    _Route("riccati", optimal_gamma, central_controller),
    _Route("library", library_gamma, library_controller),
)
_LADDER = ((False, 1.0), (True, 1.0), (True, 1.02), (True, 1.1), (True, 1.4), (True, 2.0))
"""Whether the states are balanced, and the factor on gamma, in the order tried."""


def synthesise(
    plant: GeneralizedPlant, *, gamma_margin: float = 1.05, fastest_pole: float = NYQUIST
) -> Synthesis:
    """The H-infinity controller of a generalised plant by both routes, certified.

    Args:
        plant: continuous.
        gamma_margin: gamma asked for over the optimal one, above 1.
        fastest_pole: of the controller [rad/s]; infinity for none.

    Returns:
        the proposal of the Riccati route when both agree, else of the route whose optimal gamma stands.

    Raises:
        SynthesisRefused: an assumption is violated, or no proposal can be certified; says why.
        ValueError: a margin not above 1, or a limit that is not positive.
    """
    if not 1.0 < gamma_margin < math.inf:
        raise ValueError(f"gamma_margin {gamma_margin}; allowed: above 1")
    if not fastest_pole > 0.0:
        raise ValueError(f"fastest_pole {fastest_pole} rad/s; allowed: above 0")
    violated = violations(plant)
    if violated:
        raise SynthesisRefused("; ".join(f"{one.name}: {one.text}" for one in violated))
    attempts: list[Attempt] = []
    found: list[_Proposal] = []
    for route in _ROUTES:
        proposal = _climb(route, plant, gamma_margin, fastest_pole, attempts)
        if proposal is not None:
            found.append(proposal)
    if not found:
        reasons = {attempt.route: attempt.refused for attempt in attempts}
        reason = "; ".join(f"{route}: {text}" for route, text in reasons.items())
        raise SynthesisRefused(f"no controller could be certified: {reason}", tuple(attempts))
    best, disagreement = _choice(found, plant, attempts)
    attempt, controller, certificate = best
    return Synthesis(
        controller=named(controller, plant.measurements, plant.controls, "k"),
        gamma=attempt.gamma,
        optimal_gamma=attempt.optimal_gamma,
        certified_norm=certificate.norm,
        peak_frequency=certificate.frequency,
        poles=certificate.poles,
        route=attempt.route,
        disagreement=disagreement,
        attempts=tuple(attempts),
    )


def certify(
    plant: GeneralizedPlant, controller: Realisation, gamma: float, fastest_pole: float = math.inf
) -> Certificate:
    """Recompute what a controller makes of a plant; believes nothing of the route it came from.

    Args:
        plant: the plant as given, not a scaled one.
        controller: u = K y.
        gamma: norm claimed.
        fastest_pole: allowed of the controller [rad/s].
    """
    nothing = np.zeros(0, dtype=np.complex128)
    quick = fastest(controller)
    try:
        loop = lower_lft(plant, controller)
    except ValueError as error:
        return Certificate(math.inf, math.inf, math.nan, nothing, quick, str(error))
    poles = np.linalg.eigvals(balanced(loop)[0].A).astype(np.complex128)
    poles = poles[np.argsort(-poles.real, kind="stable")]
    norm = hinf_norm(loop)
    if norm.unstable_pole is not None:
        fault = f"the closed loop is not stable beyond rounding: pole {norm.unstable_pole:.6g} rad/s"
        return Certificate(math.inf, math.inf, norm.frequency, poles, quick, fault)
    level = _grid_level(plant, controller, loop, norm.frequency)
    fault = ""
    if quick > fastest_pole:
        fault = f"a controller pole of {quick:.6g} rad/s is faster than {fastest_pole:.6g} rad/s"
    if not max(norm.value, level) <= (1.0 + AGREEMENT) * gamma:
        fault = f"the closed loop's norm is {max(norm.value, level):.6g}, not {gamma:.6g}"
    elif not norm.lower * (1.0 - AGREEMENT) <= level <= (1.0 + AGREEMENT) * norm.value:
        fault = f"the norm is {norm.value:.6g} by the Hamiltonian, {level:.6g} by frequency response"
    return Certificate(norm.value, level, norm.frequency, poles, quick, fault)


def _grid_level(plant: GeneralizedPlant, controller: Realisation, loop: Realisation, peak: float) -> float:
    """Largest singular value over a grid and the peak, from the responses of plant and controller."""
    inner, whole = balanced(controller)[0], with_balanced_states(plant)
    omega = natural_frequencies(balanced(loop)[0])
    omega = np.append(omega[(omega > 0.0) | np.isinf(omega)], peak if peak > 0.0 else 1e-6 * omega[1])
    # on a pole of P or K the closed loop is finite though neither response is
    for poles in (np.linalg.eigvals(whole.A), np.linalg.eigvals(inner.A)):
        on_axis = np.abs(poles.imag[np.abs(poles.real) < 1e-9 * np.abs(poles).max(initial=0.0)])
        for frequency in on_axis:
            omega = np.where(np.abs(omega - frequency) < 1e-6 * frequency, omega * (1.0 + 1e-5), omega)
    return float(largest_singular_values(closed_response(whole, inner, omega)).max())


def _choice(
    found: list[_Proposal], plant: GeneralizedPlant, attempts: list[Attempt]
) -> tuple[_Proposal, float | None]:
    """The proposal to return, and how far the routes are apart when they agree; the refusal of another is noted."""
    if len(found) == 1:
        return found[0], None
    first, second = (proposal.attempt.optimal_gamma for proposal in found)
    apart = abs(first - second) / min(first, second)
    if apart <= AGREEMENT:
        return found[0], apart
    # the lower claim counts if a controller keeps it: the margin on gamma may have hidden that none does
    lower, higher = sorted(found, key=lambda proposal: proposal.attempt.optimal_gamma)
    route = next(route for route in _ROUTES if route.name == lower.attempt.route)
    optimum, given = lower.attempt.optimal_gamma, with_balanced_states(plant)
    try:
        fault = certify(given, route.controller(given, (1.0 + AGREEMENT) * optimum), (1.0 + AGREEMENT) * optimum).fault
    except (NoController, np.linalg.LinAlgError) as error:
        fault = str(error)
    if fault:
        attempts.append(replace(lower.attempt, refused=f"its optimal gamma of {optimum:.6g} is not reached: {fault}"))
        return higher, None
    reason = f"its optimal gamma is {100.0 * apart:.3g} % above that of the other route, which is reached"
    attempts.append(replace(higher.attempt, refused=reason))
    return lower, None


def _climb(
    route: _Route, plant: GeneralizedPlant, margin: float, limit: float, attempts: list[Attempt]
) -> _Proposal | None:
    """The ladder of measures until a proposal of the route is certified; every refusal is noted."""
    optima: dict[bool, float] = {}
    for scaled, factor in _LADDER:
        given = with_balanced_states(plant) if scaled else plant
        measures = "balanced" if scaled else "as given"
        if factor > 1.0:
            measures += f", gamma x {factor:g}"
        optimum = gamma = math.nan
        try:
            if scaled not in optima:
                optima[scaled] = route.optimum(given)
            optimum = optima[scaled]
            gamma = margin * factor * optimum
            controller = route.controller(given, gamma)
        except (NoController, np.linalg.LinAlgError) as error:
            attempts.append(Attempt(route.name, measures, optimum, gamma, math.nan, str(error)))
            if isinstance(error, NoController) and error.final:
                return None
            continue
        certificate = certify(plant, controller, gamma, limit)
        if certificate.norm < (1.0 - AGREEMENT) * optimum:
            fault = f"the norm {certificate.norm:.6g} is below the optimal gamma claimed, {optimum:.6g}"
            certificate = certificate._replace(fault=fault)
        attempt = Attempt(route.name, measures, optimum, gamma, certificate.norm, certificate.fault)
        attempts.append(attempt)
        if certificate.fault and certificate.fastest_pole > limit and math.isfinite(certificate.norm):
            controller = without_fast_modes(controller, limit)
            certificate = certify(plant, controller, gamma, limit)
            measures += ", fast modes at rest"
            attempt = Attempt(route.name, measures, optimum, gamma, certificate.norm, certificate.fault)
            attempts.append(attempt)
        if not certificate.fault:
            return _Proposal(attempt, controller, certificate)
    return None

