"""The arms' own inertia, which changes with the platform's position; off by default (spec 2.1, D).

Three upper arms are uniform rods that turn about their base pivots. Each forearm pair is two parallel uniform
rods with the same motion, one end at the elbow, the other at the platform, which never rotates. For a rod
whose ends move with v1 and v2 the kinetic energy is m / 6 (v1.v1 + v1.v2 + v2.v2). One arm has

    f   forearm, elbow to platform joint        s   slope of the elbow with the arm angle alpha, |s| = l
    J = f / (f.s)                               alpha' = J.v, elbow velocity s alpha', platform velocity v
    2 T = (m_u + m_f) l^2 / 3 alpha'^2 + m_f / 3 (alpha' s.v + v.v)

with l the length and m_u the mass of the upper arm, m_f that of the forearm pair. So 2 T = v.M v with

    M = (m_u + m_f) l^2 / 3 J J^T + m_f / 6 (s J^T + J s^T) + m_f / 3

and Lagrange's equation in the platform's position gives the inertial force M a + h. The part h without the
acceleration comes from alpha'' = J.a + k, with f' = v - s alpha' the rate of the forearm and n the slope of
s with alpha:

    k = (f'.f' - f.n alpha'^2) / (f.s)
    h = (m_u + m_f) l^2 / 3 k J + m_f / 6 (k s + alpha'^2 n)

The arms act on the platform with -(M a + h). Their weight is left out: it is part of the 7.3 kg of helicopter
and frame, and so is a constant share of their inertia, to which the switch adds M.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.delta_arm import ARMS, ArmConstants
from heli_common.compiled import compiled
from heli_common.quantities import quantity
from heli_common.rig_geometry import ARM_AZIMUTH

Array = NDArray[np.float64]

ARM_NORTH = tuple(math.cos(azimuth) for azimuth in ARM_AZIMUTH)
"""North part of each arm's outward direction."""

ARM_EAST = tuple(math.sin(azimuth) for azimuth in ARM_AZIMUTH)
"""East part of it."""

STRETCHED = 1e-9
"""Lever of the elbow about the forearm [m] below which an arm counts as stretched."""


@dataclass(frozen=True)
class ArmInertiaParameters:
    """Masses of the arms, uniform tubes, and whether they count."""

    active: float = quantity(0.0, "-", "D", "switch: arms have inertia of their own, 0 no, 1 yes", 0.0, 1.0)
    upper_arm_mass: float = quantity(0.35, "kg", "D", "m_u: each upper arm", 0.0, 10.0)
    forearm_mass: float = quantity(0.25, "kg", "D", "m_f: each pair of forearms", 0.0, 10.0)


class ArmInertiaConstants(NamedTuple):
    """What the compiled inertia needs; every field a float; all zero when switched off."""

    swing_mass: float
    """(m_u + m_f) / 3 [kg]"""
    forearm_mass: float


def arm_inertia_constants(parameters: ArmInertiaParameters) -> ArmInertiaConstants:
    """Constants of the compiled inertia.

    Args:
        parameters: of the arms.

    Raises:
        ValueError: the switch is neither 0 nor 1.
    """
    if parameters.active not in (0.0, 1.0):
        raise ValueError(f"active {parameters.active!r} is no switch (allowed: 0, 1)")
    if parameters.active == 0.0:
        return ArmInertiaConstants(0.0, 0.0)
    both = parameters.upper_arm_mass + parameters.forearm_mass
    return ArmInertiaConstants(swing_mass=both / 3.0, forearm_mass=parameters.forearm_mass)


