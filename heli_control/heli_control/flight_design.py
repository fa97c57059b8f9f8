"""From a model file to a controller file by an H-infinity design: both axes, sampled, with provenance."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_control.anti_windup import observer_input, tracking_gain
from heli_control.certified import SynthesisRefused
from heli_control.controller_file import ControllerAxis, ControllerFile
from heli_control.discretisation import TUSTIN, discrete, discrete_anti_windup, response_error
from heli_control.flight_plants import flight_plant
from heli_control.realisation import Array, unnamed
from heli_control.reduction import Reduction, reduced_within
from heli_control.schemes import AxisSynthesis, AxisWeights, synthesis
from heli_control.weights_file import WeightsFile

REDUCTION_TOLERANCE = 1e-3
"""Error bound of the balanced reduction that is reported, as a share of the controller's norm."""


@dataclass(frozen=True, eq=False)
class AxisDesign:
    """One axis from synthesis to what flies.

    Attributes:
        synthesis: certified, continuous.
        flown: sampled at 100 Hz.
        response_error: of the sampled controller below 25 rad/s, relative, see `discretisation`.
        reduction: balanced reduction of the scaled controller within `REDUCTION_TOLERANCE`; for information.
    """

    synthesis: AxisSynthesis
    flown: ControllerAxis
    response_error: float
    reduction: Reduction


@dataclass(frozen=True, eq=False)
class FlightDesign:
    """A flight controller and how it came about.

    Attributes:
        model: designed for.
        weights: designed with.
        axes: by name, `horizontal` and `vertical`.
        file: the controller file.
    """

    model: ModelFile
    weights: WeightsFile
    axes: dict[str, AxisDesign]
    file: ControllerFile


def design_flight_controller(model: ModelFile, weights: WeightsFile) -> FlightDesign:
    """Both axes of an H-infinity flight controller.

    Args:
        model: any with the signals of `flight_plants`.
        weights: whose kind says the scheme.

    Raises:
        InputError: the model lacks a signal, or no controller can be certified; says why.
    """
    axes = {axis: axis_design(model, weights, axis) for axis in weights.axes}
    provenance: dict[str, Any] = {
        "method": f"H-infinity {weights.kind}, certified; Tustin at 100 Hz",
        "weights": {axis: weights.mapping()[axis] for axis in weights.axes},
        **{axis: provenance_of(design) for axis, design in axes.items()},
        "software": software(),
    }
    file = ControllerFile(
        name=weights.kind,
        kind=weights.kind,
        plant_name=model.name,
        plant_hash=model.plant_hash,
        operating_point=model.operating_point,
        horizontal=axes["horizontal"].flown,
        vertical=axes["vertical"].flown,
        provenance=provenance,
    )
    return FlightDesign(model, weights, axes, file)


def software() -> dict[str, str]:
    """Versions that a design depends on."""
    names = ("heli_control", "numpy", "scipy", "control", "slycot")
    return {"python": platform.python_version()} | {name: version(name) for name in names}


def axis_design(model: ModelFile, weights: WeightsFile, axis: str) -> AxisDesign:
    """One axis, from plant and weights to what flies.

    Args:
        model: with the signals of the axis.
        weights: whose kind has this axis.
        axis: one of `weights.axes`.

    Raises:
        InputError: as `design_flight_controller`.
    """
    chosen = weights.axes[axis]
    plant = flight_plant(model, axis, chosen.scales)
    try:
        made = synthesis(weights.kind, plant, chosen)
    except SynthesisRefused as error:
        allowed = "weights and a plant for which a controller can be certified"
        raise InputError(str(error), allowed=allowed, key=f"{weights.kind}.{axis}") from None
    given = unnamed(made.controller)
    sampled = discrete(given, TUSTIN)
    named = StateSpace(made.controller.states, made.controller.inputs, made.controller.outputs, *sampled)
    return AxisDesign(
        synthesis=made,
        flown=ControllerAxis(named, _anti_windup(made, named, chosen)),
        response_error=response_error(given, sampled),
        reduction=reduced_within(plant.feedback(made.controller), REDUCTION_TOLERANCE),
    )


def _anti_windup(made: AxisSynthesis, sampled: StateSpace, weights: AxisWeights) -> Array:
    """E of the sampled controller: see `anti_windup`."""
    plant = made.plant
    if made.loop_shaping is None:
        references = plant.output_scales[list(plant.followed)]
        return tracking_gain(sampled, plant.input_scales, np.concatenate((plant.output_scales, references)))
    into = observer_input(made.loop_shaping, plant.scaled, weights.stacked("W_1")) / plant.input_scales
    return discrete_anti_windup(made.controller.A, into, TUSTIN)


def provenance_of(design: AxisDesign) -> dict[str, Any]:
    """What of a design goes into its file."""
    made = design.synthesis
    return {
        "gamma": made.gamma,
        "gamma_optimal": made.optimal,
        "closed_loop_norm": made.norm,
        "peak_rad_s": made.frequency,
        "route": made.route,
        "routes_apart": made.disagreement,
        "order": len(made.controller.states),
        "order_reduced": design.reduction.system.order,
        "sampling_error": design.response_error,
    }
