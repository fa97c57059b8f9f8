"""Where a search begins: the structure's values, noise as the data suggest it, states as measured."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_identification.criterion import Criterion
from heli_identification.helicopter_structures import SCALES
from heli_identification.parametrisation import Noise, Parametrisation, disturbed_states
from heli_identification.sampling import held_inputs, sample

Array = NDArray[np.float64]


def start_vector(criterion: Criterion) -> Array:
    """Scaled start vector: the structure's values, noise guessed from the data, states as measured."""
    p = criterion.parametrisation
    vector = np.zeros(criterion.size)
    structure, free = p.structure, len(p.free)
    vector[:free] = structure.values[p.free] / criterion.scales[:free]
    if p.noise is Noise.KALMAN:
        measurement, process = _noise_guess(criterion)
        vector[free : free + len(process)] = np.log(process)
        vector[free + len(process) : p.common] = np.log(measurement)
    elif p.noise is Noise.FREE_GAIN:
        measurement, process = _noise_guess(criterion)
        kalman = Parametrisation(structure, Noise.KALMAN, p.period, p.hold)
        common = np.concatenate((structure.values[p.free], np.log(process), np.log(measurement)))
        vector[free : p.common] = kalman.point(common).K.ravel() / criterion.scales[free : p.common]
    for index, record in enumerate(criterion.records):
        own = criterion.places(index)[p.common :]
        vector[own[p.seen]] = record.y[0] / criterion.scales[own[p.seen]]
    if not np.isfinite(criterion.cost(vector)):
        raise InputError(
            "the predictor is unstable at the start values",
            allowed="a prior model nearer to the plant, shorter pieces of data, or --noise kalman",
            key=structure.name,
        )
    return vector


def _noise_guess(criterion: Criterion) -> tuple[Array, Array]:
    """Variances of measurement noise, shape (p,), and per step of process noise on disturbed states."""
    p = criterion.parametrisation
    structure = p.structure
    scale = np.array([SCALES.get(name, 1.0) for name in structure.outputs])
    roughs = [np.mean(np.diff(r.y, n=3, axis=0) ** 2, axis=0) / 20.0 for r in criterion.records]
    rough = np.mean(roughs, axis=0)
    measurement = np.maximum(0.5 * rough, 1e-10 * scale**2)
    sampled = sample(structure, structure.values, p.period, p.hold)
    errors = []
    for record in criterion.records:
        state = np.zeros((len(record), len(structure.states)))
        state[:, p.seen] = record.y
        ahead = state[:-1] @ sampled.A.T + held_inputs(record.u, p.hold)[:-1] @ sampled.B.T
        error = (state[1:] - ahead)[:, p.seen]
        errors.append(np.mean((error - error.mean(axis=0)) ** 2, axis=0))
    place = [structure.outputs.index(structure.states[index]) for index in disturbed_states(structure)]
    return measurement, np.maximum(0.3 * np.mean(errors, axis=0)[place], 1e-8 * scale[place] ** 2)
