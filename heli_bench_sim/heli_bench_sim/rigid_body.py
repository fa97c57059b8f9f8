"""Rigid body on NED/FRD axes with yaw-pitch-roll angles (source eq. 2.1-2.3, 2.14, 2.18-2.20, app. A)."""

from __future__ import annotations

import math

from heli_bench_sim.parameters import Constants
from heli_common.compiled import equation

Vector = tuple[float, float, float]


@equation
def body_from_earth(x: float, y: float, z: float, psi: float, theta: float, phi: float) -> Vector:
    """Components in body axes (FRD) of a vector given in earth axes (NED); the angles in rad.

    Args:
        x: component north.
        y: component east.
        z: component down.
        psi: yaw [rad].
        theta: pitch [rad].
        phi: roll [rad].
    """
    sin_psi, cos_psi = math.sin(psi), math.cos(psi)
    sin_theta, cos_theta = math.sin(theta), math.cos(theta)
    sin_phi, cos_phi = math.sin(phi), math.cos(phi)
    ahead = cos_psi * x + sin_psi * y
    aside = cos_psi * y - sin_psi * x
    below = sin_theta * ahead + cos_theta * z
    return (
        cos_theta * ahead - sin_theta * z,
        cos_phi * aside + sin_phi * below,
        cos_phi * below - sin_phi * aside,
    )


@equation
def earth_from_body(x: float, y: float, z: float, psi: float, theta: float, phi: float) -> Vector:
    """Components in earth axes (NED) of a vector given in body axes (FRD); the angles in rad.

    Args:
        x: component forward.
        y: component right.
        z: component down.
        psi: yaw [rad].
        theta: pitch [rad].
        phi: roll [rad].
    """
    sin_psi, cos_psi = math.sin(psi), math.cos(psi)
    sin_theta, cos_theta = math.sin(theta), math.cos(theta)
    sin_phi, cos_phi = math.sin(phi), math.cos(phi)
    aside = cos_phi * y - sin_phi * z
    below = sin_phi * y + cos_phi * z
    ahead = cos_theta * x + sin_theta * below
    return (
        cos_psi * ahead - sin_psi * aside,
        sin_psi * ahead + cos_psi * aside,
        cos_theta * below - sin_theta * x,
    )


@equation
def euler_rates(p: float, q: float, r: float, theta: float, phi: float) -> Vector:
    """(psi', theta', phi') [rad/s] from the body rates (source eq. 2.2); singular at theta = +-90 deg.

    Args:
        p: roll rate of the body [rad/s].
        q: pitch rate [rad/s].
        r: yaw rate [rad/s].
        theta: pitch [rad].
        phi: roll [rad].
    """
    sin_phi, cos_phi = math.sin(phi), math.cos(phi)
    turning = sin_phi * q + cos_phi * r
    return turning / math.cos(theta), cos_phi * q - sin_phi * r, p + turning * math.tan(theta)


@equation
def body_moment(about_yaw: float, about_pitch: float, about_roll: float, theta: float, phi: float) -> Vector:
    """Body moment (L, M, N) [N m] of torques [N m] about the gimbal's yaw, pitch and roll axes.

    The transpose of the matrix in `euler_rates`, so that both give the same power.

    Args:
        about_yaw: torque about the yaw axis [N m].
        about_pitch: about the pitch axis [N m].
        about_roll: about the roll axis [N m].
        theta: pitch [rad].
        phi: roll [rad].
    """
    sin_phi, cos_phi = math.sin(phi), math.cos(phi)
    turning = about_yaw / math.cos(theta) + about_roll * math.tan(theta)
    return about_roll, cos_phi * about_pitch + sin_phi * turning, cos_phi * turning - sin_phi * about_pitch


@equation
def accelerations(
    force_x: float,
    force_y: float,
    force_z: float,
    u: float,
    v: float,
    w: float,
    p: float,
    q: float,
    r: float,
    c: Constants,
) -> Vector:
    """(u', v', w') [m/s^2] in the turning body frame from the whole force [N] (source eq. 2.14).

    Args:
        force_x: whole force forward [N].
        force_y: right [N].
        force_z: down [N].
        u: velocity forward [m/s].
        v: right [m/s].
        w: down [m/s].
        p: roll rate [rad/s].
        q: pitch rate [rad/s].
        r: yaw rate [rad/s].
        c: constants of the helicopter.
    """
    return (
        force_x / c.mass - w * q + v * r,
        force_y / c.mass - u * r + w * p,
        force_z / c.mass - v * p + u * q,
    )


@equation
def angular_accelerations(
    moment_x: float, moment_y: float, moment_z: float, p: float, q: float, r: float, c: Constants
) -> Vector:
    """(p', q', r') [rad/s^2] from the whole moment [N m] (source eq. 2.18-2.20, solved for p' and r').

    Args:
        moment_x: whole moment about the forward axis [N m].
        moment_y: about the right axis [N m].
        moment_z: about the downward axis [N m].
        p: roll rate [rad/s].
        q: pitch rate [rad/s].
        r: yaw rate [rad/s].
        c: constants of the helicopter.
    """
    rolling = moment_x + (c.inertia_yy - c.inertia_zz) * q * r + c.inertia_xz * p * q
    pitching = moment_y + (c.inertia_zz - c.inertia_xx) * p * r + c.inertia_xz * (r * r - p * p)
    yawing = moment_z + (c.inertia_xx - c.inertia_yy) * p * q - c.inertia_xz * q * r
    determinant = c.inertia_xx * c.inertia_zz - c.inertia_xz * c.inertia_xz
    return (
        (c.inertia_zz * rolling + c.inertia_xz * yawing) / determinant,
        pitching / c.inertia_yy,
        (c.inertia_xz * rolling + c.inertia_xx * yawing) / determinant,
    )
