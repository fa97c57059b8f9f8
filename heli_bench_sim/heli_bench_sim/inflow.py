"""Induced velocity of both rotors: first-order lag towards momentum theory (source eq. 2.22-2.27).

Hover and climb use the source's linear law, V_i = V_i0 T / (m g). Descending through its own wake a rotor
leaves that law. From half the induced velocity on, the steady value goes over to momentum theory with
vertical speed (source eq. 2.24: the flow is augmented), and towards twice the induced velocity to the
windmill branch (eq. 2.25). The blend in between is a design choice: momentum theory itself has no solution
for the vortex ring, so these states are flagged, not trusted.
"""

from __future__ import annotations

import math

from heli_bench_sim.parameters import Constants
from heli_common.compiled import equation

VORTEX_RING_START = 0.5
"""Descent speed over induced velocity at which the wake begins to come back (D)."""

VORTEX_RING_FULL = 1.0
"""Ratio from which the augmented flow of source eq. 2.24 holds alone (D)."""

WINDMILL = 2.0
"""Ratio from which all air passes the disc upwards (source eq. 2.25)."""

FASTEST_DESCENT = 1000.0
"""Ratio beyond which the wake of a rotor without thrust changes no more."""

BRANCH_ROUNDING = 0.05
"""Takes the vertical tangent from the square root where the windmill branch begins (D)."""


@equation
def smooth_step(value: float, start: float, end: float) -> float:
    """0 below start, 1 above end, a cubic with level ends in between.

    Args:
        value: any number.
        start: where it leaves 0.
        end: where it reaches 1, above start.
    """
    share = min(max((value - start) / (end - start), 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


@equation
def steady_inflow(thrust: float, w_a: float, c: Constants) -> float:
    """Steady induced velocity of the main rotor [m/s].

    Args:
        thrust: main rotor thrust [N].
        w_a: velocity down relative to the air, body frame [m/s].
        c: constants of the helicopter.
    """
    hover = c.hover_inflow * thrust / c.weight
    if hover <= 0.0 or w_a <= VORTEX_RING_START * hover:
        return hover
    ratio = min(w_a / hover, FASTEST_DESCENT)
    half = 0.5 * ratio
    augmented = half + math.sqrt(half * half + 1.0)
    beyond = max(half * half - 1.0, 0.0)
    windmill = half - beyond / math.sqrt(beyond + BRANCH_ROUNDING * BRANCH_ROUNDING)
    to_ring = smooth_step(ratio, VORTEX_RING_START, VORTEX_RING_FULL)
    to_windmill = smooth_step(ratio, VORTEX_RING_FULL, WINDMILL)
    ring = (1.0 - to_ring) + to_ring * augmented
    return hover * ((1.0 - to_windmill) * ring + to_windmill * windmill)


@equation
def rate(v_i: float, thrust: float, w_a: float, c: Constants) -> float:
    """V_i' of the main rotor [m/s^2] (source eq. 2.23).

    Args:
        v_i: induced velocity [m/s].
        thrust: main rotor thrust [N].
        w_a: velocity down relative to the air, body frame [m/s].
        c: constants of the helicopter.
    """
    return (steady_inflow(thrust, w_a, c) - v_i) / c.inflow_time


@equation
def tail_rate(v_t: float, thrust: float, c: Constants) -> float:
    """V_t' of the tail rotor [m/s^2] (source eq. 2.27).

    Args:
        v_t: induced velocity of the tail rotor [m/s].
        thrust: tail thrust [N].
        c: constants of the helicopter.
    """
    return (c.tail_hover_inflow * thrust / c.tail_thrust - v_t) / c.tail_inflow_time
