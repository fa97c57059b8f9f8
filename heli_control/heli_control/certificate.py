"""The certificate of a closed loop: what a controller makes of a plant, recomputed (spec 3.6).

The closed loop is put together again from the plant as given and the controller:

    its poles                              all must decay
    its norm, from above                   Hamiltonian method, on the joined state space
    its norm, from below                   on a frequency grid, from the responses of P and K alone
    the poles of the controller            none faster than the sampling rate bears
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_control.generalized_plant import (
    GeneralizedPlant,
    closed_response,
    lower_lft,
    with_balanced_states,
)
from heli_control.hinf_norm import hinf_norm, largest_singular_values, natural_frequencies
from heli_control.pole_region import fastest
from heli_control.realisation import Realisation, balanced

AGREEMENT = 1e-3
"""Relative: how far a norm may be above its gamma, and two routes apart (spec 3.6)."""

Poles = NDArray[np.complex128]


class Certificate(NamedTuple):
    """What the closed loop of a plant and a controller is, recomputed.

    Attributes:
        norm: upper bound by the Hamiltonian method; infinite if unstable.
        grid_norm: lower bound from the frequency responses.
        frequency: of the peak [rad/s].
        poles: of the closed loop, slowest to decay first.
        fastest_pole: of the controller, absolute value [rad/s].
        fault: why it is no certificate, or empty.
    """

    norm: float
    grid_norm: float
    frequency: float
    poles: Poles
    fastest_pole: float
    fault: str


def certify(
    plant: GeneralizedPlant, controller: Realisation, gamma: float, fastest_pole: float = math.inf
) -> Certificate:
    """Recompute what a controller makes of a plant; believes nothing of the route it came from.

    Args:
        plant: the plant as given, not a scaled one.
        controller: u = K y.
        gamma: norm claimed.
        fastest_pole: allowed of the controller [rad/s].
    """
    nothing = np.zeros(0, dtype=np.complex128)
    quick = fastest(controller)
    try:
        loop = lower_lft(plant, controller)
    except ValueError as error:
        return Certificate(math.inf, math.inf, math.nan, nothing, quick, str(error))
    poles = np.linalg.eigvals(balanced(loop)[0].A).astype(np.complex128)
    poles = poles[np.argsort(-poles.real, kind="stable")]
    norm = hinf_norm(loop)
    if norm.unstable_pole is not None:
        fault = f"the closed loop is not stable beyond rounding: pole {norm.unstable_pole:.6g} rad/s"
        return Certificate(math.inf, math.inf, norm.frequency, poles, quick, fault)
    level = _grid_level(plant, controller, loop, norm.frequency)
    fault = ""
    if quick > fastest_pole:
        fault = f"a controller pole of {quick:.6g} rad/s is faster than {fastest_pole:.6g} rad/s"
    if not max(norm.value, level) <= (1.0 + AGREEMENT) * gamma:
        fault = f"the closed loop's norm is {max(norm.value, level):.6g}, not {gamma:.6g}"
    elif not norm.lower * (1.0 - AGREEMENT) <= level <= (1.0 + AGREEMENT) * norm.value:
        fault = f"the norm is {norm.value:.6g} by the Hamiltonian, {level:.6g} by frequency response"
    return Certificate(norm.value, level, norm.frequency, poles, quick, fault)


def _grid_level(plant: GeneralizedPlant, controller: Realisation, loop: Realisation, peak: float) -> float:
    """Largest singular value over a grid and the peak, from the responses of plant and controller."""
    inner, whole = balanced(controller)[0], with_balanced_states(plant)
    omega = natural_frequencies(balanced(loop)[0])
    omega = np.append(omega[(omega > 0.0) | np.isinf(omega)], peak if peak > 0.0 else 1e-6 * omega[1])
    # on a pole of P or K the closed loop is finite though neither response is
    for poles in (np.linalg.eigvals(whole.A), np.linalg.eigvals(inner.A)):
        on_axis = np.abs(poles.imag[np.abs(poles.real) < 1e-9 * np.abs(poles).max(initial=0.0)])
        for frequency in on_axis:
            omega = np.where(np.abs(omega - frequency) < 1e-6 * frequency, omega * (1.0 + 1e-5), omega)
    return float(largest_singular_values(closed_response(whole, inner, omega)).max())
