"""How well a flight will tell the coefficients, before it is flown: the Cramer-Rao bound at a prior model.

The planned excitation is flown on the linear twin of the prior model; Fisher's information of the record at
the true values, noise model included, bounds the covariance of every unbiased estimate from below. It grows
with the length of the flight, so standard errors fall with its square root.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_identification.criterion import Criterion
from heli_identification.linear_twin import Twin
from heli_identification.parametrisation import Noise, Parametrisation
from heli_identification.records import Record
from heli_identification.sampling import Hold
from heli_identification.uncertainty import inverse_information

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Prediction:
    """Standard errors to be expected.

    Attributes:
        names: of the free coefficients.
        values: of the prior model, shape (r,).
        errors: smallest possible standard errors of the planned flight, shape (r,).
        duration: of the planned flight [s].
    """

    names: tuple[str, ...]
    values: Array
    errors: Array
    duration: float

    def seconds_for(self, relative: float) -> Array:
        """How long to fly this excitation for a relative standard error of each coefficient, shape (r,) [s].

        Args:
            relative: wanted standard error by the coefficient's size, for example 0.1.
        """
        wanted = relative * np.abs(self.values)
        with np.errstate(divide="ignore"):
            seconds: Array = self.duration * (self.errors / wanted) ** 2
        return seconds


def predicted_errors(twin: Twin, excitation: Array, rng: np.random.Generator) -> Prediction:
    """Fly the excitation on the twin and look at the information.

    Args:
        twin: prior model, feedback and noise; its process noise counts as white.
        excitation: external signal on the inputs, shape (N, m).
        rng: for the noise of the record.

    Raises:
        InputError: the twin's loop is unstable.
    """
    record = twin.fly(excitation, rng, "prediction")
    structure = twin.structure
    index = structure.index(structure.free_names)
    covariance = bound(twin, [record])
    return Prediction(
        structure.free_names, structure.values[index], np.sqrt(np.diag(covariance)), record.duration
    )


def bound(twin: Twin, records: Sequence[Record]) -> Array:
    """Cramer-Rao bound on the covariance of the free coefficients at the truth, shape (r, r).

    Noise variances, initial state and offsets count as unknown, too.

    Args:
        twin: the truth.
        records: flown by it, each with an initial state and offsets of its own.
    """
    structure = twin.structure
    parametrisation = Parametrisation(structure, Noise.KALMAN, twin.period, Hold.ZERO)
    criterion = Criterion(parametrisation, records)
    free, disturbed = len(parametrisation.free), parametrisation.disturbed
    vector = np.zeros(criterion.size)
    vector[:free] = structure.values[parametrisation.free] / criterion.scales[:free]
    tiny = 1e-12
    process = np.maximum(twin.disturbance.process[disturbed], tiny)
    measurement = np.maximum(twin.disturbance.measurement, tiny)
    vector[free : parametrisation.common] = 2.0 * np.log(np.concatenate((process, measurement)))
    information = criterion.evaluate(vector).information
    covariance = inverse_information(information)[:free, :free]
    scale = criterion.scales[:free]
    found: Array = covariance * np.outer(scale, scale)
    return found
