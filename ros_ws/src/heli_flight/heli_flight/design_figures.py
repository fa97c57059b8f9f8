"""What the design report draws: the source's figures 3.3 to 3.26 for any set of controllers, as curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from heli_control.controller_designs import MOTOR, DesignSummary
from heli_control.flight_plants import DRIVE, FLIGHT_AXES
from heli_control.margins import S_LIMIT_DB, T_LIMIT_DB
from heli_control.realisation import Array
from heli_control.schemes import AxisWeights
from heli_flight.design_charts import GREEK, SIGNAL_COLOURS, Chart, Marker, Plot, Trace, decibel
from heli_flight.design_responses import (
    OMEGA,
    LoopResponses,
    l_s_t,
    level_range,
    limits,
    published_values,
    singular_values,
)
from heli_flight.design_scheme_figures import bounds_chart, motor_chart, reference_chart, shaping_chart

PATHS = {
    "longitudinal": ("theta", "u", "q"),
    "lateral": ("phi", "v", "p"),
    "vertical and yaw": ("w", "r"),
    DRIVE: ("Omega",),
}
_BOUNDED = (MOTOR, "skst", "gst", "gst2")
_SHAPED = ("ncf", "ncf2")


def overview_chart(summaries: Mapping[str, DesignSummary]) -> Chart:
    """L, S and T at the plant's input of all flight controllers over each other."""
    kinds = [kind for kind in summaries if kind != MOTOR]
    rows = []
    for axis in FLIGHT_AXES:
        drawn: dict[str, list[Trace]] = {"L": [], "S": [], "T": []}
        for number, kind in enumerate(kinds):
            loop = LoopResponses.of(summaries[kind].loops[axis]).at_input
            for name, values in zip("LST", l_s_t(loop), strict=True):
                drawn[name].append(Trace(kind, decibel(singular_values(values)[:, 0]), colour=number))
        rows.append(
            tuple(
                Plot(f"{axis}: {name}ᵤ", tuple(traces), limits=limits(name), range=level_range(name))
                for name, traces in drawn.items()
            )
        )
    caption = "Largest singular values at the plant input; dotted: the limits of 6 dB and 2 dB."
    return Chart("overview_loops", "All controllers", caption, OMEGA, tuple(rows))


def controller_charts(summary: DesignSummary, weights: Mapping[str, AxisWeights]) -> list[Chart]:
    """The figures of one controller.

    Args:
        summary: of the design.
        weights: of its axes; empty for LQ.
    """
    found = {axis: LoopResponses.of(loop) for axis, loop in summary.loops.items()}
    charts = [_loops_chart(summary, found), _paths_chart(summary, found)]
    if summary.kind in _BOUNDED:
        charts.append(bounds_chart(summary, found, weights))
    if summary.kind == MOTOR:
        charts.append(motor_chart(summary))
    if summary.kind in _SHAPED:
        charts.append(shaping_chart(summary, found, weights))
    if summary.kind != MOTOR and summary.axes:
        charts.append(reference_chart(summary, weights))
    return charts


def sweep_chart(rows: Sequence[Mapping[str, Any]]) -> Chart:
    """Cross-overs and peaks of `gst` over the factor of eq. 3.30."""
    factors = np.array([row["factor"] for row in rows], dtype=np.float64)

    def along(name: str) -> Array:
        return np.array([row.get(name, np.nan) for row in rows], dtype=np.float64)

    paths = tuple(
        Trace(GREEK.get(name, name), along(name), SIGNAL_COLOURS[name])
        for name in ("theta", "u", "q", "phi", "v", "p")
    )
    peaks = tuple(
        Trace(label, along(name), colour=number)
        for name, label, number in (("|S_u|", "|Sᵤ|", 6), ("|T_u|", "|Tᵤ|", 7))
    )
    return Chart(
        "trade_off",
        "Attitude against velocity",
        "GS/T with the angle block of W_d times a factor (source eq. 3.30): last cross-over of each path, "
        "and peaks at the plant input.",
        factors,
        (
            (
                Plot("cross-over of the paths", paths, unit="rad/s"),
                Plot("peaks", peaks, unit="dB", limits=(S_LIMIT_DB, T_LIMIT_DB)),
            ),
        ),
        x_label="factor on the angle block of W_d",
    )


def _loops_chart(summary: DesignSummary, found: Mapping[str, LoopResponses]) -> Chart:
    rows = []
    for axis, each in found.items():
        m = each.at_input.shape[1]
        plots = []
        for name, inside, outside in zip("LST", l_s_t(each.at_input), l_s_t(each.at_output), strict=True):
            at_input, at_output = singular_values(inside), singular_values(outside)
            # L_e and T_e have the rank of the inputs; the rest of their singular values is zero
            last = at_output.shape[1] - 1 if name == "S" else m - 1
            traces = [
                Trace("at the input", decibel(at_input[:, index]), 0) for index in sorted({0, m - 1})
            ] + [
                Trace("at the output", decibel(at_output[:, index]), 1, dashed=True)
                for index in sorted({0, last})
            ]
            markers = published_values(
                summary.kind, axis, "L_u" if name == "L" else "S_u" if name == "S" else ""
            )
            level = 0.0 if name == "L" else -3.0
            plots.append(
                Plot(
                    f"{axis}: {name}",
                    tuple(traces),
                    markers=tuple(Marker("published", value, level, 0) for value in markers),
                    limits=limits(name),
                    range=level_range(name),
                )
            )
        rows.append(tuple(plots))
    caption = (
        "Singular values of L, S and T, largest and smallest; diamonds: published L_u at 0 dB, S_u at -3 dB."
    )
    return Chart(
        f"{summary.kind}_loops", "Loop, sensitivity, complementary sensitivity", caption, OMEGA, tuple(rows)
    )


def _paths_chart(summary: DesignSummary, found: Mapping[str, LoopResponses]) -> Chart:
    plots = []
    for title, names in PATHS.items():
        for axis, loop in summary.loops.items():
            if not set(names) & set(loop.outputs):
                continue
            each, traces, markers = found[axis], [], []
            for name in names:
                index, colour = loop.outputs.index(name), SIGNAL_COLOURS[name]
                path = np.einsum("ki,ki->k", each.plant[:, index, :], each.controller[:, :, index])
                traces.append(Trace(GREEK.get(name, name), decibel(np.abs(path)), colour))
                for wanted in ("crossover" if name == "Omega" else name, f"{name}, lower"):
                    values = published_values(summary.kind, axis, wanted)
                    markers += [Marker("published", value, 0.0, colour) for value in values]
            plots.append(Plot(title, tuple(traces), tuple(markers), range=(-50.0, 40.0)))
    caption = (
        "One measured signal closed through all commands, the others open; diamonds: published cross-overs."
    )
    return Chart(f"{summary.kind}_paths", "Paths of the measured signals", caption, OMEGA, (tuple(plots),))
