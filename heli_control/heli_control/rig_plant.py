"""What rig and sensors add to a linear helicopter: friction of the arms, lag of the rotor speed's sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace

MEASURED_SPEED = "Omega_measured"


def with_friction(plant: StateSpace, viscous: Mapping[str, float], mass: float) -> StateSpace:
    """The plant with viscous friction on velocities that are states.

    Args:
        plant: continuous.
        viscous: coefficient per state, e.g. u 7.7, v 8.6, w 5.0 on the bench [N s/m] (spec 2.1).
        mass: [kg].

    Raises:
        InputError: a state the plant has not. ValueError: a mass that is not positive.
    """
    if not mass > 0.0:
        raise ValueError(f"mass {mass} kg; allowed: above 0")
    a = plant.A.copy()
    for name, value in viscous.items():
        if name not in plant.states:
            raise InputError(f"{name!r} is no state of the plant", allowed=", ".join(plant.states))
        index = plant.states.index(name)
        a[index, index] -= value / mass
    return replace(plant, A=a)


def with_speed_sensor(plant: StateSpace, lag: float) -> StateSpace:
    """The plant with the rotor speed as its sensor gives it, one lag later, as state and output.

    Args:
        plant: continuous, with `Omega` as a state.
        lag: time constant [s].

    Raises:
        InputError: a plant without rotor speed. ValueError: a lag that is not positive.
    """
    if not lag > 0.0:
        raise ValueError(f"lag {lag} s; allowed: above 0")
    if "Omega" not in plant.states:
        raise InputError("'Omega' is no state of the plant", allowed=", ".join(plant.states))
    n, m, count = len(plant.states), len(plant.inputs), len(plant.outputs)
    a, c = np.zeros((n + 1, n + 1)), np.zeros((count + 1, n + 1))
    a[:n, :n], a[n, n], a[n, plant.states.index("Omega")] = plant.A, -1.0 / lag, 1.0 / lag
    c[:count, :n], c[count, n] = plant.C, 1.0
    return StateSpace(
        (*plant.states, MEASURED_SPEED),
        plant.inputs,
        (*plant.outputs, MEASURED_SPEED),
        a,
        np.vstack((plant.B, np.zeros((1, m)))),
        c,
        np.vstack((plant.D, np.zeros((1, m)))),
    )
