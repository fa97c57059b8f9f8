"""The H-infinity designs that exist, what each is told by weights, and what each makes of one axis.

| kind | scheme | weights |
|---|---|---|
| motor | GS/T of the drive | as gst |
| skst | S/KS/T (source Figure 3.14) | W_e W_y on outputs, W_u on commands |
| gst | GS/T (Figure 3.15) | W_u W_v on commands, W_y W_d on outputs |
| gst2 | GS/T, two degrees of freedom (Figure 3.16) | the same, W_e W_r on references |
| ncf | loop shaping (sec. 3.4) | W_1 on commands |
| ncf2 | loop shaping, two degrees of freedom (Figure 3.23) | W_1 on commands, the model T_yr on references |
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from heli_common.linear_model import StateSpace
from heli_common.quantities import Quantity
from heli_control.assumptions import Assumption, check_assumptions
from heli_control.certified import Attempt, SynthesisRefused, synthesise
from heli_control.flight_plants import DRIVE, FLIGHT_AXES, FlightPlant
from heli_control.generalized_plant import GeneralizedPlant, with_balanced_states
from heli_control.loop_shaping import LoopShaping, four_blocks, loop_shaping
from heli_control.loop_shaping_two_degree import (
    steady_state_prefilter,
    two_degree_loop_shaping,
    two_degree_plant,
    with_prefilter,
)
from heli_control.mixed_sensitivity import gs_t, gs_t_two_degree, s_ks_t
from heli_control.pole_region import NYQUIST
from heli_control.realisation import Array, Realisation, series, unnamed
from heli_control.weight import Weight, stacked

OUTPUTS, COMMANDS, REFERENCES = "outputs", "commands", "references"
ANGLES = ("theta", "phi")

_MARGIN = Quantity("-", "D", "gamma asked for over the optimal one", 1.0001, 10.0)
_FASTEST = Quantity("rad/s", "D", "fastest pole allowed of the controller", 1.0, NYQUIST)


@dataclass(frozen=True)
class Scheme:
    """What a design is told.

    Attributes:
        weights: names, and the signals each has an entry for.
        settings: further numbers.
        two_degrees: whether the controller takes the references separately.
        axes: it is made for.
    """

    weights: Mapping[str, str]
    settings: Mapping[str, Quantity]
    two_degrees: bool = False
    axes: tuple[str, ...] = FLIGHT_AXES


_GST = {"W_u": COMMANDS, "W_y": OUTPUTS, "W_v": COMMANDS, "W_d": OUTPUTS}
_ANGLES = Quantity("-", "T", "factor on W_d of the angles: attitude against velocity (eq. 3.30)", 1e-3, 1.0)
_COMMON = {"gamma_margin": _MARGIN, "fastest_pole": _FASTEST}
SCHEMES = {
    "motor": Scheme(_GST, _COMMON | {"attitude": _ANGLES}, axes=(DRIVE,)),
    "skst": Scheme({"W_e": OUTPUTS, "W_u": COMMANDS, "W_y": OUTPUTS}, _COMMON),
    "gst": Scheme(_GST, _COMMON | {"attitude": _ANGLES}),
    "gst2": Scheme(
        _GST | {"W_e": REFERENCES, "W_r": REFERENCES},
        _COMMON
        | {
            "attitude": _ANGLES,
            "static_gain": Quantity("-", "D", "from a reference to its output at rest", 0.1, 1.0),
        },
        True,
    ),
    "ncf": Scheme({"W_1": COMMANDS}, _COMMON),
    "ncf2": Scheme(
        {"W_1": COMMANDS, "T_yr": REFERENCES},
        _COMMON | {"rho": Quantity("-", "T", "weight of the model against robustness", 0.01, 100.0)},
        True,
    ),
}


@dataclass(frozen=True)
class AxisWeights:
    """The weights of one axis.

    Attributes:
        scales: of every output and command, SI.
        weights: by name, one for each signal in the order of the plant.
        settings: by name.
    """

    scales: Mapping[str, float]
    weights: Mapping[str, Mapping[str, Weight]]
    settings: Mapping[str, float]

    def stacked(self, name: str) -> Realisation:
        """A weight of all its signals as one diagonal system."""
        return stacked(tuple(self.weights[name].values()))


@dataclass(frozen=True, eq=False)
class AxisSynthesis:
    """A certified continuous controller of one axis.

    Attributes:
        plant: it was made for.
        controller: in SI; inputs are outputs of the plant, then references; u = K (y, r).
        problem: generalised plant whose closed loop was certified, scaled.
        inner: its controller, scaled, u = K y of `problem`.
        gamma: asked for. optimal: smallest possible.
        norm: of the closed loop, certified. frequency: of its peak [rad/s].
        route: that made it. disagreement: of both routes' optimum, or None.
        attempts: of both routes, with reasons of refusals.
        loop_shaping: with factors and observer, for `ncf` only.
    """

    plant: FlightPlant
    controller: StateSpace
    problem: GeneralizedPlant
    inner: Realisation
    gamma: float
    optimal: float
    norm: float
    frequency: float
    route: str
    disagreement: float | None
    attempts: tuple[Attempt, ...]
    loop_shaping: LoopShaping | None = None

    @property
    def assumptions(self) -> tuple[Assumption, ...]:
        """A1 to A5 of the problem, with their distances to violation."""
        return check_assumptions(with_balanced_states(self.problem), self.gamma)


def synthesis(kind: str, plant: FlightPlant, weights: AxisWeights) -> AxisSynthesis:
    """The certified controller of one axis.

    Args:
        kind: a key of `SCHEMES`.
        plant: the axis.
        weights: of that kind.

    Raises:
        SynthesisRefused: an assumption is violated, or nothing could be certified; says why.
    """
    if kind == "ncf":
        return _loop_shaping(plant, weights)
    if kind == "ncf2":
        return _loop_shaping_two_degree(plant, weights)
    problem = mixed_sensitivity_problem(kind, plant, weights)
    found = synthesise(problem, **_limits(weights))
    inner = unnamed(found.controller)
    q = len(plant.followed) if SCHEMES[kind].two_degrees else 0
    # the error is e = -y: the feedback of the result is the negative of what comes from e
    turned = Realisation(inner.A, _turned(inner.B, q), inner.C, _turned(inner.D, q))
    if q:
        select = np.eye(len(plant.si.outputs))[list(plant.followed)]
        wanted = weights.settings["static_gain"] * np.eye(q)
        turned = with_prefilter(turned, steady_state_prefilter(plant.scaled, turned, wanted, select))
    return AxisSynthesis(
        plant,
        plant.controller(turned, separate_references=q > 0),
        problem,
        inner,
        found.gamma,
        found.optimal_gamma,
        found.certified_norm,
        found.peak_frequency,
        found.route,
        found.disagreement,
        found.attempts,
    )


def mixed_sensitivity_problem(kind: str, plant: FlightPlant, weights: AxisWeights) -> GeneralizedPlant:
    """The generalised plant of `skst`, `gst`, `gst2` or `motor`.

    Raises:
        ValueError: another kind.
    """
    g, w = plant.scaled, weights.stacked
    if kind == "skst":
        return s_ks_t(g, w("W_e"), w("W_u"), w("W_y"))
    factors = [weights.settings["attitude"] if name in ANGLES else 1.0 for name in plant.si.outputs]
    w_d = w("W_d")
    w_d = w_d._replace(C=np.array(factors)[:, None] * w_d.C, D=np.array(factors)[:, None] * w_d.D)
    if kind in ("gst", "motor"):
        return gs_t(g, w("W_u"), w("W_y"), w("W_v"), w_d)
    if kind == "gst2":
        return gs_t_two_degree(g, w("W_u"), w("W_y"), w("W_v"), w_d, w("W_e"), w("W_r"), plant.followed)
    raise ValueError(f"kind {kind!r}; allowed: skst, gst, gst2, motor")


def _loop_shaping(plant: FlightPlant, weights: AxisWeights) -> AxisSynthesis:
    limits = _limits(weights)
    found = loop_shaping(
        plant.scaled,
        weights.stacked("W_1"),
        factor=limits["gamma_margin"],
        fastest_pole=limits["fastest_pole"],
    )
    if found.observer is None:
        raise SynthesisRefused("the shaped plant has a direct feedthrough: no observer form")
    problem = four_blocks(found.factors.plant)
    inner = found.observer.controller
    whole = series(weights.stacked("W_1"), inner)
    return AxisSynthesis(
        plant,
        plant.controller(whole, separate_references=False),
        problem,
        inner,
        found.gamma,
        found.factors.gamma_min,
        found.certificate.norm,
        found.certificate.frequency,
        "closed form",
        None,
        (),
        found,
    )


def _loop_shaping_two_degree(plant: FlightPlant, weights: AxisWeights) -> AxisSynthesis:
    model = weights.stacked("T_yr")
    select = np.eye(len(plant.si.outputs))[list(plant.followed)]
    rho = weights.settings["rho"]
    found = two_degree_loop_shaping(
        plant.scaled, model, weights.stacked("W_1"), rho=rho, select=select, **_limits(weights)
    )
    made = found.synthesis
    problem = two_degree_plant(found.factors, model, rho, select)
    return AxisSynthesis(
        plant,
        plant.controller(found.controller, separate_references=True),
        problem,
        unnamed(made.controller),
        made.gamma,
        made.optimal_gamma,
        made.certified_norm,
        made.peak_frequency,
        made.route,
        made.disagreement,
        made.attempts,
    )


def _limits(weights: AxisWeights) -> dict[str, Any]:
    return {name: weights.settings[name] for name in ("gamma_margin", "fastest_pole")}


def _turned(matrix: Array, references: int) -> Array:
    turned = matrix.copy()
    turned[:, references:] *= -1.0
    return turned
