"""What is reported of an LQ design: gains beside source Table 3.1, poles, sensitivity peaks, cross-overs."""

from __future__ import annotations

from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heli_common.linear_model import StateSpace
from heli_common.timing import CONTROL_PERIOD
from heli_control.loop_analysis import crossovers, frequency_response, sensitivity_peaks
from heli_control.lq_axis import AxisDesign, controller_block
from heli_control.published_gains import LQ_GAINS
from heli_control.state_space import delayed_zero_order_hold

Array = NDArray[np.float64]

MAIN_COMMAND = {
    "theta": "B_1s", "u": "B_1s", "q": "B_1s", "phi": "A_1s", "v": "A_1s", "p": "A_1s",
    "w": "theta_0", "r": "theta_t",
}  # fmt: skip
"""The command whose loop through a state has a cross-over."""


def in_printed_units(
    gain: Array, states: tuple[str, ...], inputs: tuple[str, ...]
) -> dict[str, dict[str, float]]:
    """Gains for u = -K x as source Table 3.1 prints them: deg per deg, per deg/s, and per m/s."""
    return {
        command: {
            state: degrees(gain[row, column]) if state in ("u", "v", "w") else float(gain[row, column])
            for column, state in enumerate(states)
        }
        for row, command in enumerate(inputs)
    }


def figures(plant: StateSpace, design: AxisDesign, delay: float) -> dict[str, Any]:
    """What the design report shows of one axis; loops are closed around the model with all its states."""
    omega: Array = np.asarray(np.geomspace(0.05, 0.99 * np.pi / CONTROL_PERIOD, 800), dtype=np.float64)
    n, m = len(design.states), len(design.inputs)
    columns = [plant.inputs.index(name) for name in design.inputs]
    order = len(plant.states)
    seen = np.zeros((n, order))
    seen[range(n), [plant.states.index(name) for name in design.states]] = 1.0
    full = StateSpace(
        plant.states, design.inputs, design.states, plant.A, plant.B[:, columns], seen, np.zeros((n, m))
    )
    response = frequency_response(full, omega)
    late_a, late_b = delayed_zero_order_hold(full.A, full.B, CONTROL_PERIOD, delay)
    names = plant.states + tuple(f"late_{index}" for index in range(len(late_a) - order))
    late_c = np.hstack((seen, np.zeros((n, len(late_a) - order))))
    late = StateSpace(names, design.inputs, design.states, late_a, late_b, late_c, full.D)
    controller = frequency_response(controller_block(design).system, omega, CONTROL_PERIOD)[:, :, :n]
    peaks = sensitivity_peaks(design.continuous @ response)
    late_peaks = sensitivity_peaks(np.matmul(-controller, frequency_response(late, omega, CONTROL_PERIOD)))
    main = [design.inputs.index(MAIN_COMMAND[state]) for state in design.states]
    return {
        "gains": in_printed_units(design.continuous, design.states, design.inputs),
        "gains_published": {command: LQ_GAINS[command] for command in design.inputs},
        "gains_discrete": in_printed_units(design.discrete, design.states, design.inputs),
        "gains_past_commands": design.past.tolist(),
        "poles": _pairs(design.poles),
        "poles_discrete_z": _pairs(design.discrete_poles),
        "peaks_db": {"S_u": peaks[0], "T_u": peaks[1]},
        "peaks_discrete_db": {"S_u": late_peaks[0], "T_u": late_peaks[1]},
        "crossover_rad_s": {
            state: crossovers(design.continuous[row, column] * response[:, column, row], omega)
            for column, (state, row) in enumerate(zip(design.states, main, strict=True))
        },
    }


def _pairs(poles: NDArray[np.complex128]) -> list[list[float]]:
    return [[float(pole.real), float(pole.imag)] for pole in poles]
