"""From recorded flights to an estimate: segments, preparation, method, validation (source 2.5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_control.controller_file import load_controller
from heli_flight.flight_record import FlightRecord
from heli_flight.flown_signals import flight_signals, free_flight
from heli_identification.helicopter_structures import structure_of
from heli_identification.identified_model import block_of, identified_model
from heli_identification.indirect import indirect
from heli_identification.least_squares import least_squares, regression_estimate
from heli_identification.parametrisation import Noise
from heli_identification.prediction_error import Estimate, prediction_error
from heli_identification.preparation import InputSource, Segment, prepare
from heli_identification.projection import projection
from heli_identification.records import Record
from heli_identification.sampling import Hold
from heli_identification.structures import Structure
from heli_identification.validation import Fit, fit

METHODS = ("ls", "pem", "projection", "indirect", "joint")
ESTIMATED = 0.7
"""Share of a flight that is estimated from if nothing is said; the rest validates."""
SIMULATED = 10.0
"""Length of a free simulation in validation; shorter flights are not validated by themselves [s]."""
COMMAND_DELAY = 2
"""From servo command to blade in samples: latency, half a pulse frame and the servo's own lag."""


@dataclass(frozen=True)
class Choice:
    """What is wanted.

    Attributes:
        structure: name. method: one of METHODS. noise: model of the disturbances, for pem.
        source: of the plant's input. averaging: the source's filter.
        free: coefficients to estimate, None for the structure's own. fixed: of these, not to estimate.
        estimate: segments in flight time, None for the first part of the free flight. validate: the rest.
        controller: name or path of the one flown, for indirect and joint.
    """

    structure: str = "servo_rotor"
    method: str = "pem"
    noise: Noise = Noise.KALMAN
    source: InputSource = InputSource.ACTUATOR
    averaging: bool = False
    free: tuple[str, ...] | None = None
    fixed: tuple[str, ...] = ()
    estimate: tuple[Segment, ...] | None = None
    validate: tuple[Segment, ...] | None = None
    controller: str = "lq"


@dataclass(frozen=True, eq=False)
class Identified:
    """What came out.

    Attributes:
        choice: what was wanted.
        estimate: of the structure.
        records: estimated from.
        means: operating point that was flown.
        fit: on validation data, None if there are none.
        segments: flight, begin and end of every piece estimated from.
        validation: pieces the fit is judged on, named like `segments`.
    """

    choice: Choice
    estimate: Estimate
    records: tuple[Record, ...]
    means: dict[str, float]
    fit: Fit | None
    segments: tuple[str, ...]
    validation: tuple[str, ...] = ()

    def remarks(self) -> dict[str, Any]:
        """How the estimate was made, plain values."""
        return {
            "estimation": self.choice.method,
            "input": self.choice.source.value,
            "averaged": self.choice.averaging,
            "segments": list(self.segments),
        }

    def model(self, name: str, prior: ModelFile | None) -> ModelFile:
        """The model file; see `identified_model`."""
        return identified_model(
            name,
            self.estimate,
            self.records,
            self.means,
            prior=prior,
            remarks=self.remarks(),
            fit=self.fit,
        )


def identify(flights: Sequence[FlightRecord], choice: Choice, prior: ModelFile | None = None) -> Identified:
    """Estimate and validate.

    Args:
        flights: recorded.
        choice: what is wanted.
        prior: start values.

    Raises:
        InputError: data that do not bear the estimate, or a coefficient the structure does not have.
    """
    structure = _structure(choice, prior)
    estimation, validation = _segments(flights, choice)
    prepared = [
        prepare(flight_signals(flight), structure, segment, source=choice.source, averaging=choice.averaging)
        for flight, segment in estimation
    ]
    records = tuple(record for record, _ in prepared)
    means = {name: float(np.mean([point[name] for _, point in prepared])) for name in prepared[0][1]}
    estimate = _estimate(structure, records, choice)
    judged = None
    if validation:
        others = [
            prepare(flight_signals(flight), structure, segment, source=choice.source, excited=False)[0]
            for flight, segment in validation
        ]
        judged = fit(estimate.structure, others, hold=hold_of(structure), segment=SIMULATED)
    names, others_names = (
        tuple(f"{flight.bag.folder.name} {segment}" for flight, segment in pieces)
        for pieces in (estimation, validation)
    )
    return Identified(choice, estimate, records, means, judged, names, others_names)


