"""How long to fly: standard errors that a planned excitation will give, from a prior model (Cramer-Rao).

The excitation is flown on the linear twin of the prior model with the planned controller's axis as feedback,
once for each duration; see `heli_identification.cramer_rao`. Noise is that of the model file, if it was
identified with a noise model, else the bench's usual one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_common.timing import CONTROL_PERIOD
from heli_flight.identification import COMMAND_DELAY, feedback_of
from heli_identification.cramer_rao import Prediction, predicted_errors
from heli_identification.excitation import CHANNELS, MOTOR_CHANNEL, Excitation, samples
from heli_identification.helicopter_structures import structure_of
from heli_identification.identified_model import block_of
from heli_identification.linear_twin import Disturbance, Twin, lq_feedback
from heli_identification.structures import Structure

Array = NDArray[np.float64]

PROCESS = {"u": 0.003, "v": 0.003, "q": 0.01, "p": 0.01, "w": 0.003, "r": 0.01, "Omega": 0.008, "M_A": 1e-3}
"""Gusts and model errors on the bench, per sample, standard deviations, SI."""
MEASUREMENT = {
    "theta": 1e-3,
    "phi": 1e-3,
    "u": 5e-3,
    "v": 5e-3,
    "q": 1e-2,
    "p": 1e-2,
    "w": 5e-3,
    "r": 1e-2,
    "Omega": 0.02,
    "M_A": 1e-3,
}
"""Noise of the navigation and of the rotor's speed sensor, standard deviations, SI."""
LEAST = 1e-9
"""Standard deviation that stands for none in a model file's noise."""


@dataclass(frozen=True, eq=False)
class Forecast:
    """What is to be expected of one excitation.

    Attributes:
        structure: with the prior's values.
        excitation: as planned.
        feedback: in words.
        noise: in words.
        predictions: one for each duration, shortest first.
    """

    structure: Structure
    excitation: Excitation
    feedback: str
    noise: str
    predictions: tuple[Prediction, ...]

    def seconds_for(self, relative: float) -> Array:
        """How long to fly for a relative standard error of each coefficient, shape (r,) [s]."""
        return self.predictions[-1].seconds_for(relative)


def forecast(
    structure_name: str,
    excitation: Excitation,
    durations: Sequence[float],
    *,
    model: ModelFile | None = None,
    controller: str = "lq",
    seed: int = 1,
) -> Forecast:
    """Standard errors to be expected of an excitation, for several durations.

    Args:
        structure_name: what will be estimated.
        excitation: its channels are inputs of the structure; its own duration does not count.
        durations: of the excitation [s].
        model: prior; None takes the source's linearised values.
        controller: name or path of the one that will fly.
        seed: of the noise on the twin.

    Raises:
        InputError: the excitation leaves an input at rest, is too short, or the loop is unstable.
    """
    structure, known = structure_of(structure_name), None
    if model is not None:
        block = block_of(structure)
        plant = getattr(model, block)
        if plant is None:
            raise InputError(f"{model.name} has no {block} block", allowed="a model that has", key="--model")
        structure = structure.from_model(plant)
        known = noise_of(model, structure)
    twin, feedback = planned_twin(structure, controller, known)
    found = []
    for seconds in sorted(set(durations)):
        flown = external_signal(replace(excitation, duration=seconds), structure)
        found.append(predicted_errors(twin, flown, np.random.default_rng(seed)))
    noise = "usual on the bench" if known is None else f"as identified in {model.name if model else ''}"
    return Forecast(structure, excitation, feedback, noise, tuple(found))


def planned_twin(structure: Structure, controller: str, noise: Disturbance | None = None) -> tuple[Twin, str]:
    """The linear twin of a planned flight, and its feedback in words.

    Args:
        structure: with the prior's values.
        controller: name or path.
        noise: None takes the usual one.
    """
    usual = Disturbance(
        np.array([PROCESS.get(name, 0.0) if name in structure.outputs else 0.0 for name in structure.states]),
        np.array([MEASUREMENT[name] for name in structure.outputs]),
    )
    feedback, words, delay = _feedback(structure, controller)
    return Twin(structure, feedback, noise or usual, CONTROL_PERIOD, delay), words


def _feedback(structure: Structure, controller: str) -> tuple[StateSpace, str, int]:
    if structure.inputs == ("U_mot",):
        return lq_feedback(structure, CONTROL_PERIOD), "LQ of the prior drive", 0
    return feedback_of(structure, controller), controller, COMMAND_DELAY


def noise_of(model: ModelFile, structure: Structure) -> Disturbance | None:
    """The noise that an identification left in a model file; None if it has none for this structure."""
    identified: Any = model.source.get("identified")
    for key in (block_of(structure), "noise"):
        identified = identified.get(key) if isinstance(identified, Mapping) else None
    if not isinstance(identified, Mapping):
        return None

    def deviation(name: str) -> float:
        value = identified.get(name)
        return sqrt(exp(float(value))) if isinstance(value, int | float) else LEAST

    if not all(f"log_r_{name}" in identified for name in structure.outputs):
        return None
    process = [
        deviation(f"log_q_{name}") if f"log_q_{name}" in identified else 0.0 for name in structure.states
    ]
    return Disturbance(
        np.array(process), np.array([deviation(f"log_r_{name}") for name in structure.outputs])
    )


def external_signal(excitation: Excitation, structure: Structure) -> Array:
    """The excitation as it acts on the structure's inputs, shape (N, m).

    Raises:
        InputError: a channel is no input of the structure, or an input stays at rest.
    """
    channels = tuple(MOTOR_CHANNEL if name == "U_mot" else name for name in structure.inputs)
    if set(excitation.channels) - set(channels):
        problem = f"{', '.join(excitation.channels)} excited"
        allowed = f"channels of {structure.name}: {', '.join(channels)}"
        raise InputError(problem, allowed=allowed, key="excitation")
    found: Array = samples(excitation)[:, [CHANNELS.index(name) for name in channels]].copy()
    return found


def fitting(excitations: Sequence[Excitation], structure_name: str) -> Excitation:
    """The first of a plan's excitations that acts on a structure's inputs only.

    Raises:
        InputError: there is none.
    """
    structure = structure_of(structure_name)
    channels = {MOTOR_CHANNEL if name == "U_mot" else name for name in structure.inputs}
    for excitation in excitations:
        if set(excitation.channels) <= channels:
            return excitation
    problem = f"nothing excites {', '.join(sorted(channels))} alone"
    raise InputError(problem, allowed=f"an excitation of inputs of {structure_name}", key="plan")
