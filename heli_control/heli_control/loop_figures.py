"""The figures by which the source describes a loop: cross-overs of every path, |S| and |T| (spec 3).

L_u = K G at the plant input: where its largest singular value last falls through 0 dB
paths: of one measured signal, G_i K_i, all others open; where its magnitude crosses 0 dB
S_u: where its largest singular value first rises through -3 dB, the bandwidth of the rejection
"""

from __future__ import annotations

import numpy as np

from heli_control.hinf_norm import largest_singular_values
from heli_control.loop_analysis import crossovers, sensitivity_peaks
from heli_control.realisation import Array, Complex, Realisation, response

FREQUENCIES: Array = np.asarray(np.geomspace(0.02, 500.0, 1500), dtype=np.float64)
"""Where loops are looked at [rad/s]."""


def loop_figures(plant: Realisation, controller: Realisation, outputs: tuple[str, ...]) -> dict[str, float]:
    """Figures of one loop by name; a path that never crosses 0 dB has none.

    Args:
        plant: G, m inputs and p outputs.
        controller: u = K y, the minus sign of the feedback included.
        outputs: p names.

    Returns:
        `|S_u|` and `|T_u|` in dB, `L_u`, `S_u`, the last cross-over of each path under its output's name
        [rad/s]; a path that is a band-pass also has `<name>, lower`.
    """
    omega = FREQUENCIES
    g, k = response(plant, omega), -response(controller, omega)
    loop = k @ g
    sensitivity: Complex = np.asarray(np.linalg.inv(np.eye(loop.shape[1]) + loop), dtype=np.complex128)
    peak_s, peak_t = sensitivity_peaks(loop)
    figures = {"|S_u|": peak_s, "|T_u|": peak_t}
    crossing = crossovers(largest_singular_values(loop), omega)
    if crossing:
        figures["L_u"] = crossing[-1]
    rejected = largest_singular_values(sensitivity) / np.sqrt(0.5)
    if rejected[0] < 1.0 < rejected.max():
        figures["S_u"] = crossovers(rejected, omega)[0]
    for index, name in enumerate(outputs):
        path = np.abs(np.einsum("ki,ki->k", g[:, index, :], k[:, :, index]))
        crossing = crossovers(path, omega)
        if crossing:
            figures[name] = crossing[-1]
        if len(crossing) > 1:
            figures[f"{name}, lower"] = crossing[0]
    return figures
