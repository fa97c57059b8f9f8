"""The position law as part of a linear loop: what an attitude controller flies within (spec 3.2).

In hover, and away from its limits, the position law is PI per axis on positions that the velocities become:

    x' = u,   u_ref = -K_p x + I,   I+ = I - K_p T / T_i x

Heading and body axes are taken as one: in hover they differ by the trim's few degrees.
"""

from __future__ import annotations

import numpy as np

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.timing import CONTROL_PERIOD
from heli_control.position_control import PositionParameters

VELOCITIES = {"x": "u", "y": "v", "z": "w", "psi": "r"}
"""The velocity or rate that each position is the integral of."""


def with_positions(plant: StateSpace) -> StateSpace:
    """The plant with a position behind every velocity that is one of its states, as state and output.

    Args:
        plant: continuous, with some of u v w r as states.
    """
    added = {position: velocity for position, velocity in VELOCITIES.items() if velocity in plant.states}
    n, count, m = len(plant.states), len(added), len(plant.inputs)
    a = np.zeros((n + count, n + count))
    a[:n, :n] = plant.A
    for row, velocity in enumerate(added.values()):
        a[n + row, plant.states.index(velocity)] = 1.0
    c = np.zeros((len(plant.outputs) + count, n + count))
    c[: len(plant.outputs), :n], c[len(plant.outputs) :, n:] = plant.C, np.eye(count)
    return StateSpace(
        plant.states + tuple(added),
        plant.inputs,
        plant.outputs + tuple(added),
        a,
        np.vstack((plant.B, np.zeros((count, m)))),
        c,
        np.vstack((plant.D, np.zeros((count, m)))),
    )


def with_position_law(controller: StateSpace, parameters: PositionParameters) -> StateSpace:
    """A controller at 100 Hz whose references come from the position law instead of from outside.

    Args:
        controller: with some of u_ref v_ref w_ref r_ref as inputs, at least one.
        parameters: gains and times of the position law.

    Returns:
        the same outputs; each reference that there was is replaced by its position as an input.

    Raises:
        InputError: a controller without references.
    """
    found = {
        position: controller.inputs.index(f"{velocity}_ref")
        for position, velocity in VELOCITIES.items()
        if f"{velocity}_ref" in controller.inputs
    }
    if not found:
        allowed = "at least one of " + ", ".join(f"{velocity}_ref" for velocity in VELOCITIES.values())
        raise InputError("no reference among the inputs", allowed=allowed, key="inputs")
    kept = [column for column in range(len(controller.inputs)) if column not in found.values()]
    n, count = len(controller.states), len(found)
    gains = np.diag([getattr(parameters, f"gain_{position}") for position in found])
    times = np.diag([getattr(parameters, f"time_{position}") for position in found])
    b_ref, d_ref = (matrix[:, list(found.values())] for matrix in (controller.B, controller.D))
    a = np.block([[controller.A, b_ref], [np.zeros((count, n)), np.eye(count)]])
    b = np.block(
        [
            [controller.B[:, kept], -b_ref @ gains],
            [np.zeros((count, len(kept))), -CONTROL_PERIOD * gains @ np.linalg.inv(times)],
        ]
    )
    return StateSpace(
        controller.states + tuple(f"integral_{position}" for position in found),
        tuple(controller.inputs[column] for column in kept) + tuple(found),
        controller.outputs,
        a,
        b,
        np.hstack((controller.C, d_ref)),
        np.hstack((controller.D[:, kept], -d_ref @ gains)),
    )
