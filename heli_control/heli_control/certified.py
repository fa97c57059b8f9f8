"""H-infinity synthesis that can be believed: two routes, no result without its own certificate (spec 3.6).

Each route, the Riccati equations of this package and the library, proposes a controller for a gamma a little
above its optimum. A proposal that misses its gamma by more than 1e-3, whose bounds contradict each other or
whose poles are too fast is refused with the reason and tried again: balanced, with a larger gamma, without
its fast modes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from heli_common.linear_model import StateSpace
from heli_control.assumptions import violations
from heli_control.certificate import AGREEMENT, Certificate, Poles, certify
from heli_control.generalized_plant import GeneralizedPlant, with_balanced_states
from heli_control.library_synthesis import library_controller, library_gamma
from heli_control.pole_region import NYQUIST, without_fast_modes
from heli_control.realisation import Realisation, named
from heli_control.riccati_synthesis import NoController, central_controller, optimal_gamma


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


def _choice(
    found: list[_Proposal], plant: GeneralizedPlant, attempts: list[Attempt]
) -> tuple[_Proposal, float | None]:
    """The proposal to return, and how far the routes are apart if they agree; a refusal is noted."""
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
        fault = certify(
            given, route.controller(given, (1.0 + AGREEMENT) * optimum), (1.0 + AGREEMENT) * optimum
        ).fault
    except (NoController, np.linalg.LinAlgError) as error:
        fault = str(error)
    if fault:
        attempts.append(
            replace(lower.attempt, refused=f"its optimal gamma of {optimum:.6g} is not reached: {fault}")
        )
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
