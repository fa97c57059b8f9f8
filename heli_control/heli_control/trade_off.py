"""The trade-off of attitude against velocity (source eq. 3.30): a factor on the angle block of W_d, swept.

The smaller the disturbance that the design expects on the measured angles, the more it relies on them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from heli_common.errors import InputError
from heli_common.model_file import ModelFile
from heli_control.certified import SynthesisRefused
from heli_control.flight_plants import flight_plant
from heli_control.loop_figures import loop_figures
from heli_control.realisation import Array
from heli_control.schemes import synthesis
from heli_control.weights_file import WeightsFile

SETTING = "attitude"
FACTORS: Array = np.asarray(np.geomspace(0.1, 1.0, 7), dtype=np.float64)
"""The source's range."""


@dataclass(frozen=True)
class TradeOff:
    """The horizontal loop at one factor.

    Attributes:
        factor: on W_d of the angles.
        gamma: smallest possible; nan if refused.
        figures: see `loop_figures`; empty if refused.
        refused: the reason; empty if a controller was certified.
    """

    factor: float
    gamma: float
    figures: Mapping[str, float]
    refused: str = ""


def attitude_sweep(
    model: ModelFile, weights: WeightsFile, factors: Sequence[float] | Array = FACTORS
) -> tuple[TradeOff, ...]:
    """Horizontal designs over the factor.

    Args:
        model: to design for.
        weights: of a kind with the setting `attitude`; its own factor is replaced.
        factors: 0.001 .. 1.

    Raises:
        InputError: weights without this setting, or a model that lacks a signal.
    """
    axis = weights.axes.get("horizontal")
    if axis is None or SETTING not in axis.settings:
        raise InputError(f"{weights.kind!r} has no {SETTING}", allowed="gst, gst2", key="kind")
    plant = flight_plant(model, "horizontal", axis.scales)
    found = []
    for factor in factors:
        chosen = replace(axis, settings={**axis.settings, SETTING: float(factor)})
        try:
            made = synthesis(weights.kind, plant, chosen)
        except SynthesisRefused as error:
            found.append(TradeOff(float(factor), float("nan"), {}, error.reason))
            continue
        figures = loop_figures(plant.scaled, plant.feedback(made.controller), plant.si.outputs)
        found.append(TradeOff(float(factor), made.optimal, figures))
    return tuple(found)
