"""The closed loop of a structure with a known linear feedback, as a predictor driven by the external signal.

    plant     x(k+1) = A x(k) + B (r(k) + f(k - d)) + d_x
    feedback  s(k+1) = A_c s(k) + B_c y(k),   f(k) = C_c s(k) + D_c y(k)

States: x, s, the d samples of f under way, and for the joint approach the last f, to be compared with u -
r. Matrices and their derivatives follow from the plant's; the rest of the estimation does not know the
difference.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_identification.helicopter_structures import SCALES
from heli_identification.parametrisation import Noise, Parametrisation, Point
from heli_identification.records import Record
from heli_identification.sampling import Hold, Sampled, sample
from heli_identification.structures import Structure

Array = NDArray[np.float64]


class ClosedLoop(Parametrisation):
    """Parametrisation by the plant's coefficients, predictor of the whole loop, output error.

    Args:
        structure: plant.
        feedback: discrete; its inputs are outputs of the plant, its outputs inputs of the plant.
        period: sample time [s].
        delay: of the feedback in samples.
        joint: whether u - r is predicted beside y.

    Raises:
        InputError: the feedback has signals the plant lacks.
    """

    def __init__(
        self, structure: Structure, feedback: StateSpace, period: float, delay: int, *, joint: bool
    ) -> None:
        super().__init__(structure, Noise.OUTPUT_ERROR, period, Hold.ZERO)
        for names, known in ((feedback.inputs, structure.outputs), (feedback.outputs, structure.inputs)):
            for name in names:
                if name not in known:
                    raise InputError(f"the feedback uses {name!r}", allowed=", ".join(known), key="feedback")
        self._taken = [structure.outputs.index(name) for name in feedback.inputs]
        self._given = [structure.inputs.index(name) for name in feedback.outputs]
        self._feedback, self._delay = feedback, delay
        plant, given = len(structure.states), len(self._given)
        self._first_delay = plant + len(feedback.states)
        self._last = self._first_delay + delay * given
        self.n = self._last + (given if joint else 0)
        if joint:
            self.seen = np.concatenate((self.seen, np.arange(self._last, self.n)))
        state_scales = [SCALES.get(name, 1.0) for name in structure.states]
        command_scales = [SCALES.get(name, 1.0) for name in feedback.outputs]
        more = [*(1.0 for _ in feedback.states), *(command_scales * (delay + (1 if joint else 0)))]
        own = np.concatenate((state_scales, more, np.array(state_scales)[self.shifted]))
        self.local = self.n + len(self.shifted)
        self.scales = np.concatenate((self.scales[: self.common], own))

    def point(self, common: Array) -> Point:
        """Matrices of the whole loop and their derivatives."""
        plant = sample(self.structure, self.values(common), self.period, Hold.ZERO)
        n, p = self.n, len(self.seen)
        x = slice(0, len(plant.A))
        r = len(plant.dA)
        a, b, drift = np.zeros((n, n)), np.zeros((n, plant.B.shape[1])), np.zeros((n, len(plant.A)))
        da, db = np.zeros((r, n, n)), np.zeros((r, *b.shape))
        ddrift = np.zeros((r, *drift.shape))
        acting, feedback = self._acting(), self._output()
        a[x, x], b[x], drift[x] = plant.A, plant.B, plant.N
        a[x] += plant.B[:, self._given] @ acting
        da[:, x, x], db[:, x], ddrift[:, x] = plant.dA, plant.dB, plant.dN
        da[:, x] += plant.dB[:, :, self._given] @ acting
        own = slice(x.stop, self._first_delay)
        a[own, own] = self._feedback.A
        a[own, x] = self._feedback.B @ self.structure.output_matrix()[self._taken]
        m = len(self._given)
        if self._delay:
            a[self._first_delay : self._first_delay + m] = feedback
            older = slice(self._first_delay + m, self._last)
            a[older, self._first_delay : self._last - m] = np.eye((self._delay - 1) * m)
        if self.n > self._last:
            a[self._last :] = acting
        none = np.zeros((n, p))
        empty = np.zeros((self.dense, n, p)), np.zeros((self.dense, p, p))
        return Point(Sampled(a, b, da, db, drift, ddrift), none, None, *empty)

    def _output(self) -> Array:
        """f(k) as rows over the loop's states, shape (given, n)."""
        rows = np.zeros((len(self._given), self.n))
        plant = len(self.structure.states)
        rows[:, :plant] = self._feedback.D @ self.structure.output_matrix()[self._taken]
        rows[:, plant : self._first_delay] = self._feedback.C
        return rows

    def _acting(self) -> Array:
        """The feedback that acts now, f(k - d), as rows over the loop's states."""
        if not self._delay:
            return self._output()
        rows = np.zeros((len(self._given), self.n))
        rows[:, self._last - len(self._given) : self._last] = np.eye(len(self._given))
        return rows


def driven_by_external(record: Record, given: tuple[str, ...], *, joint: bool) -> Record:
    """The record as the loop sees it: input r, outputs y and for the joint approach the last u - r.

    Args:
        record: with an external signal.
        given: inputs the feedback commands.
        joint: whether u is an output.

    Raises:
        InputError: there is no external signal.
    """
    if record.r is None or not np.any(np.ptp(record.r, axis=0) > 0.0):
        problem = "no external signal within the input"
        raise InputError(problem, allowed="a flight with an excitation on the command", key=record.name)
    if not joint:
        return replace(record, u=record.r)
    places = [record.inputs.index(name) for name in given]
    fed = (record.u - record.r)[:, places]
    before = np.vstack((fed[:1], fed[:-1]))
    return replace(record, u=record.r, outputs=(*record.outputs, *given), y=np.hstack((record.y, before)))
