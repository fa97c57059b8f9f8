"""Indirect and joint input-output approach: the whole loop, driven by the external signal (source 2.5.1).

Indirect: y = G_cl(theta) r with the known feedback in G_cl. Joint: y and u are outputs of the loop driven
by r. Both need the controller, linear and exactly as flown; every error in it (delay, limits, an outer
loop, the hold of the servos) goes into the coefficients. The source drops them because its predictor went
unstable; in output-error form the predictor is the loop itself and is stable wherever the loop is. If u - r
follows from y by the known feedback without noise of its own, the joint approach weighs the same facts
twice: its weighting is therefore diagonal and its standard errors are the robust ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_identification.closed_loop import ClosedLoop, driven_by_external
from heli_identification.prediction_error import Estimate, Search, estimate
from heli_identification.records import Record
from heli_identification.structures import Structure

Array = NDArray[np.float64]


def indirect(
    structure: Structure,
    records: Sequence[Record],
    feedback: StateSpace,
    *,
    delay: int = 0,
    joint: bool = False,
    search: Search | None = None,
) -> Estimate:
    """Estimate from the closed loop.

    Args:
        structure: plant.
        records: data with external signals, inputs held.
        feedback: discrete controller, from outputs to inputs of the plant.
        delay: between its output and the plant's input, in samples.
        joint: whether u is predicted beside y.
        search: how the minimum is looked for.

    Raises:
        InputError: no external signal, a feedback of other signals, a loop that is unstable at the start
            values.
    """
    loop = ClosedLoop(structure, feedback, records[0].period, delay, joint=joint)
    data = [driven_by_external(record, feedback.outputs, joint=joint) for record in records]
    try:
        first = estimate(loop, data, weighting=_signal_weighting(data) if joint else None, search=search)
        if not joint:
            return first
        spread = np.mean([np.mean(part**2, axis=0) for part in first.residuals], axis=0)
        return estimate(loop, data, weighting=np.diag(spread), search=search)
    except InputError as error:
        if "unstable" not in error.problem:
            raise
        problem = "the closed loop of prior model and given controller is unstable"
        allowed = "a controller that stabilises the prior model, with its true delay"
        raise InputError(problem, allowed=allowed, key=structure.name) from None


def _signal_weighting(records: Sequence[Record]) -> Array:
    """Weights every output as if a hundredth of its variance were error, to begin with."""
    spread = np.mean([np.var(record.y, axis=0) for record in records], axis=0)
    return np.diag(0.01 * np.maximum(spread, 1e-300))
