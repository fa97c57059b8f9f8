"""The static gains that the source prints of its controllers, and ours in the same units: for information.

Tables 3.1, 3.3 and 3.5 are gains from the measured state to the commands, read as u = -K x; Table 3.4 is the
feed-forward part, read as u = K_r r. Units are degrees of blade per degree, per deg/s and per m/s. In the
first three the source counts w and the collective against each other; their column of w has its sign turned
here, after which w has one sign in all four tables and ours has it, too. All else stands as printed. Ours are
the gains at s = 0; the source does not say how it took its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_control.realisation import Array

Gains = Mapping[str, Mapping[str, float]]

_HORIZONTAL = ("theta", "phi", "u", "v", "q", "p")


def _state(
    b_1s: tuple[float, ...], a_1s: tuple[float, ...], w: tuple[float, float], r: tuple[float, float]
) -> Gains:
    """Rows over the horizontal state; columns of w and r, as printed, over the collectives."""
    return {
        "B_1s": dict(zip(_HORIZONTAL, b_1s, strict=True)),
        "A_1s": dict(zip(_HORIZONTAL, a_1s, strict=True)),
        "theta_0": {"w": -w[0], "r": r[0]},
        "theta_t": {"w": -w[1], "r": r[1]},
    }


LQ_GAINS = _state(
    (1.515, 0.206, -10.395, 1.901, 0.050, 0.026),
    (0.119, 1.044, 0.526, 9.308, 0.005, 0.063),
    w=(3.438, 0.0),
    r=(0.0, -0.090),
)
"""Source Table 3.1."""

GST_GAINS = _state(
    (1.797, -0.618, -23.011, -4.241, 0.288, -0.051),
    (0.406, 1.724, -5.289, 20.116, 0.073, 0.217),
    w=(3.751, 3.872),
    r=(-0.001, -0.079),
)
"""Source Table 3.3."""

FEED_FORWARD_GAINS: Gains = {
    "B_1s": {"u": -25.232, "v": -4.804},
    "A_1s": {"u": -5.815, "v": 22.684},
    "theta_0": {"w": -5.579, "r": -0.001},
    "theta_t": {"w": -3.453, "r": -0.080},
}
"""Source Table 3.4; its columns are references."""

LOOP_SHAPING_GAINS = _state(
    (0.576, -0.091, -10.846, -1.591, 0.037, -0.010),
    (0.085, 0.598, -1.538, 10.9573, 0.010, 0.038),
    w=(3.835, 6.749),
    r=(-0.001, -0.163),
)
"""Source Table 3.5."""


@dataclass(frozen=True)
class GainTable:
    """One printed table.

    Attributes:
        number: in the source.
        about: what it is of.
        kinds: designs whose gains stand beside it.
        gains: by command and signal, see the module for signs and units.
        references: whether its columns are references.
    """

    number: str
    about: str
    kinds: tuple[str, ...]
    gains: Gains
    references: bool = False


GAIN_TABLES = (
    GainTable("3.1", "LQ", ("lq",), LQ_GAINS),
    GainTable("3.3", "GS/T, feedback", ("gst", "gst2"), GST_GAINS),
    GainTable("3.4", "GS/T, feed-forward", ("gst2",), FEED_FORWARD_GAINS, references=True),
    GainTable("3.5", "loop shaping", ("ncf", "ncf2"), LOOP_SHAPING_GAINS),
)


def static_gains(controller: StateSpace, period: float | None = None, *, references: bool = False) -> Gains:
    """A controller's gains at rest in the units and signs of the tables.

    Args:
        controller: command = K (measured, references), SI; inputs that end in `_ref` are references.
        period: sample time [s]; None for a continuous controller.
        references: K_r of u = K_r r instead of K of u = -K x.

    Returns:
        by command and signal; a reference goes by the name of its signal.

    Raises:
        InputError: the controller has no gain at rest, for it integrates.
    """
    n = len(controller.states)
    pencil = -controller.A if period is None else np.eye(n) - controller.A
    if n and np.linalg.matrix_rank(pencil) < n:
        raise InputError("the controller integrates", allowed="one with a gain at rest", key="states")
    still: Array = controller.C @ np.linalg.solve(pencil, controller.B) + controller.D
    sign = 1.0 if references else -1.0
    made: dict[str, dict[str, float]] = {}
    for row, command in enumerate(controller.outputs):
        made[command] = {}
        for column, name in enumerate(controller.inputs):
            if name.endswith("_ref") == references:
                signal = name.removesuffix("_ref")
                factor = np.degrees(1.0) if signal in ("u", "v", "w") else 1.0
                made[command][signal] = float(sign * factor * still[row, column])
    return made
