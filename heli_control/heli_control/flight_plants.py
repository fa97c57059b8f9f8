"""The plants that controllers are designed on: the axes of a model file, scaled (source sec. 2.4.3).

Every signal is divided by what counts as large for it, source Table 2.4, so that weights are of the order of
one. Horizontal: B_1s A_1s to theta phi u v q p, with as many states as the model has. Vertical: theta_0
theta_t to w r. Drive: U_mot to Omega. References exist for u v, for w r and for Omega.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_control.realisation import Array, Realisation

SCALES = {
    "theta": 0.2, "phi": 0.2, "u": 0.2, "v": 0.2, "w": 0.2, "q": 1.0, "p": 1.0, "r": 1.0,
    "B_1s": 0.02, "A_1s": 0.02, "theta_0": 0.02, "theta_t": 0.25, "Omega": 5.0, "U_mot": 2.0,
}  # fmt: skip
"""Source Table 2.4: rad, m/s, rad/s; commands rad and V."""

REFERENCES = {"u": "u_ref", "v": "v_ref", "w": "w_ref", "r": "r_ref", "Omega": "Omega_ref"}
"""Outputs whose deviation is taken from a reference, and its name."""

FLIGHT_AXES = ("horizontal", "vertical")
DRIVE = "drive"
OUTPUTS = {"horizontal": ("theta", "phi", "u", "v", "q", "p"), "vertical": ("w", "r"), DRIVE: ("Omega",)}
INPUTS = {"horizontal": ("B_1s", "A_1s"), "vertical": ("theta_0", "theta_t"), DRIVE: ("U_mot",)}


@dataclass(frozen=True, eq=False)
class FlightPlant:
    """One axis, ready for design.

    Attributes:
        si: continuous plant in SI with the outputs and inputs of the axis.
        scaled: the same in scaled signals, m inputs and p outputs.
        output_scales: shape (p,). input_scales: shape (m,).
    """

    si: StateSpace
    scaled: Realisation
    output_scales: Array
    input_scales: Array

    @property
    def followed(self) -> tuple[int, ...]:
        """Indices of the outputs that have a reference."""
        return tuple(i for i, name in enumerate(self.si.outputs) if name in REFERENCES)

    @property
    def references(self) -> tuple[str, ...]:
        """Names of the references."""
        return tuple(REFERENCES[self.si.outputs[index]] for index in self.followed)

    def controller(self, scaled: Realisation, *, separate_references: bool) -> StateSpace:
        """A controller of scaled signals as one in SI with the names of the axis.

        Args:
            scaled: u = K (r, y) with q references first, or u = K y, the sign of the feedback included; then
                the outputs that have a reference are taken as y - r.
            separate_references: which of the two.

        Returns:
            inputs are the outputs of the plant, then the references.
        """
        q, followed = len(self.followed), list(self.followed)
        into = scaled.B, scaled.D
        if separate_references:
            b_r, b_y = into[0][:, :q], into[0][:, q:]
            d_r, d_y = into[1][:, :q], into[1][:, q:]
        else:
            (b_y, d_y) = into
            b_r, d_r = -b_y[:, followed], -d_y[:, followed]
        scales = np.concatenate((self.output_scales, self.output_scales[followed]))
        out = self.input_scales[:, None]
        return StateSpace(
            tuple(f"k_{index + 1}" for index in range(scaled.order)),
            self.si.outputs + self.references,
            self.si.inputs,
            scaled.A,
            np.hstack((b_y, b_r)) / scales,
            out * scaled.C,
            out * np.hstack((d_y, d_r)) / scales,
        )

    def feedback(self, controller: StateSpace) -> Realisation:
        """The part of an SI controller from the plant's outputs to its inputs, u = K y, scaled again."""
        p = len(self.si.outputs)
        out = self.input_scales[:, None]
        return Realisation(
            controller.A,
            controller.B[:, :p] * self.output_scales,
            controller.C / out,
            controller.D[:, :p] * self.output_scales / out,
        )


def flight_plant(model: ModelFile, axis: str, scales: Mapping[str, float] = SCALES) -> FlightPlant:
    """One axis of a model.

    Args:
        model: whose block of this axis has at least the outputs and inputs of `OUTPUTS` and `INPUTS`.
        axis: `horizontal`, `vertical` or `drive`; the last is cut out of the full model if need be.
        scales: of every output and input.

    Raises:
        InputError: the model lacks a signal.
    """
    block: StateSpace | None = getattr(model, axis)
    if block is None and model.full is not None:
        block = model.full.part(("M_A", "Omega"), INPUTS[axis], OUTPUTS[axis])
    if block is None:
        raise InputError("is missing", allowed="a model with this block, or with `full`", key=axis)
    outputs, inputs = OUTPUTS[axis], INPUTS[axis]
    for wanted, known, key in ((outputs, block.outputs, "outputs"), (inputs, block.inputs, "inputs")):
        for name in wanted:
            if name not in known:
                allowed = f"at least {', '.join(wanted)}"
                raise InputError(f"{', '.join(known)} lacks {name!r}", allowed=allowed, key=f"{axis}.{key}")
    plant = block.part(block.states, inputs, outputs)
    y = np.array([scales[name] for name in outputs])
    u = np.array([scales[name] for name in inputs])
    scaled = Realisation(plant.A, plant.B * u, plant.C / y[:, None], plant.D * u / y[:, None])
    return FlightPlant(plant, scaled, y, u)
