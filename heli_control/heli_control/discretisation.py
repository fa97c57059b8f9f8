"""A continuous controller at 100 Hz, and the phase that sampling and actuators take from its loop (spec 3.6).

Tustin's rule maps s to 2/T (z - 1)/(z + 1): no hold is built in, the frequency axis is bent. The hold
equivalent is exact for an input that stays constant between samples; it has half a period of delay built in,
which an input that changes does not have. Which is nearer is measured, not assumed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.signal import cont2discrete

from heli_common.linear_model import StateSpace
from heli_common.timing import CONTROL_PERIOD
from heli_control.hinf_norm import largest_singular_values
from heli_control.realisation import Array, Complex, Realisation, realisation, response, unnamed

TUSTIN, HOLD = "tustin", "hold"
METHODS = {TUSTIN: "bilinear", HOLD: "zoh"}
"""Names here and in scipy."""

HIGHEST_FREQUENCY = 25.0
"""Up to where the responses are compared [rad/s]: twice the highest cross-over that spec 3 asks for."""

PULSE_PERIOD = 0.020
COMPUTING_LATENCY = 0.005
SERVO_BANDWIDTH = 2.0 * math.pi * 25.0
SERVO_DAMPING = 0.7
"""Pulse frame [s], latency [s], natural frequency [rad/s] and damping of the servo (spec 2.5, 6.4)."""


class Discretised(NamedTuple):
    """A controller made for sampled flight.

    Attributes:
        system: x+ = A x + B u; names of inputs and outputs as before, states of the same number.
        method: `tustin` or `hold`, whichever is nearer.
        errors: of each method, see `response_error`; infinite where it does not exist.
    """

    system: StateSpace
    method: str
    errors: dict[str, float]


def discrete(system: Realisation, method: str, period: float = CONTROL_PERIOD) -> Realisation:
    """The matrices of the difference equation.

    Args:
        system: continuous.
        method: `tustin` or `hold`.
        period: sample time [s].

    Raises:
        ValueError: another method, a period that is not positive, or Tustin with a pole at 2/T.
    """
    if method not in METHODS:
        raise ValueError(f"method {method!r}; allowed: {', '.join(METHODS)}")
    if not period > 0.0:
        raise ValueError(f"period {period} s; allowed: above 0")
    if not system.order:
        return system
    if method == TUSTIN:
        pencil = np.eye(system.order) - 0.5 * period * system.A
        if np.linalg.cond(pencil) > 1e12:
            raise ValueError(f"a pole at 2/T = {2.0 / period:g} rad/s; allowed with Tustin: none there")
    a, b, c, d, _ = cont2discrete(tuple(system), period, method=METHODS[method])
    return realisation(a, b, c, d)


def discrete_anti_windup(a: Array, e: Array, method: str, period: float = CONTROL_PERIOD) -> Array:
    """E of x+ = A_d x + B_d in + E_d (applied - asked) from x' = A x + B in + E (applied - asked).

    The difference is known only after the output of its sample, so it acts on the next one, held until then.

    Args:
        a: of the continuous controller, shape (n, n).
        e: shape (n, p).
        method: that the controller is discretised by.
        period: sample time [s].

    Raises:
        ValueError: as `discrete`.
    """
    n, p = e.shape
    return discrete(Realisation(a, e, np.zeros((p, n)), np.zeros((p, p))), method, period).B


def sampled_response(system: Realisation, omega: Array, period: float = CONTROL_PERIOD) -> Complex:
    """Transfer matrix of a difference equation on the unit circle, shape (k, p, m).

    Args:
        system: sampled.
        omega: frequencies [rad/s], shape (k,).
        period: sample time [s].
    """
    z = np.exp(1j * np.asarray(omega) * period)
    pencil = z[:, None, None] * np.eye(system.order) - system.A
    wide = np.broadcast_to(system.B, (len(z), *system.B.shape)).astype(np.complex128)
    return np.asarray(system.C @ np.linalg.solve(pencil, wide) + system.D, dtype=np.complex128)


def response_error(
    continuous: Realisation,
    sampled: Realisation,
    period: float = CONTROL_PERIOD,
    highest: float = HIGHEST_FREQUENCY,
) -> float:
    """Largest |K_d(e^jwT) - K(jw)| over |K(jw)|, in largest singular values, from highest/1000 to highest.

    Args:
        continuous: K.
        sampled: K_d, of the same inputs and outputs.
        period: sample time [s].
        highest: frequency [rad/s], at most that of Nyquist.
    """
    omega: Array = np.asarray(np.geomspace(1e-3 * highest, highest, 200), dtype=np.float64)
    exact = response(continuous, omega)
    difference = largest_singular_values(sampled_response(sampled, omega, period) - exact)
    size = largest_singular_values(exact)
    return float((difference / np.maximum(size, np.finfo(float).tiny)).max())


def discretised(
    system: StateSpace, period: float = CONTROL_PERIOD, highest: float = HIGHEST_FREQUENCY
) -> Discretised:
    """The method whose frequency response is nearer to the continuous controller's.

    Args:
        system: continuous controller with names.
        period: sample time [s].
        highest: up to where the responses are compared [rad/s].

    Raises:
        ValueError: a period that is not positive.
    """
    given = unnamed(system)
    made: dict[str, Realisation] = {}
    errors = dict.fromkeys(METHODS, math.inf)
    for method in METHODS:
        try:
            made[method] = discrete(given, method, period)
        except ValueError:
            if method == HOLD:
                raise
            continue
        errors[method] = response_error(given, made[method], period, highest)
    best = min(made, key=lambda method: errors[method])
    return Discretised(StateSpace(system.states, system.inputs, system.outputs, *made[best]), best, errors)


def phase_losses(
    omega: float,
    *,
    period: float = CONTROL_PERIOD,
    latency: float = COMPUTING_LATENCY,
    pulse_period: float = PULSE_PERIOD,
    servo_bandwidth: float = SERVO_BANDWIDTH,
    servo_damping: float = SERVO_DAMPING,
) -> dict[str, float]:
    """Phase that each part between sample and blade takes at a frequency [deg], positive.

    A hold of T delays by T/2 in the mean. The pulse frames hold the command longer than the controller does;
    `frame` is what they add to `sample`, so that all rows together are the loss of the loop.

    Args:
        omega: frequency [rad/s].
        period: of the controller [s].
        latency: from sample to command [s].
        pulse_period: of the servo pulses [s], at least `period`.
        servo_bandwidth: natural frequency [rad/s].
        servo_damping: damping ratio.

    Returns:
        rows `sample`, `latency`, `frame`, `servo` and their sum `all`.
    """
    rows = {
        "sample": math.degrees(omega * 0.5 * period),
        "latency": math.degrees(omega * latency),
        "frame": math.degrees(omega * 0.5 * (pulse_period - period)),
        "servo": math.degrees(
            math.atan2(2.0 * servo_damping * omega * servo_bandwidth, servo_bandwidth**2 - omega**2)
        ),
    }
    return rows | {"all": sum(rows.values())}
