"""The whole helicopter: x' = f(x, u) of 18 states, used for flight, batches and linearisation alike.

source eq. 2.50-2.56, B.29-B.54; signs and rebuilt parameters as in the package's README.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import (
    airframe,
    drive,
    flapping,
    h_force,
    inflow,
    rigid_body,
    rotor,
    servo_rotor,
    tail_rotor,
)
from heli_bench_sim.parameters import Constants
from heli_bench_sim.states import Input, State
from heli_common.compiled import compiled, equation

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Inputs = tuple[float, float, float, float, float]
"""Actual blade angles B_1s, A_1s, theta_0, theta_t [rad] and the control voltage [V]."""


@compiled
def derivative(
    state: Array,
    inputs: Array,
    wind_earth: Array,
    force_earth: Array,
    moment_body: Array,
    c: Constants,
    out: Array,
) -> None:
    """Write the time derivative of the state into `out`.

    Args:
        state: (18,) in the order of `State`, earth NED, body FRD, SI.
        inputs: (5,) in the order of `Input`: actual blade angles [rad] and control voltage [V].
        wind_earth: (3,) velocity of the air, NED [m/s].
        force_earth: (3,) further force at the centre of gravity, NED [N].
        moment_body: (3,) further moment, FRD [N m].
        c: constants of the helicopter.
        out: (18,) receives the derivative.
    """
    write_derivative(
        state,
        (inputs[0], inputs[1], inputs[2], inputs[3], inputs[4]),
        (wind_earth[0], wind_earth[1], wind_earth[2]),
        (force_earth[0], force_earth[1], force_earth[2]),
        (moment_body[0], moment_body[1], moment_body[2]),
        c,
        out,
    )


@equation
def write_derivative(
    state: Array,
    inputs: Inputs,
    wind_earth: Vector,
    force_earth: Vector,
    moment_body: Vector,
    c: Constants,
    out: Array,
) -> None:
    """The same with numbers in place of small arrays, for the inner loop; `state` and `out` may be longer.

    Args:
        state: (18 or more,) in the order of `State`, earth NED, body FRD, SI.
        inputs: actual blade angles [rad] and control voltage [V].
        wind_earth: velocity of the air, NED [m/s].
        force_earth: further force at the centre of gravity, NED [N].
        moment_body: further moment, FRD [N m].
        c: constants of the helicopter.
        out: (18 or more,) receives the derivative.
    """
    psi, theta, phi = state[State.psi], state[State.theta], state[State.phi]
    u, v, w = state[State.u], state[State.v], state[State.w]
    p, q, r = state[State.p], state[State.q], state[State.r]
    a_1p, b_1p = state[State.a_1p], state[State.b_1p]
    omega, m_a = state[State.Omega], state[State.M_A]
    v_i, v_t = state[State.V_i], state[State.V_t]
    b_1s, a_1s, theta_0, theta_t, voltage = inputs

    wind_u, wind_v, wind_w = rigid_body.body_from_earth(
        wind_earth[0], wind_earth[1], wind_earth[2], psi, theta, phi
    )
    u_a, v_a, w_a = u - wind_u, v - wind_v, w - wind_w

    thrust = rotor.thrust(theta_0, omega, v_i, u_a, v_a, w_a, c)
    torque = rotor.torque(thrust, theta_0, omega, v_i, w_a, c)
    tail_thrust = tail_rotor.thrust(theta_t, omega, v_t, v_a, r, c)
    tail_torque = tail_rotor.torque(tail_thrust, theta_t, omega, v_t, c)
    a_1, b_1 = flapping.disc_tilt(a_1p, b_1p, b_1s, a_1s, theta_0, omega, v_i, u_a, v_a, q, p, c)
    torque += h_force.h_force_torque(thrust, theta_0, omega, v_i, u_a, v_a, w_a, a_1, b_1, c.h_force)
    speed_up = drive.rotor_acceleration(m_a, torque, tail_torque, c)

    # Forces (source eq. 2.50): weight and further forces are given in earth axes
    outer_x, outer_y, outer_z = rigid_body.body_from_earth(
        force_earth[0], force_earth[1], force_earth[2] + c.weight, psi, theta, phi
    )
    drag_x, drag_y, drag_z = airframe.drag(u_a, v_a, w_a, c)
    sin_a, cos_a = math.sin(a_1), math.cos(a_1)
    sin_b, cos_b = math.sin(b_1), math.cos(b_1)
    force_x = outer_x + drag_x - thrust * sin_a
    force_y = outer_y + drag_y + thrust * sin_b + tail_thrust
    force_z = outer_z + drag_z - thrust * cos_a * cos_b

    # Moments (source eq. B.40-B.42): the body feels the reaction to all torque in the rotor shaft
    stiffness = flapping.hub_stiffness(omega, c)
    rolling = stiffness * b_1 - c.hub_z * thrust * sin_b - c.tail_z * tail_thrust
    pitching = stiffness * a_1 - c.hub_z * thrust * sin_a + c.hub_x * thrust * cos_a * cos_b + tail_torque
    yawing = torque + c.shaft_inertia * speed_up + c.hub_x * thrust * sin_b + c.tail_x * tail_thrust

    out[State.x], out[State.y], out[State.z] = rigid_body.earth_from_body(u, v, w, psi, theta, phi)
    out[State.psi], out[State.theta], out[State.phi] = rigid_body.euler_rates(p, q, r, theta, phi)
    out[State.u], out[State.v], out[State.w] = rigid_body.accelerations(
        force_x, force_y, force_z, u, v, w, p, q, r, c
    )
    out[State.p], out[State.q], out[State.r] = rigid_body.angular_accelerations(
        rolling + moment_body[0], pitching + moment_body[1], yawing + moment_body[2], p, q, r, c
    )
    out[State.a_1p], out[State.b_1p] = servo_rotor.flapping_rates(
        a_1p, b_1p, b_1s, a_1s, theta_0, omega, q, p, c
    )
    out[State.Omega] = speed_up
    out[State.M_A] = drive.torque_rate(m_a, drive.current(voltage, omega, c), c)
    out[State.V_i] = inflow.rate(v_i, thrust, w_a, c)
    out[State.V_t] = inflow.tail_rate(v_t, tail_thrust, c)


LEAST_THRUST = 0.05
"""Share of the weight below which the rotor has no wake worth a name (D)."""


class Loads(NamedTuple):
    """What the rotors and the drive carry at one instant."""

    thrust: float
    """main rotor thrust [N]"""
    torque: float
    """main rotor torque [N m]"""
    tail_thrust: float
    """tail rotor thrust [N]"""
    tail_torque: float
    """tail rotor torque on its own shaft [N m]"""
    current: float
    """motor current [A]"""
    section_angle: float
    """angle of attack of the main blade at 0.75 R [rad]"""
    descent_ratio: float
    """velocity down through the air over the rotor's hover inflow; 0 without thrust"""


