"""Every design by its name: model file and weights in, controller file and figures out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from heli_common.errors import InputError
from heli_common.files import read_yaml
from heli_common.model_file import ModelFile, check_format, check_keys, read_mapping
from heli_common.quantities import from_mapping
from heli_control.controller_file import ControllerFile
from heli_control.flight_design import AxisDesign, design_flight_controller
from heli_control.flight_plants import DRIVE, FLIGHT_AXES, flight_plant
from heli_control.loop_figures import loop_figures
from heli_control.lq import LqWeights, axis_designs, design_lq
from heli_control.motor_controller_file import MotorControllerFile
from heli_control.motor_design import design_motor_controller
from heli_control.published import Comparison, compared
from heli_control.realisation import Realisation, gain
from heli_control.schemes import SCHEMES
from heli_control.weights_file import FORMAT, read_weights

LQ, MOTOR = "lq", "motor"
DESIGNS = (MOTOR, LQ, *(kind for kind in SCHEMES if kind != MOTOR))

ABOUT = {
    "motor": "PI of the rotor speed from an H-infinity design of the drive (source sec. 3.1.1)",
    "lq": "linear quadratic attitude and velocity controller (sec. 3.2.2, 3.2.3)",
    "skst": "H-infinity S/KS/T, which the source drops (sec. 3.3.2)",
    "gst": "H-infinity GS/T (sec. 3.3.3)",
    "gst2": "H-infinity GS/T with two degrees of freedom (sec. 3.3.4)",
    "ncf": "H-infinity loop shaping (sec. 3.4)",
    "ncf2": "H-infinity loop shaping with two degrees of freedom (sec. 3.4)",
}
"""What each is."""


@dataclass(frozen=True, eq=False)
class Loop:
    """A loop as it is looked at: scaled plant and continuous controller.

    Attributes:
        plant: G, scaled, m inputs and p outputs.
        feedback: u = K y, scaled, the minus sign of the feedback included.
        outputs: p names. inputs: m names.
    """

    plant: Realisation
    feedback: Realisation
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class DesignSummary:
    """What came out of a design.

    Attributes:
        kind: of the design.
        model: it was made for.
        file: what the node reads.
        loops: of each axis.
        figures: of each axis, see `loop_figures`.
        published: what the source prints of it beside ours.
        axes: synthesis of each axis; empty for LQ.
    """

    kind: str
    model: ModelFile
    file: ControllerFile | MotorControllerFile
    loops: Mapping[str, Loop]
    figures: Mapping[str, Mapping[str, float]]
    published: tuple[Comparison, ...]
    axes: Mapping[str, AxisDesign]


def design(kind: str, model: ModelFile, weights: Path | None = None) -> DesignSummary:
    """A controller of any kind.

    Args:
        kind: one of `DESIGNS`.
        model: to design for.
        weights: file with what differs from the shipped weights.

    Raises:
        InputError: names file, key, value and what is allowed, or says why nothing could be certified.
    """
    if kind == LQ:
        return _lq(model, read_lq_weights(weights))
    if kind == MOTOR:
        motor = design_motor_controller(model, read_weights(kind, weights))
        figures = {"crossover": motor.crossover, "bandwidth": motor.bandwidth, "apart": motor.apart}
        made = {DRIVE: motor.axis}
        return _summary(kind, model, motor.file, _loops(made), {DRIVE: figures}, made)
    flight = design_flight_controller(model, read_weights(kind, weights))
    loops, designed = _loops(flight.axes), {}
    for axis, loop in loops.items():
        synthesis = flight.axes[axis].synthesis
        designed[axis] = loop_figures(loop.plant, loop.feedback, loop.outputs) | {
            "gamma_min": synthesis.optimal,
            "gamma": synthesis.gamma,
        }
    return _summary(kind, model, flight.file, loops, designed, flight.axes)


def read_lq_weights(path: Path | None) -> LqWeights:
    """LQ's weights with what a file changes: `format`, `kind: lq` and `weights`, see `LqWeights`.

    Raises:
        InputError: names file, key, value and what is allowed.
    """
    if path is None:
        return LqWeights()
    document = read_yaml(path)
    check_format(document, FORMAT, path)
    check_keys(document, ("format", "kind", "weights"), (), path)
    if document["kind"] != LQ:
        raise InputError(f"{document['kind']!r} is another kind", allowed=LQ, file=path, key="kind")
    given = read_mapping(document["weights"], path, "weights")
    defaults = {field.name: field.default for field in fields(LqWeights)}
    check_keys(given, (), tuple(defaults), path, "weights.")
    return from_mapping(LqWeights, defaults | given, file=str(path), prefix="weights.")


def _lq(model: ModelFile, weights: LqWeights) -> DesignSummary:
    loops = {}
    for axis, made in zip(FLIGHT_AXES, axis_designs(model, weights), strict=True):
        plant = flight_plant(model, axis)
        order = [made.states.index(name) for name in plant.si.outputs]
        scaled = -made.continuous[:, order] * plant.output_scales / plant.input_scales[:, None]
        loops[axis] = Loop(plant.scaled, gain(np.asarray(scaled)), plant.si.outputs, plant.si.inputs)
    figures = {axis: loop_figures(loop.plant, loop.feedback, loop.outputs) for axis, loop in loops.items()}
    return _summary(LQ, model, design_lq(model, weights), loops, figures, {})


def _loops(axes: Mapping[str, AxisDesign]) -> dict[str, Loop]:
    return {
        axis: Loop(
            made.synthesis.plant.scaled,
            made.synthesis.plant.feedback(made.synthesis.controller),
            made.synthesis.plant.si.outputs,
            made.synthesis.plant.si.inputs,
        )
        for axis, made in axes.items()
    }


def _summary(
    kind: str,
    model: ModelFile,
    file: ControllerFile | MotorControllerFile,
    loops: Mapping[str, Loop],
    figures: Mapping[str, Mapping[str, Any]],
    axes: Mapping[str, AxisDesign],
) -> DesignSummary:
    published = tuple(row for axis, found in figures.items() for row in compared(kind, axis, found))
    return DesignSummary(kind, model, file, loops, figures, published, axes)
