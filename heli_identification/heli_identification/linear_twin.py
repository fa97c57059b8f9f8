"""Closed-loop data of a model that is known: the plant of a structure, feedback, noise, external signal.

    x(k+1) = A_d x(k) + B_d u(k) + w(k)    y(k) = C x(k) + v(k)    u(k) = r(k) + feedback of y up to k - delay

The truth is in the model set here, so claimed errors can be judged and flights can be planned (`cramer_rao`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_identification.helicopter_structures import SCALES
from heli_identification.records import Record
from heli_identification.sampling import sample
from heli_identification.structures import Structure

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Disturbance:
    """Noise of the twin.

    Attributes:
        process: standard deviation per step on every state, shape (n,).
        measurement: standard deviation on every output, shape (p,).
        correlation_time: of the process noise [s]; zero is white. Coloured noise keeps the white one's low
            frequencies: its spectrum falls above 1 / correlation_time.
    """

    process: Array
    measurement: Array
    correlation_time: float = 0.0


@dataclass(frozen=True, eq=False)
class Twin:
    """A closed loop to take data from.

    Attributes:
        structure: with its true values.
        feedback: discrete controller; inputs are outputs of the structure, outputs are its inputs.
        disturbance: noise.
        period: sample time [s].
        delay: of the feedback, in samples.
    """

    structure: Structure
    feedback: StateSpace
    disturbance: Disturbance
    period: float
    delay: int = 0

    def fly(self, excitation: Array, rng: np.random.Generator, name: str = "twin") -> Record:
        """Simulate from rest.

        Args:
            excitation: r, shape (N, m).
            rng: for the noise.
            name: of the record.

        Raises:
            InputError: the loop is unstable: the data run away.
        """
        structure, feedback = self.structure, self.feedback
        sampled = sample(structure, structure.values, self.period)
        a, b, seen = sampled.A, sampled.B, [structure.states.index(o) for o in structure.outputs]
        taken = [structure.outputs.index(name) for name in feedback.inputs]
        given = [structure.inputs.index(name) for name in feedback.outputs]
        count = len(excitation)
        process = rng.standard_normal((count, len(a))) * self.disturbance.process
        if self.disturbance.correlation_time > 0.0:
            process = _low_pass(process, self.period / self.disturbance.correlation_time)
        measurement = rng.standard_normal((count, len(seen))) * self.disturbance.measurement
        x: Array = np.zeros(len(a))
        xi: Array = np.zeros(len(feedback.states))
        u, y = excitation.copy(), np.zeros((count, len(seen)))
        waiting: list[Array] = [np.zeros(len(given)) for _ in range(self.delay)]
        for step in range(count):
            y[step] = x[seen] + measurement[step]
            signal = y[step, taken]
            waiting.append(feedback.C @ xi + feedback.D @ signal)
            xi = feedback.A @ xi + feedback.B @ signal
            u[step, given] += waiting.pop(0)
            x = a @ x + b @ u[step] + process[step]
            if not np.all(np.abs(x) < 1e6):
                raise InputError("the feedback does not hold the model", allowed="a stable loop", key=name)
        return Record(name, self.period, structure.inputs, structure.outputs, u, y, excitation.copy())


def lq_feedback(structure: Structure, period: float, weight: float = 1.0) -> StateSpace:
    """Static feedback of all measured states: discrete LQ on the plant with its other states at rest.

    Args:
        structure: with values.
        period: sample time [s].
        weight: of the states against the inputs, both scaled by source Table 2.4.

    Raises:
        InputError: nothing stabilises the plant this way.
    """
    seen = [structure.states.index(name) for name in structure.outputs]
    hidden = [index for index in range(len(structure.states)) if index not in seen]
    a, b = structure.matrices(structure.values)
    slow_a, slow_b = a[np.ix_(seen, seen)], b[seen]
    if hidden:
        inverse = np.linalg.inv(a[np.ix_(hidden, hidden)])
        slow_a = slow_a - a[np.ix_(seen, hidden)] @ inverse @ a[np.ix_(hidden, seen)]
        slow_b = slow_b - a[np.ix_(seen, hidden)] @ inverse @ b[hidden]
    reduced = _held(slow_a, slow_b, period)
    q = weight * np.diag([SCALES.get(name, 1.0) ** -2.0 for name in structure.outputs])
    r = np.diag([SCALES.get(name, 1.0) ** -2.0 for name in structure.inputs])
    try:
        cost = solve_discrete_are(reduced[0], reduced[1], q, r)
    except np.linalg.LinAlgError as error:
        raise InputError(f"no stabilising feedback: {error}", key=structure.name) from None
    gain = np.linalg.solve(r + reduced[1].T @ cost @ reduced[1], reduced[1].T @ cost @ reduced[0])
    m, p = gain.shape
    return StateSpace(
        (), structure.outputs, structure.inputs, np.zeros((0, 0)), np.zeros((0, p)), np.zeros((m, 0)), -gain
    )


def _held(a: Array, b: Array, period: float) -> tuple[Array, Array]:
    n, m = b.shape
    whole = np.zeros((n + m, n + m))
    whole[:n, :n], whole[:n, n:] = a * period, b * period
    held = expm(whole)
    return held[:n, :n], held[:n, n:]


def _low_pass(noise: Array, share: float) -> Array:
    """First-order lag over white noise, unit gain at frequency zero."""
    kept = np.exp(-share)
    out = np.zeros_like(noise)
    state: Array = np.zeros(noise.shape[1])
    for step in range(len(noise)):
        state = kept * state + (1.0 - kept) * noise[step]
        out[step] = state
    return out
