"""Drag of fuselage and frame in the wind (spec 2.1)."""

from __future__ import annotations

import math

from heli_bench_sim.parameters import Constants
from heli_common.compiled import equation


@equation
def drag(u_a: float, v_a: float, w_a: float, c: Constants) -> tuple[float, float, float]:
    """Drag force in body axes [N], against the motion through the air at the centre of gravity.

    Quadratic in the speed: at hover in still air it changes neither trim nor linear model.

    Args:
        u_a: velocity forward relative to the air, body frame [m/s].
        v_a: velocity right relative to the air [m/s].
        w_a: velocity down relative to the air [m/s].
        c: constants of the helicopter.
    """
    factor = -0.5 * c.air_density * c.drag_area * math.sqrt(u_a * u_a + v_a * v_a + w_a * w_a)
    return factor * u_a, factor * v_a, factor * w_a
