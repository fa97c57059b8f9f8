"""Frequency responses that the design report draws, and what the source prints of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heli_control.controller_designs import Loop
from heli_control.margins import S_LIMIT_DB, T_LIMIT_DB, Response, loops
from heli_control.published import PUBLISHED
from heli_control.realisation import Array, Realisation, response

OMEGA: Array = np.asarray(np.geomspace(0.02, 500.0, 260), dtype=np.float64)
"""Where curves are drawn [rad/s]."""


@dataclass(frozen=True, eq=False)
class LoopResponses:
    """Frequency responses of one loop, scaled: shapes (k, p, m), (k, m, p), (k, m, m), (k, p, p)."""

    plant: Response
    controller: Response
    at_input: Response
    at_output: Response

    @classmethod
    def of(cls, loop: Loop) -> LoopResponses:
        """The responses at `OMEGA`."""
        plant, controller = response(loop.plant, OMEGA), response(loop.feedback, OMEGA)
        return cls(plant, controller, *loops(plant, controller))


def l_s_t(loop: Response) -> tuple[Response, Response, Response]:
    """L, S and T of a loop for negative feedback, shape (k, m, m) each."""
    identity = np.eye(loop.shape[1])
    sensitivity: Response = np.asarray(np.linalg.inv(identity + loop), dtype=np.complex128)
    return loop, sensitivity, np.asarray(identity - sensitivity, dtype=np.complex128)


def singular_values(values: Response) -> Array:
    """Of a stack of matrices, largest first, shape (k, min(p, m))."""
    return np.asarray(np.linalg.svd(values, compute_uv=False), dtype=np.float64)


def smallest_gain(weight: Realisation) -> Array:
    """Smallest singular value of a weight at `OMEGA`."""
    return singular_values(response(weight, OMEGA))[:, -1]


def limits(name: str) -> tuple[float, ...]:
    """Of spec 3.6 for S and T [dB]; none for L."""
    return {"S": (S_LIMIT_DB,), "T": (T_LIMIT_DB,)}.get(name, ())


def level_range(name: str) -> tuple[float, float]:
    """What is shown of L, S or T [dB]."""
    return (-60.0, 60.0) if name == "L" else (-50.0, 15.0)


def published_values(kind: str, axis: str, name: str) -> list[float]:
    """What the source prints of one figure: one value or none."""
    return [row.value for row in PUBLISHED if (row.kind, row.axis, row.name) == (kind, axis, name)]
