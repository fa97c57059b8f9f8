"""Hover trim: the steady state over one spot, rotor speed given (source sec. 2.4.1, eq. 2.58, Table 2.3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from heli_bench_sim.helicopter import derivative, loads
from heli_bench_sim.parameters import Constants, HelicopterParameters, constants
from heli_bench_sim.states import INPUT_SIZE, STATE_SIZE, Input, State
from heli_common.linear_model import OperatingPoint

Array = NDArray[np.float64]

FREE_STATES = (State.phi, State.theta, State.a_1p, State.b_1p, State.V_i, State.V_t)
FREE_INPUTS = (Input.theta_0, Input.theta_t, Input.B_1s, Input.A_1s)
STEADY_STATES = (
    State.u,
    State.v,
    State.w,
    State.p,
    State.q,
    State.r,
    State.a_1p,
    State.b_1p,
    State.V_i,
    State.V_t,
)
"""States whose derivative must vanish; position and heading may stand anywhere, the drive follows."""

LARGEST_RESIDUAL = 1e-8
"""Largest derivative left in a trim, in SI units of each state per second."""

NO_LOAD = np.zeros(3)


class Trim(OperatingPoint):
    """Operating point of hovering flight as state and inputs of the bench."""

    @property
    def state(self) -> Array:
        """(18,) state at the flight-space centre, heading north, at rest over the ground."""
        state = np.zeros(STATE_SIZE)
        for name in (*FREE_STATES, State.M_A, State.Omega):
            state[name] = getattr(self, name.name)
        return state

    @property
    def inputs(self) -> Array:
        """(5,) inputs that keep it there."""
        return np.array([getattr(self, name.name) for name in Input])


def trim(parameters: HelicopterParameters, wind: Sequence[float] = (0.0, 0.0, 0.0)) -> Trim:
    """Steady hover over one spot, heading north, at the nominal rotor speed.

    The drive is excluded from the search: torque, current and voltage follow from the rotors' torque.

    Args:
        parameters: the helicopter.
        wind: (3,) velocity of the air, NED [m/s].

    Returns:
        The operating point, source Table 2.3.

    Raises:
        ValueError: no steady hover exists, or it lies beyond the supply's limits; names wind and values.
    """
    c = constants(parameters)
    wind_earth = np.array(wind, dtype=np.float64)
    if wind_earth.shape != (3,) or not np.isfinite(wind_earth).all():
        raise ValueError(f"wind {wind!r} is not three finite numbers (NED, m/s)")

    def unpack(unknowns: Array) -> tuple[Array, Array]:
        state, inputs = np.zeros(STATE_SIZE), np.zeros(INPUT_SIZE)
        state[State.Omega] = parameters.rotor_speed
        state[list(FREE_STATES)] = unknowns[: len(FREE_STATES)]
        inputs[list(FREE_INPUTS)] = unknowns[len(FREE_STATES) :]
        load = loads(state, inputs, wind_earth, c)
        state[State.M_A] = (load.torque + c.tail_gear * load.tail_torque) / c.motor_gear
        current = state[State.M_A] / c.torque_constant
        voltage = c.torque_constant * c.motor_gear * parameters.rotor_speed + c.armature_resistance * current
        inputs[Input.U_mot] = voltage / c.supply_gain
        return state, inputs

    def residual(unknowns: Array) -> Array:
        state, inputs = unpack(unknowns)
        rate = np.zeros(STATE_SIZE)
        derivative(state, inputs, wind_earth, NO_LOAD, NO_LOAD, c, rate)
        return rate[list(STEADY_STATES)]

    solution = root(residual, _first_guess(parameters, c), tol=1e-13)
    state, inputs = unpack(solution.x)
    left = float(np.abs(residual(solution.x)).max())
    where = f"in wind {tuple(float(part) for part in wind)!r} m/s"
    if not left < LARGEST_RESIDUAL:
        raise ValueError(f"no steady hover {where}: a derivative of {left:.3g} is left")
    current = float(state[State.M_A]) / c.torque_constant
    voltage = float(inputs[Input.U_mot]) * c.supply_gain
    if not 0.0 <= current <= c.supply_current or not 0.0 <= voltage <= c.supply_voltage:
        raise ValueError(
            f"hover {where} needs {current:.1f} A and {voltage:.1f} V, beyond the supply's "
            f"{c.supply_current:g} A and {c.supply_voltage:g} V"
        )
    return Trim(
        **{name.name: float(state[name]) for name in (*FREE_STATES, State.M_A)},
        **{name.name: float(inputs[name]) for name in (*FREE_INPUTS, Input.U_mot)},
        I_motor=current,
        Omega=parameters.rotor_speed,
    )


def _first_guess(parameters: HelicopterParameters, c: Constants) -> Array:
    """Level hover from momentum theory, without the small angles: close enough for Newton's method."""
    omega = parameters.rotor_speed
    tail_omega = c.tail_gear * omega
    collective = (c.weight / c.lift_per_angle / omega + c.inflow_gradient * c.hover_inflow) / omega
    tail_collective = (
        c.tail_thrust / c.tail_lift_per_angle / tail_omega + c.tail_inflow_gradient * c.tail_hover_inflow
    ) / tail_omega
    return np.array(
        [0.0, 0.0, 0.0, 0.0, c.hover_inflow, c.tail_hover_inflow, collective, tail_collective, 0.0, 0.0]
    )
