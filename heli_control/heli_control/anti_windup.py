"""How the states of a sampled controller follow when the command that went out is not the one asked for.

    asked = C x + D in,   x+ = A x + B in + E (applied - asked)

While the command is limited the controller runs on A - E C, so E must make that decay. Two ways:

observer    loop shaping: the controller is an observer of the shaped plant G_s = G W_1. Its model of the
            plant is driven by the command that was applied, its model of W_1 by the one asked for (Sefton
            and Glover 1990, Skogestad and Postlethwaite sec. 9.4.5)
tracking    any controller: its output, read as a measurement, corrects its state by the stationary Kalman
            gain (observer form of back-calculation, Åström and Wittenmark 1984)
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_discrete_are

from heli_common.linear_model import StateSpace
from heli_control.loop_shaping import LoopShaping
from heli_control.realisation import Array, Realisation

_OUTPUT_NOISE = 1e-2
"""Share of the output's stationary variance taken as its noise: how hard the state is pulled."""


def tracking_gain(sampled: StateSpace, output_scales: Array, input_scales: Array) -> Array:
    """E by which the controller's states follow its applied commands.

    Args:
        sampled: n states, m inputs, p outputs.
        output_scales: what counts as large for each output, shape (p,).
        input_scales: for each input, shape (m,).

    Returns:
        shape (n, p), with A - E C stable.
    """
    n, p = len(sampled.states), len(sampled.outputs)
    if n == 0:
        return np.zeros((0, p))
    b = sampled.B * input_scales
    c = sampled.C / output_scales[:, None]
    process = b @ b.T + 1e-9 * np.trace(b @ b.T) / n * np.eye(n)
    seen = c @ process @ c.T
    noise = _OUTPUT_NOISE * (seen + np.trace(seen) / p * np.eye(p))
    cost = solve_discrete_are(sampled.A.T, c.T, process, noise)
    gain = sampled.A @ cost @ c.T @ np.linalg.inv(c @ cost @ c.T + noise)
    return np.asarray(gain / output_scales, dtype=np.float64)


def observer_input(found: LoopShaping, plant: Realisation, w_1: Realisation) -> Array:
    """Input matrix of (applied - asked) for W_1 in series with the observer form of K_inf, scaled signals.

    Args:
        found: design with W_2 = I.
        plant: G, m inputs. w_1: m inputs and outputs.

    Returns:
        shape (n, m) for the states of W_1, then those of the observer: G, then W_1.
    """
    m = plant.B.shape[1]
    driven = np.vstack((plant.B, np.zeros((w_1.order, m)))) / found.factors.scales[:, None]
    return np.vstack((np.zeros((w_1.order, m)), driven))
