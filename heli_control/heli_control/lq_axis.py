"""Linear quadratic regulator of one axis, continuous and at 100 Hz (source sec. 3.2.2, spec 3.3).

The full-information plant holds rigid-body states only; faster states of the model (servo rotor, induced
velocities) are residualised, that is replaced by where they would come to rest. Scaled by source Table 2.4,
the continuous design minimises

    J = integral of x' Q x + u' R u dt,   K = R^-1 B' P,   0 = A' P + P A - P B R^-1 B' P + Q   (eq. 3.8-3.11)

The discrete design has the same Q and R and the sampled plant whose input acts late. The commands under way
are states of that plant, so the regulator feeds its own last commands back:

    u(k) = -K_x (x(k) - x_ref(k)) - K_1 u(k-1) - K_2 u(k-2)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_are, solve_discrete_are

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.timing import CONTROL_PERIOD
from heli_control.controller_file import ControllerAxis
from heli_control.flight_plants import REFERENCES, SCALES
from heli_control.state_space import delayed_zero_order_hold

Array = NDArray[np.float64]
Poles = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class AxisDesign:
    """One axis: the plant designed on and the gains for u = -K x in SI.

    Attributes:
        states: names of the plant's states; inputs: names of its commands.
        A: shape (n, n). B: shape (n, m). Residualised, not scaled.
        continuous: gain of the continuous design, shape (m, n).
        discrete: gain of the discrete design on the state, shape (m, n).
        past: gain of the discrete design on the past commands, newest first, shape (m, l m).
        poles: of the continuous closed loop [rad/s].
        discrete_poles: of the discrete closed loop, delay included [in the z plane].
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    A: Array
    B: Array
    continuous: Array
    discrete: Array
    past: Array
    poles: Poles
    discrete_poles: Poles


def residualised(system: StateSpace, states: tuple[str, ...], inputs: tuple[str, ...]) -> tuple[Array, Array]:
    """A and B of the named states and inputs, all other states at rest: 0 = A_21 x_1 + A_22 x_2 + B_2 u.

    Args:
        system: continuous plant with at least these states and inputs.
        states: n states to keep, in the order wanted.
        inputs: m inputs to keep.

    Returns:
        shape (n, n) and (n, m).

    Raises:
        InputError: a name that the plant lacks, or other states that do not come to rest.
    """
    for names, known, key in ((states, system.states, "states"), (inputs, system.inputs, "inputs")):
        for name in names:
            if name not in known:
                allowed = f"at least {', '.join(names)}"
                raise InputError(f"{', '.join(known)} lacks {name!r}", allowed=allowed, key=key)
    kept = [system.states.index(name) for name in states]
    rest = [index for index in range(len(system.states)) if index not in kept]
    columns = [system.inputs.index(name) for name in inputs]
    a, b = system.A, system.B[:, columns]
    slow_a, slow_b = a[np.ix_(kept, kept)], b[kept]
    if not rest:
        return slow_a, slow_b
    fast = a[np.ix_(rest, rest)]
    if max(np.linalg.eigvals(fast).real) >= 0.0:
        others = ", ".join(system.states[index] for index in rest)
        raise InputError(f"{others} do not come to rest by themselves", allowed="stable", key="states")
    coupling = a[np.ix_(kept, rest)]
    slow_a = slow_a - coupling @ np.linalg.solve(fast, a[np.ix_(rest, kept)])
    slow_b = slow_b - coupling @ np.linalg.solve(fast, b[rest])
    return slow_a, slow_b


def design_axis(
    system: StateSpace,
    states: tuple[str, ...],
    inputs: tuple[str, ...],
    state_weights: Array,
    input_weights: Array,
    delay: float,
) -> AxisDesign:
    """Continuous and discrete design of one axis.

    Args:
        system: continuous plant in SI.
        states: n states that are measured and fed back.
        inputs: m commands.
        state_weights: diagonal of Q on the scaled plant, shape (n,).
        input_weights: diagonal of R on the scaled plant, shape (m,).
        delay: of the commands [s], for the discrete design.

    Raises:
        InputError: the plant lacks a signal, or cannot be stabilised with these weights.
    """
    a, b = residualised(system, states, inputs)
    x_scale = np.array([SCALES[name] for name in states])
    u_scale = np.array([SCALES[name] for name in inputs])
    scaled_a = a * x_scale[None, :] / x_scale[:, None]
    scaled_b = b * u_scale[None, :] / x_scale[:, None]
    q, r = np.diag(state_weights), np.diag(input_weights)
    n = len(states)
    sampled_a, sampled_b = delayed_zero_order_hold(scaled_a, scaled_b, CONTROL_PERIOD, delay)
    sampled_q = np.zeros_like(sampled_a)
    sampled_q[:n, :n] = q
    try:
        cost = solve_continuous_are(scaled_a, scaled_b, q, r)
        sampled_cost = solve_discrete_are(sampled_a, sampled_b, sampled_q, r)
    except np.linalg.LinAlgError as error:
        raise InputError(f"no stabilising solution: {error}", key="weights") from None
    gain = np.linalg.solve(r, scaled_b.T @ cost)
    sampled_gain = np.linalg.solve(
        r + sampled_b.T @ sampled_cost @ sampled_b, sampled_b.T @ sampled_cost @ sampled_a
    )
    past_scale = np.tile(u_scale, (len(sampled_a) - n) // len(inputs))
    return AxisDesign(
        states=states,
        inputs=inputs,
        A=a,
        B=b,
        continuous=gain * u_scale[:, None] / x_scale[None, :],
        discrete=sampled_gain[:, :n] * u_scale[:, None] / x_scale[None, :],
        past=sampled_gain[:, n:] * u_scale[:, None] / past_scale[None, :],
        poles=_sorted(np.linalg.eigvals(scaled_a - scaled_b @ gain)),
        discrete_poles=_sorted(np.linalg.eigvals(sampled_a - sampled_b @ sampled_gain)),
    )


def controller_block(design: AxisDesign) -> ControllerAxis:
    """The discrete controller: states are the past commands, newest first, as they were applied."""
    n, m = len(design.states), len(design.inputs)
    late = design.past.shape[1] // m
    referenced = [name for name in design.states if name in REFERENCES]
    inputs = design.states + tuple(REFERENCES[name] for name in referenced)
    direct = np.zeros((m, len(inputs)))
    direct[:, :n] = -design.discrete
    for column, name in enumerate(referenced):
        direct[:, n + column] = design.discrete[:, design.states.index(name)]
    a, b = np.zeros((late * m, late * m)), np.zeros((late * m, len(inputs)))
    if late:
        a[:m], b[:m] = -design.past, direct
        a[m:, :-m] = np.eye((late - 1) * m)
    applied = np.eye(late * m, m)
    states = tuple(f"{name}_{age}" for age in range(1, late + 1) for name in design.inputs)
    return ControllerAxis(StateSpace(states, inputs, design.inputs, a, b, -design.past, direct), applied)


def _sorted(poles: Any) -> Poles:
    values = np.asarray(poles, dtype=np.complex128)
    return np.asarray(values[np.lexsort((values.imag, values.real))], dtype=np.complex128)