def hold_of(structure: Structure) -> Hold:
    """What the input does between samples: positions are measured, the voltage is held from 5 ms on."""
    return Hold.LATE if structure.inputs == ("U_mot",) else Hold.LINEAR


def _structure(choice: Choice, prior: ModelFile | None) -> Structure:
    structure = structure_of(choice.structure)
    if prior is not None:
        block = getattr(prior, block_of(structure))
        if block is not None:
            structure = structure.from_model(block)
    if choice.free is not None:
        structure = structure.with_free(choice.free)
    if choice.fixed:
        structure.index(choice.fixed)
        structure = structure.with_free([n for n in structure.free_names if n not in choice.fixed])
    return structure


Piece = tuple[FlightRecord, Segment]


def _segments(flights: Sequence[FlightRecord], choice: Choice) -> tuple[list[Piece], list[Piece]]:
    """Pieces to estimate from and to validate on."""
    estimation: list[Piece] = []
    validation: list[Piece] = []
    for flight in flights:
        if choice.estimate is not None:
            estimation += [(flight, segment) for segment in choice.estimate]
            validation += [(flight, segment) for segment in choice.validate or ()]
            continue
        whole = free_flight(flight)
        begin, end = float(whole.begin or 0.0), float(whole.end or 0.0)
        middle = begin + ESTIMATED * (end - begin)
        if choice.validate is None and end - middle < SIMULATED:
            estimation.append((flight, whole))
            continue
        estimation.append((flight, Segment(begin, middle)))
        pieces = choice.validate or (Segment(middle, end),)
        validation += [(flight, segment) for segment in pieces]
    return estimation, validation


def _estimate(structure: Structure, records: Sequence[Record], choice: Choice) -> Estimate:
    if choice.method == "pem":
        if choice.averaging and choice.noise is not Noise.OUTPUT_ERROR:
            raise InputError(
                f"{choice.noise.value} on averaged data, whose noise is no longer white",
                allowed=f"{Noise.OUTPUT_ERROR.value}, as in the source, or raw data",
                key="--noise",
            )
        return prediction_error(structure, records, noise=choice.noise, hold=hold_of(structure))
    if choice.method == "projection":
        return projection(structure, records, hold=hold_of(structure))
    if choice.method == "ls":
        return regression_estimate(least_squares(structure, records), records)
    if choice.method in ("indirect", "joint"):
        feedback = feedback_of(structure, choice.controller)
        joint = choice.method == "joint"
        return indirect(structure, records, feedback, delay=COMMAND_DELAY, joint=joint)
    raise InputError(f"no method {choice.method!r}", allowed=", ".join(METHODS), key="method")


def feedback_of(structure: Structure, controller: str) -> StateSpace:
    """The axis of a controller that commands the structure's inputs, references left out.

    Args:
        structure: whose outputs it sees.
        controller: name or path.

    Raises:
        InputError: no axis of it does.
    """
    file = load_controller(controller)
    for axis in (file.horizontal.system, file.vertical.system):
        if set(axis.outputs) == set(structure.inputs):
            kept = [axis.inputs.index(name) for name in axis.inputs if name in structure.outputs]
            names = tuple(axis.inputs[index] for index in kept)
            return StateSpace(
                axis.states, names, axis.outputs, axis.A, axis.B[:, kept], axis.C, axis.D[:, kept]
            )
    raise InputError(f"no axis of {controller} commands {', '.join(structure.inputs)}", key="controller")
