"""Linear quadratic attitude and velocity controller of the helicopter (source sec. 3.2.3, spec 3.3).

Horizontal motion: theta phi u v q p with B_1s A_1s. Vertical motion and yaw: w r with theta_0 theta_t. The
regulator itself is in `lq_axis`; here are the weights and how both axes become a controller file.
"""

from __future__ import annotations

import platform
from dataclasses import asdict, dataclass
from importlib.metadata import version

import numpy as np

from heli_common.model_file import ModelFile
from heli_common.quantities import quantity
from heli_control.controller_file import ControllerFile
from heli_control.lq_axis import AxisDesign, controller_block, design_axis
from heli_control.lq_figures import figures

HORIZONTAL_STATES = ("theta", "phi", "u", "v", "q", "p")
VERTICAL_STATES = ("w", "r")
HORIZONTAL_INPUTS = ("B_1s", "A_1s")
VERTICAL_INPUTS = ("theta_0", "theta_t")


@dataclass(frozen=True)
class LqWeights:
    """Diagonals of Q and R on the scaled plant, and the delay designed for.

    The source's own Q is not printed. That of the horizontal motion and rho are fitted so that the main
    gains of the continuous design on the linearised bench are those of source Table 3.1, that of the
    vertical motion so that w and r cross over at 3 and 12 rad/s.
    """

    theta: float = quantity(106.0, "-", "R", "weight of the pitch angle", 0.0, 1e6)
    phi: float = quantity(19.8, "-", "R", "weight of the roll angle", 0.0, 1e6)
    u: float = quantity(1.90, "-", "R", "weight of the forward velocity", 0.0, 1e6)
    v: float = quantity(0.80, "-", "R", "weight of the lateral velocity", 0.0, 1e6)
    q: float = quantity(6.68, "-", "R", "weight of the pitch rate", 0.0, 1e6)
    p: float = quantity(8.63, "-", "R", "weight of the roll rate", 0.0, 1e6)
    w: float = quantity(0.24, "-", "R", "weight of the vertical velocity", 0.0, 1e6)
    r: float = quantity(0.145, "-", "R", "weight of the yaw rate", 0.0, 1e6)
    effort: float = quantity(0.55, "-", "T", "weight of B_1s, theta_0 and theta_t (eq. 3.12)", 1e-6, 1e6)
    rho: float = quantity(0.523, "-", "R", "weight of A_1s against that of B_1s", 1e-3, 1e3)
    command_delay: float = quantity(
        0.020,
        "s",
        "D",
        "from sample to effect: 5 ms latency, 10 ms half a frame, part of the servo",
        0.0,
        0.1,
    )


def axis_designs(model: ModelFile, weights: LqWeights) -> tuple[AxisDesign, AxisDesign]:
    """Horizontal and vertical design of a model.

    Raises:
        InputError: the model lacks a signal, or the weights have no stabilising solution.
    """
    horizontal = design_axis(
        model.horizontal,
        HORIZONTAL_STATES,
        HORIZONTAL_INPUTS,
        np.array([getattr(weights, name) for name in HORIZONTAL_STATES]),
        weights.effort * np.array([1.0, weights.rho]),
        weights.command_delay,
    )
    vertical = design_axis(
        model.vertical,
        VERTICAL_STATES,
        VERTICAL_INPUTS,
        np.array([getattr(weights, name) for name in VERTICAL_STATES]),
        weights.effort * np.array([1.0, 1.0]),
        weights.command_delay,
    )
    return horizontal, vertical


def design_lq(model: ModelFile, weights: LqWeights) -> ControllerFile:
    """The LQ flight controller of a model.

    Args:
        model: with the states HORIZONTAL_STATES and VERTICAL_STATES at least; further stable states are
            residualised.
        weights: of the design.

    Returns:
        the discrete controller of both axes; `provenance` holds weights, gains, poles and loop figures.

    Raises:
        InputError: the model lacks a signal, or the weights have no stabilising solution.
    """
    horizontal, vertical = axis_designs(model, weights)
    provenance = {
        "method": "discrete LQ with the command delay as states, reference on the velocity errors",
        "weights": asdict(weights),
        "horizontal": figures(model.horizontal, horizontal, weights.command_delay),
        "vertical": figures(model.vertical, vertical, weights.command_delay),
        "software": {
            "python": platform.python_version(),
            **{name: version(name) for name in ("heli_control", "numpy", "scipy")},
        },
    }
    return ControllerFile(
        name="lq",
        kind="lq",
        plant_name=model.name,
        plant_hash=model.plant_hash,
        operating_point=model.operating_point,
        horizontal=controller_block(horizontal),
        vertical=controller_block(vertical),
        provenance=provenance,
    )
