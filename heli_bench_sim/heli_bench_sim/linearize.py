"""Linear models at a trim: A, B, C, D by central differences, and their parts (source sec. 2.4.1-2.4.3)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.helicopter import derivative
from heli_bench_sim.parameters import Constants, HelicopterParameters, constants
from heli_bench_sim.states import (
    INPUT_NAMES,
    MEASURED_NAMES,
    STATE_NAMES,
    STATE_SIZE,
    State,
)
from heli_bench_sim.trim import Trim
from heli_common.linear_model import StateSpace, positions

Array = NDArray[np.float64]

STEP = 1e-4
"""Step of the differences, relative to 1 SI unit or the state's own size. Rounding stays below 1e-10; the
drag, quadratic in a speed that is zero here, has no third derivative and leaves 5e-7 1/s in X_u and Y_v."""

HORIZONTAL_STATES = ("theta", "phi", "u", "v", "q", "p", "a_1p", "b_1p")
HORIZONTAL_INPUTS = ("B_1s", "A_1s")
HORIZONTAL_OUTPUTS = ("theta", "phi", "u", "v", "q", "p")

VERTICAL_STATES = ("w", "r", "V_i", "V_t")
VERTICAL_INPUTS = ("theta_0", "theta_t")
VERTICAL_OUTPUTS = ("w", "r")

DRIVE_STATES, DRIVE_INPUTS, DRIVE_OUTPUTS = ("Omega", "M_A"), ("U_mot",), ("Omega",)

NO_LOAD = np.zeros(3)


def jacobian(function: Callable[[Array], Array], point: Array, step: float = STEP) -> Array:
    """(m, n) derivative of a vector function: central differences with Richardson's extrapolation.

    Args:
        function: maps (n,) to (m,).
        point: (n,) where.
        step: step per component, relative to max(1, |component|).
    """

    def central(index: int, size: float) -> Array:
        ahead, behind = point.copy(), point.copy()
        ahead[index] += size
        behind[index] -= size
        # the steps as they really are after rounding
        slope: Array = (function(ahead) - function(behind)) / (ahead[index] - behind[index])
        return slope

    columns = []
    for index in range(point.size):
        size = step * max(1.0, abs(float(point[index])))
        columns.append((4.0 * central(index, 0.5 * size) - central(index, size)) / 3.0)
    return np.column_stack(columns)


def rates(
    state: Array,
    inputs: Array,
    c: Constants,
    *,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    rotor_speed_held: bool = False,
) -> Array:
    """(18,) x' of the helicopter alone.

    Args:
        state: (18,) in the order of `State`.
        inputs: (5,) in the order of `Input`.
        c: constants of the helicopter.
        wind: (3,) velocity of the air, NED [m/s].
        rotor_speed_held: an ideal governor gives just the motor torque that keeps Omega' = 0.
    """
    air, out = np.array(wind, dtype=np.float64), np.zeros(STATE_SIZE)
    derivative(state, inputs, air, NO_LOAD, NO_LOAD, c, out)
    if rotor_speed_held:
        governed = state.copy()
        governed[State.M_A] -= c.drive_inertia * out[State.Omega] / c.motor_gear
        derivative(governed, inputs, air, NO_LOAD, NO_LOAD, c, out)
    return out


def linearize(
    parameters: HelicopterParameters,
    trim: Trim,
    *,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    rotor_speed_held: bool = False,
    step: float = STEP,
) -> StateSpace:
    """The full linear model: 18 states, 5 inputs, 13 measured outputs (source eq. 2.59, 2.60).

    Args:
        parameters: the helicopter.
        trim: the operating point.
        wind: (3,) velocity of the air at that point, NED [m/s].
        rotor_speed_held: with an ideal governor, see `rates`; the body then feels the rotors' torque, not the
            acceleration of the shaft.
        step: of the differences.
    """
    c = constants(parameters)

    def function(point: Array) -> Array:
        return rates(
            point[:STATE_SIZE],
            point[STATE_SIZE:],
            c,
            wind=wind,
            rotor_speed_held=rotor_speed_held,
        )

    both = jacobian(function, np.concatenate([trim.state, trim.inputs]), step)
    measured = np.zeros((len(MEASURED_NAMES), STATE_SIZE))
    measured[range(len(MEASURED_NAMES)), positions(MEASURED_NAMES, STATE_NAMES, "state")] = 1.0
    return StateSpace(
        STATE_NAMES,
        INPUT_NAMES,
        MEASURED_NAMES,
        both[:, :STATE_SIZE],
        both[:, STATE_SIZE:],
        measured,
        np.zeros((len(MEASURED_NAMES), len(INPUT_NAMES))),
    )


def horizontal(parameters: HelicopterParameters, trim: Trim) -> StateSpace:
    """Horizontal motion: theta phi u v q p a_1p b_1p, driven by the cyclic (source sec. 2.4.2).

    Args:
        parameters: the helicopter.
        trim: the operating point.
    """
    return linearize(parameters, trim).part(HORIZONTAL_STATES, HORIZONTAL_INPUTS, HORIZONTAL_OUTPUTS)


def vertical(parameters: HelicopterParameters, trim: Trim) -> StateSpace:
    """Vertical motion and yaw: w r V_i V_t, driven by both collectives, rotor speed held (sec. 2.4.3).

    Args:
        parameters: the helicopter.
        trim: the operating point.
    """
    model = linearize(parameters, trim, rotor_speed_held=True)
    return model.part(VERTICAL_STATES, VERTICAL_INPUTS, VERTICAL_OUTPUTS)


def vertical_with_drive(parameters: HelicopterParameters, trim: Trim) -> StateSpace:
    """Vertical motion, yaw and drive: w r V_i V_t Omega M_A; nothing holds the rotor speed.

    The collective slows the rotor, and what the motor makes of that turns the body: on the bench yaw feels
    both collectives through the drive (source sec. 2.3.3).

    Args:
        parameters: the helicopter.
        trim: the operating point.
    """
    return linearize(parameters, trim).part(
        VERTICAL_STATES + DRIVE_STATES, VERTICAL_INPUTS + DRIVE_INPUTS, VERTICAL_OUTPUTS + DRIVE_OUTPUTS
    )


@dataclass(frozen=True)
class AngularDerivatives:
    """Derivatives of the angular accelerations (source Table 2.6)."""

    M_q: float
    """pitch acceleration per pitch rate [1/s]"""
    L_p: float
    """roll acceleration per roll rate [1/s]"""
    M_a: float
    """pitch acceleration per servo rotor tilt back [1/s^2]"""
    M_b: float
    """pitch acceleration per servo rotor tilt right [1/s^2]"""
    L_a: float
    """roll acceleration per servo rotor tilt back [1/s^2]"""
    L_b: float
    """roll acceleration per servo rotor tilt right [1/s^2]"""
    M_1: float
    """pitch acceleration per B_1s [1/s^2 per degree of B_1s]"""
    M_2: float
    """pitch acceleration per A_1s [1/s^2 per degree of A_1s]"""
    L_1: float
    """roll acceleration per B_1s [1/s^2 per degree of B_1s]"""
    L_2: float
    """roll acceleration per A_1s [1/s^2 per degree of A_1s]"""


@dataclass(frozen=True)
class SpeedDerivatives:
    """Derivatives with respect to the horizontal speed, angles in rad (source Table 2.6, units uncertain)."""

    M_u: float
    """pitch acceleration per forward speed [rad/(m s)]"""
    M_v: float
    """pitch acceleration per side speed [rad/(m s)]"""
    L_u: float
    """roll acceleration per forward speed [rad/(m s)]"""
    L_v: float
    """roll acceleration per side speed [rad/(m s)]"""
    X_u: float
    """forward acceleration per forward speed [1/s]"""
    Y_v: float
    """side acceleration per side speed [1/s]"""


def angular_derivatives(model: StateSpace) -> AngularDerivatives:
    """The ten derivatives of a full or horizontal model; the four of the inputs per degree, as printed.

    Args:
        model: a full or horizontal linear model.
    """
    per_degree = math.radians(1.0)
    return AngularDerivatives(
        M_q=_entry(model, "q", "q"),
        L_p=_entry(model, "p", "p"),
        M_a=_entry(model, "q", "a_1p"),
        M_b=_entry(model, "q", "b_1p"),
        L_a=_entry(model, "p", "a_1p"),
        L_b=_entry(model, "p", "b_1p"),
        M_1=_entry(model, "q", "B_1s") * per_degree,
        M_2=_entry(model, "q", "A_1s") * per_degree,
        L_1=_entry(model, "p", "B_1s") * per_degree,
        L_2=_entry(model, "p", "A_1s") * per_degree,
    )


def speed_derivatives(model: StateSpace) -> SpeedDerivatives:
    """The six speed derivatives of a full or horizontal model: listed, not scored.

    Args:
        model: a full or horizontal linear model.
    """
    return SpeedDerivatives(
        M_u=_entry(model, "q", "u"),
        M_v=_entry(model, "q", "v"),
        L_u=_entry(model, "p", "u"),
        L_v=_entry(model, "p", "v"),
        X_u=_entry(model, "u", "u"),
        Y_v=_entry(model, "v", "v"),
    )


def _entry(model: StateSpace, state: str, cause: str) -> float:
    row = positions([state], model.states, "state")[0]
    if cause in model.inputs:
        return float(model.B[row, model.inputs.index(cause)])
    return float(model.A[row, positions([cause], model.states, "state or input")[0]])