@compiled
def loads(state: Array, inputs: Array, wind_earth: Array, c: Constants) -> Loads:
    """Loads of rotors and drive in a state.

    Args:
        state: (18,) in the order of `State`.
        inputs: (5,) in the order of `Input`.
        wind_earth: (3,) velocity of the air, NED [m/s].
        c: constants of the helicopter.
    """
    wind_u, wind_v, wind_w = rigid_body.body_from_earth(
        wind_earth[0], wind_earth[1], wind_earth[2], state[State.psi], state[State.theta], state[State.phi]
    )
    u_a, v_a, w_a = state[State.u] - wind_u, state[State.v] - wind_v, state[State.w] - wind_w
    omega, v_i, v_t = state[State.Omega], state[State.V_i], state[State.V_t]
    theta_0, theta_t = inputs[Input.theta_0], inputs[Input.theta_t]
    thrust = rotor.thrust(theta_0, omega, v_i, u_a, v_a, w_a, c)
    tail_thrust = tail_rotor.thrust(theta_t, omega, v_t, v_a, state[State.r], c)
    a_1, b_1 = flapping.disc_tilt(
        state[State.a_1p],
        state[State.b_1p],
        inputs[Input.B_1s],
        inputs[Input.A_1s],
        theta_0,
        omega,
        v_i,
        u_a,
        v_a,
        state[State.q],
        state[State.p],
        c,
    )
    return Loads(
        thrust,
        rotor.torque(thrust, theta_0, omega, v_i, w_a, c)
        + h_force.h_force_torque(thrust, theta_0, omega, v_i, u_a, v_a, w_a, a_1, b_1, c.h_force),
        tail_thrust,
        tail_rotor.torque(tail_thrust, theta_t, omega, v_t, c),
        drive.current(inputs[Input.U_mot], omega, c),
        rotor.section_angle(theta_0, omega, v_i, w_a, c),
        w_a / (c.hover_inflow * thrust / c.weight) if thrust > LEAST_THRUST * c.weight else 0.0,
    )