@compiled
def arm_mass_matrix(
    x: float,
    y: float,
    z: float,
    vx: float,
    vy: float,
    vz: float,
    geometry: ArmConstants,
    c: ArmInertiaConstants,
    out_mass: Array,
    out_force: Array,
) -> bool:
    """Write the arms' mass matrix M and the force h, NED; the arms act on the platform with -(M a + h).

    Args:
        x: platform north of the flight-space centre [m].
        y: east [m].
        z: down [m].
        vx: velocity of the platform north [m/s].
        vy: east [m/s].
        vz: down [m/s].
        geometry: of the arms.
        c: constants of the inertia.
        out_mass: (9,) receives M row by row [kg].
        out_force: (3,) receives h [N].

    Returns:
        False, with M and h zero, if the arms cannot reach this position or one of them is stretched there.
    """
    for part in range(9):
        out_mass[part] = 0.0
    for part in range(3):
        out_force[part] = 0.0
    if c.swing_mass == 0.0 and c.forearm_mass == 0.0:
        return True
    length, height = geometry.upper_arm, geometry.centre_height - z
    swing, cross = c.swing_mass * length * length, c.forearm_mass / 6.0
    xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    force_x, force_y, force_z = 0.0, 0.0, 0.0
    reached = True
    for arm in range(ARMS):
        north, east = ARM_NORTH[arm], ARM_EAST[arm]
        # in the arm's own plane: outward, aside, up; the base pivot is the origin
        out = x * north + y * east - geometry.inward
        aside = y * north - x * east
        v_out, v_aside, v_up = vx * north + vy * east, vy * north - vx * east, -vz
        reach = out * out + height * height
        # law of cosines: how far the platform joint lies along the upper arm, and how far off its line
        along = 0.5 * (reach + aside * aside + length * length - geometry.forearm * geometry.forearm) / length
        off = reach - along * along
        if not off > STRETCHED * STRETCHED:
            reached = False
            break
        off = math.sqrt(off)
        cosine = (out * along + height * off) / reach
        sine = (height * along - out * off) / reach
        f_out, f_up = out - length * cosine, height - length * sine
        s_out, s_up = -length * sine, length * cosine
        lever = length * off  # f.s
        j_out, j_aside, j_up = f_out / lever, aside / lever, f_up / lever
        turning = j_out * v_out + j_aside * v_aside + j_up * v_up
        r_out, r_up = v_out - s_out * turning, v_up - s_up * turning
        # the slope n of s with the arm angle is (-s_up, 0, s_out)
        bent = (s_out * f_up - s_up * f_out) * turning * turning
        k = (r_out * r_out + v_aside * v_aside + r_up * r_up - bent) / lever

        j_x, j_y, j_z = j_out * north - j_aside * east, j_out * east + j_aside * north, -j_up
        s_x, s_y, s_z = s_out * north, s_out * east, -s_up
        xx += swing * j_x * j_x + 2.0 * cross * s_x * j_x
        xy += swing * j_x * j_y + cross * (s_x * j_y + s_y * j_x)
        xz += swing * j_x * j_z + cross * (s_x * j_z + s_z * j_x)
        yy += swing * j_y * j_y + 2.0 * cross * s_y * j_y
        yz += swing * j_y * j_z + cross * (s_y * j_z + s_z * j_y)
        zz += swing * j_z * j_z + 2.0 * cross * s_z * j_z
        square = turning * turning
        level = cross * (k * s_out - square * s_up)
        force_x += swing * k * j_x + level * north
        force_y += swing * k * j_y + level * east
        force_z += swing * k * j_z - cross * (k * s_up + square * s_out)
    if not reached:
        return False
    joint = ARMS * 2.0 * cross
    out_mass[0], out_mass[1], out_mass[2] = xx + joint, xy, xz
    out_mass[3], out_mass[4], out_mass[5] = xy, yy + joint, yz
    out_mass[6], out_mass[7], out_mass[8] = xz, yz, zz + joint
    out_force[0], out_force[1], out_force[2] = force_x, force_y, force_z
    return True


@compiled
def solve_three(matrix: Array, right: Array, out: Array) -> bool:
    """Solve a symmetric positive definite 3x3 system by its factors L D L^T; only the lower half is read.

    Args:
        matrix: (9,) row by row.
        right: (3,) right-hand side; may be `out` itself.
        out: (3,) receives the solution.

    Returns:
        False, and `out` untouched, if the matrix is not positive definite.
    """
    first = matrix[0]
    if not first > 0.0:
        return False
    l_10, l_20 = matrix[3] / first, matrix[6] / first
    second = matrix[4] - l_10 * matrix[3]
    if not second > 0.0:
        return False
    mixed = matrix[7] - l_20 * matrix[3]
    l_21 = mixed / second
    third = matrix[8] - l_20 * matrix[6] - l_21 * mixed
    if not third > 0.0:
        return False
    y_0 = right[0]
    y_1 = right[1] - l_10 * y_0
    y_2 = right[2] - l_20 * y_0 - l_21 * y_1
    z = y_2 / third
    y = y_1 / second - l_21 * z
    out[0], out[1], out[2] = y_0 / first - l_10 * y - l_20 * z, y, z
    return True
