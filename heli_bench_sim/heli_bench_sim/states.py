"""State, input and measurement of the helicopter in the order of the source (sec. 2.4)."""

from __future__ import annotations

from enum import IntEnum


class State(IntEnum):
    """The 18 states: earth frame NED, body frame FRD at the centre of gravity, SI units."""

    x = 0
    """north [m], from the flight-space centre"""
    y = 1
    """east [m]"""
    z = 2
    """down [m]"""
    psi = 3
    """yaw [rad]"""
    theta = 4
    """pitch [rad]"""
    phi = 5
    """roll [rad]"""
    u = 6
    """body velocity forward [m/s]"""
    v = 7
    """body velocity right [m/s]"""
    q = 8
    """pitch rate [rad/s]"""
    p = 9
    """roll rate [rad/s]"""
    a_1p = 10
    """longitudinal flapping of the servo rotor [rad]"""
    b_1p = 11
    """lateral flapping of the servo rotor [rad]"""
    w = 12
    """body velocity down [m/s]"""
    r = 13
    """yaw rate [rad/s]"""
    Omega = 14
    """main rotor speed [rad/s]"""
    M_A = 15
    """motor torque [N m]"""
    V_i = 16
    """induced velocity of the main rotor [m/s]"""
    V_t = 17
    """induced velocity of the tail rotor [m/s]"""


class Input(IntEnum):
    """The five inputs: actual blade angles [rad] and the drive's control voltage."""

    B_1s = 0
    """longitudinal cyclic of the swash plate, positive tilts the disc back [rad]"""
    A_1s = 1
    """lateral cyclic of the swash plate, positive tilts the disc right [rad]"""
    theta_0 = 2
    """collective, positive for more thrust [rad]"""
    theta_t = 3
    """tail collective, positive for more thrust [rad]"""
    U_mot = 4
    """control voltage of the supply [V], 0..10"""


STATE_SIZE = len(State)
INPUT_SIZE = len(Input)

STATE_NAMES = tuple(state.name for state in State)
INPUT_NAMES = tuple(each.name for each in Input)

MEASURED_NAMES = ("x", "y", "z", "psi", "theta", "phi", "u", "v", "q", "p", "w", "r", "Omega")
"""The 13 measured outputs (source sec. 2.4)."""
