"""Generalised plants of mixed sensitivity design: S/KS/T, GS/T with one and two degrees of freedom (3.3).

G is the scaled plant from the command u to the measurements y, e = r - y the error the controller gets.

    S/KS/T (eq. 3.23, Figure 3.14)    w = r                    z = (W_e e, W_u u, W_y y)
    GS/T (eq. 3.25, Figure 3.15)      w = (w_v, w_d)           z = (W_u u, W_y y)
    GS/T 2DOF (eq. 3.26, Figure 3.16) w = (w_r, w_v, w_d)      z = (W_u u, W_y y, W_e (r - y_r))

In GS/T the plant takes u + W_v w_v and the error is e = -(y + W_d w_d). With two degrees of freedom the
reference r = W_r w_r of the outputs y_r is measured, too, and the controller is u = K_r r + K_y e.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from heli_control.generalized_plant import GeneralizedPlant, from_whole
from heli_control.realisation import Array, Realisation, diagonal, gain, series


def s_ks_t(plant: Realisation, w_e: Realisation, w_u: Realisation, w_y: Realisation) -> GeneralizedPlant:
    """S/KS/T: [W_e S_e; W_u K S_e; W_y T_e] of u = K e (eq. 3.23).

    Args:
        plant: G with m inputs and p outputs.
        w_e, w_y: on error and output, p inputs and outputs. w_u: on the command, m.

    Raises:
        ValueError: a weight whose size does not fit.
    """
    p, m = plant.D.shape
    _check(("W_e", w_e, p), ("W_u", w_u, m), ("W_y", w_y, p))
    identity, nothing = np.eye(p), np.zeros((m, p))
    # (r, u) -> (e, u, y, e) from (r, u, y)
    mixed = np.block(
        [
            [identity, np.zeros((p, m)), -identity],
            [nothing, np.eye(m), np.zeros((m, p))],
            [np.zeros((p, p)), np.zeros((p, m)), identity],
            [identity, np.zeros((p, m)), -identity],
        ]
    )
    into_plant = np.hstack((nothing, np.eye(m)))
    return _assembled(plant, into_plant, mixed, (w_e, w_u, w_y), (), m, p)


def gs_t(
    plant: Realisation, w_u: Realisation, w_y: Realisation, w_v: Realisation, w_d: Realisation
) -> GeneralizedPlant:
    """GS/T: [-W_u T_u W_v, -W_u K S_e W_d; W_y G S_u W_v, -W_y T_e W_d] of u = K e (eq. 3.25).

    Args:
        plant: G with m inputs and p outputs.
        w_u: on the command, m. w_y: on the output, p.
        w_v: on the disturbance of the command, m. w_d: on that of the output, p.

    Raises:
        ValueError: a weight whose size does not fit.
    """
    p, m = plant.D.shape
    _check(("W_u", w_u, m), ("W_y", w_y, p), ("W_v", w_v, m), ("W_d", w_d, p))
    # signals (v, d, u), then y
    mixed = np.block(
        [
            [np.zeros((m, m)), np.zeros((m, p)), np.eye(m), np.zeros((m, p))],
            [np.zeros((p, m)), np.zeros((p, p)), np.zeros((p, m)), np.eye(p)],
            [np.zeros((p, m)), -np.eye(p), np.zeros((p, m)), -np.eye(p)],
        ]
    )
    into_plant = np.hstack((np.eye(m), np.zeros((m, p)), np.eye(m)))
    return _assembled(plant, into_plant, mixed, (w_u, w_y), (w_v, w_d), m, p)


def gs_t_two_degree(
    plant: Realisation,
    w_u: Realisation,
    w_y: Realisation,
    w_v: Realisation,
    w_d: Realisation,
    w_e: Realisation,
    w_r: Realisation,
    followed: Sequence[int],
) -> GeneralizedPlant:
    """GS/T with a feed-forward path for the outputs that have a reference (eq. 3.26).

    Args:
        plant: G with m inputs and p outputs.
        w_u, w_y, w_v, w_d: see `gs_t`.
        w_e: on the distance of the q followed outputs from their references, q.
        w_r: on the references, q.
        followed: indices of the q outputs.

    Returns:
        measurements are the references, then e.

    Raises:
        ValueError: a weight whose size does not fit.
    """
    p, m = plant.D.shape
    q = len(followed)
    _check(
        ("W_u", w_u, m), ("W_y", w_y, p), ("W_v", w_v, m), ("W_d", w_d, p), ("W_e", w_e, q), ("W_r", w_r, q)
    )
    chosen = np.eye(p)[list(followed)]

    def row(size: int, **blocks: Array) -> Array:
        widths = {"r": q, "v": m, "d": p, "u": m, "y": p}
        return np.hstack([blocks.get(name, np.zeros((size, width))) for name, width in widths.items()])

    mixed = np.vstack(
        (
            row(m, u=np.eye(m)),
            row(p, y=np.eye(p)),
            row(q, r=np.eye(q), y=-chosen),
            row(q, r=np.eye(q)),
            row(p, d=-np.eye(p), y=-np.eye(p)),
        )
    )
    into_plant = np.hstack((np.zeros((m, q)), np.eye(m), np.zeros((m, p)), np.eye(m)))
    return _assembled(plant, into_plant, mixed, (w_u, w_y, w_e), (w_r, w_v, w_d), m, q + p)


def _assembled(
    plant: Realisation,
    into_plant: Array,
    mixed: Array,
    on_errors: tuple[Realisation, ...],
    on_disturbances: tuple[Realisation, ...],
    controls: int,
    measurements: int,
) -> GeneralizedPlant:
    """Weights around a static network: `mixed` takes (disturbances, u, y) to (errors, measurements)."""
    signals = into_plant.shape[1]
    through = series(
        Realisation(
            plant.A,
            plant.B @ into_plant,
            np.vstack((np.zeros((signals, plant.order)), plant.C)),
            np.vstack((np.eye(signals), plant.D @ into_plant)),
        ),
        diagonal(*on_disturbances, gain(np.eye(signals - sum(len(w.D) for w in on_disturbances)))),
    )
    outside = diagonal(*on_errors, gain(np.eye(measurements)))
    whole = series(outside, series(gain(mixed), through))
    names = tuple(f"u_{index + 1}" for index in range(controls))
    return from_whole(whole, names, tuple(f"y_{index + 1}" for index in range(measurements)))


def _check(*weights: tuple[str, Realisation, int]) -> None:
    for name, weight, size in weights:
        if weight.D.shape != (size, size):
            raise ValueError(f"{name} of {weight.D.shape}; allowed: {(size, size)}")
