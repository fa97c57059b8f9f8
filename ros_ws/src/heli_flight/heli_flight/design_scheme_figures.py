"""Figures of the design report that belong to one scheme: bounds, shaped loops, references, the PI law."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from heli_control.controller_designs import DesignSummary
from heli_control.flight_plants import DRIVE, REFERENCES
from heli_control.motor_controller_file import MotorControllerFile
from heli_control.realisation import response, series, unnamed
from heli_control.schemes import SCHEMES, AxisWeights
from heli_flight.design_charts import SIGNAL_COLOURS, Chart, Marker, Plot, Trace, decibel
from heli_flight.design_responses import (
    OMEGA,
    LoopResponses,
    l_s_t,
    limits,
    published_values,
    singular_values,
    smallest_gain,
)


def bounds_chart(
    summary: DesignSummary, found: Mapping[str, LoopResponses], weights: Mapping[str, AxisWeights]
) -> Chart:
    """S and T below gamma over the weights: what the certified norm promises of each (Figures 3.3, 3.17)."""
    rows = []
    for axis, each in found.items():
        gamma, chosen = summary.axes[axis].synthesis.gamma, weights[axis]
        if summary.kind == "skst":
            loop, where = each.at_output, "ₑ"
            of_s = smallest_gain(chosen.stacked("W_e"))
            of_t = smallest_gain(chosen.stacked("W_y"))
        else:
            loop, where = each.at_input, "ᵤ"
            disturbed = smallest_gain(chosen.stacked("W_v"))
            of_s = singular_values(response(chosen.stacked("W_y"), OMEGA) @ each.plant)[:, -1] * disturbed
            of_t = smallest_gain(chosen.stacked("W_u")) * disturbed
        _, s, t = l_s_t(loop)
        rows.append(
            tuple(
                Plot(
                    f"{axis}: {name}{where}",
                    (
                        Trace("largest singular value", decibel(singular_values(values)[:, 0]), 0),
                        Trace("γ over the weights", decibel(gamma / bound), 4, dashed=True),
                    ),
                    limits=limits(name),
                    range=(-50.0, 30.0),
                )
                for name, values, bound in (("S", s, of_s), ("T", t, of_t))
            )
        )
    caption = "With the inverses of the weights times γ: the bound that the certified norm implies."
    return Chart(f"{summary.kind}_bounds", "S and T with the inverse weights", caption, OMEGA, tuple(rows))


def motor_chart(summary: DesignSummary) -> Chart:
    """The drive's H-infinity controller beside the PI law taken from it (source Figure 3.4)."""
    made = summary.axes[DRIVE].synthesis
    controller, plant = unnamed(made.controller), response(unnamed(made.plant.si), OMEGA)[:, 0, 0]
    exact = -response(controller, OMEGA)[:, 0, 0]
    if not isinstance(summary.file, MotorControllerFile):
        raise TypeError(f"{summary.kind} is no controller of the drive")
    kept = summary.file.parameters
    law = kept.gain * (1.0 + 1.0 / (1j * OMEGA * kept.integral_time))
    both = (("H∞", exact, 0), ("PI", law, 1))
    return Chart(
        "motor_pi",
        "H∞ controller and PI",
        "The PI law taken from it, below the cross-over alike; right: closed loop of the rotor speed.",
        OMEGA,
        (
            (
                Plot("|K| [V per rad/s]", tuple(Trace(n, decibel(np.abs(v)), c) for n, v, c in both)),
                Plot(
                    "phase of K",
                    tuple(Trace(n, np.degrees(np.unwrap(np.angle(v))), c) for n, v, c in both),
                    unit="deg",
                ),
                Plot(
                    "|T|",
                    tuple(Trace(n, decibel(np.abs(v * plant / (1 + v * plant))), c) for n, v, c in both),
                    range=(-50.0, 10.0),
                ),
            ),
        ),
    )


def shaping_chart(
    summary: DesignSummary, found: Mapping[str, LoopResponses], weights: Mapping[str, AxisWeights]
) -> Chart:
    """The loop gain of loop shaping beside the preshaped loop (Figures 3.24, 3.26)."""
    rows = []
    for axis, loop in summary.loops.items():
        m = len(loop.inputs)
        shaped = singular_values(response(series(loop.plant, weights[axis].stacked("W_1")), OMEGA))
        at_output, at_input = singular_values(found[axis].at_output), singular_values(found[axis].at_input)
        plots = []
        for index, title in sorted({0: "largest", m - 1: "smallest"}.items()):
            plots.append(
                Plot(
                    f"{axis}: {title} singular value",
                    (
                        Trace("preshaped G W₁", decibel(shaped[:, index]), 4, dashed=True),
                        Trace("Lₑ", decibel(at_output[:, index]), 1),
                        Trace("Lᵤ", decibel(at_input[:, index]), 0),
                    ),
                    markers=tuple(
                        Marker("published", value, 0.0, 0)
                        for value in published_values(summary.kind, axis, "L_u")
                    ),
                    range=(-60.0, 60.0),
                )
            )
        rows.append(tuple(plots))
    caption = "The loop as it was shaped, and what the robust controller leaves of it."
    return Chart(f"{summary.kind}_shape", "Loop gain and preshaped loop", caption, OMEGA, tuple(rows))


def reference_chart(summary: DesignSummary, weights: Mapping[str, AxisWeights]) -> Chart:
    """Outputs over references, and the two parts of the controller (Figures 3.20, 3.21)."""
    from_reference, compensators = [], []
    for axis, made in summary.axes.items():
        plant, controller = made.synthesis.plant, made.synthesis.controller
        p = len(plant.si.outputs)
        g, k = response(unnamed(plant.si), OMEGA), response(unnamed(controller), OMEGA)
        sensitivity = np.linalg.inv(np.eye(p) - g @ k[:, :, :p])
        closed = sensitivity @ g @ k[:, :, p:]
        traces = []
        for number, index in enumerate(plant.followed):
            name = plant.si.outputs[index]
            colour = SIGNAL_COLOURS[name]
            traces.append(
                Trace(f"{name} over {REFERENCES[name]}", decibel(np.abs(closed[:, index, number])), colour)
            )
            if "T_yr" in weights[axis].weights:
                wanted = weights[axis].weights["T_yr"][name].at(np.asarray(1j * OMEGA, dtype=np.complex128))
                traces.append(Trace(f"model of {name}", decibel(np.abs(wanted)), colour, dashed=True))
        from_reference.append(Plot(f"{axis}: from reference", tuple(traces), range=(-40.0, 10.0)))
        scale = plant.input_scales[:, None]
        parts = {"K_y": k[:, :, :p] * plant.output_scales / scale}
        if SCHEMES[summary.kind].two_degrees:
            parts["K_r"] = k[:, :, p:] * plant.output_scales[list(plant.followed)] / scale
        compensators.append(
            Plot(
                f"{axis}: controller",
                tuple(
                    Trace(name, decibel(singular_values(part)[:, 0]), colour)
                    for colour, (name, part) in zip((0, 2), parts.items(), strict=False)
                ),
                range=(-40.0, 50.0),
            )
        )
    caption = (
        "Outputs over their references, with the model if there is one; largest singular values of K, scaled."
    )
    return Chart(
        f"{summary.kind}_reference",
        "Following the reference",
        caption,
        OMEGA,
        tuple(zip(from_reference, compensators, strict=True)),
    )
