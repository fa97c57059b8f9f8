"""Source Figures 2.12 to 2.17 drawn from our linear models, as PNG pictures (matplotlib without a screen).

| figure | what it shows |
|---|---|
| 2.12 | singular values and condition number of the whole plant, 5 inputs, 13 outputs |
| 2.13 | the same without position and yaw angle: 5 inputs, 9 outputs |
| 2.14 | the same for the horizontal plant |
| 2.15 | eigenvectors of the four pairs of poles of the horizontal plant in the complex plane |
| 2.16 | theta and u against one cyclic input alone and against both together |
| 2.17 | singular values and condition number of the vertical plant |

All are scaled by source Table 2.4 (eq. 2.61, 2.62).
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas
from numpy.typing import NDArray

from heli_bench_sim.linear_analysis import (
    Mode,
    condition_numbers,
    frequency_response,
    modes,
    scaled,
    singular_values,
)
from heli_bench_sim.linearize import horizontal, linearize, vertical
from heli_bench_sim.parameters import HelicopterParameters
from heli_bench_sim.reference_results import SCALES
from heli_bench_sim.trim import trim
from heli_common.linear_model import StateSpace

Array = NDArray[np.float64]

FREQUENCIES = np.logspace(-2.0, 2.0, 801, dtype=np.float64)
"""[rad/s]; the slow pairs lie at 0.45, the fast ones at 20 and 32."""

NOT_FOR_CONTROL = ("x", "y", "z", "psi")
"""Left out of Figure 2.13: they turn with the heading and are integrators."""

SHOWN = ("theta", "phi", "u", "v", "q", "p")
"""Components of the eigenvectors in Figure 2.15, with the source's own markers where they exist."""

MODE_NAMES = ("$s_1$ roll", "$s_3$ pitch", "$s_5$ slow, less damped", "$s_7$ slow, more damped")
"""Of the upper poles, fastest first, of the slow ones the one further right first."""

_SYMBOLS = {"theta": "θ", "phi": "φ", "B_1s": "$B_{1s}$", "A_1s": "$A_{1s}$"}
_MARKERS = {"theta": "X", "phi": "o", "u": "P", "v": "*", "q": "D", "p": "v"}
_COLOURS = {
    "theta": "#1d4ed8",
    "phi": "#f59e0b",
    "u": "#60a5fa",
    "v": "#ca8a04",
    "q": "#0f766e",
    "p": "#dc2626",
}
_FIRST, _LAST, _BETWEEN, _GREY = "#1d4ed8", "#d97706", "#9ca3af", "#6b7280"
_STYLE = {
    "font.size": 9.0,
    "axes.edgecolor": "#9ca3af",
    "axes.labelcolor": "#374151",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e7eb",
    "grid.linewidth": 0.7,
    "xtick.color": "#4b5563",
    "ytick.color": "#4b5563",
}


@dataclass(frozen=True, eq=False)
class PlantModels:
    """The linear models that the figures show, scaled."""

    whole: StateSpace
    without_position: StateSpace
    horizontal: StateSpace
    vertical: StateSpace


def plant_models(parameters: HelicopterParameters) -> PlantModels:
    """Linear models about hover, scaled by source Table 2.4.

    Args:
        parameters: the helicopter.

    Raises:
        ValueError: this helicopter has no steady hover.
    """
    point = trim(parameters)
    whole = linearize(parameters, point)
    without = whole.part(
        [name for name in whole.states if name not in NOT_FOR_CONTROL],
        whole.inputs,
        [name for name in whole.outputs if name not in NOT_FOR_CONTROL],
    )
    return PlantModels(
        *(
            scaled(each, SCALES)
            for each in (whole, without, horizontal(parameters, point), vertical(parameters, point))
        )
    )


def draw_figures(parameters: HelicopterParameters, parameter_set: str, dpi: int = 120) -> dict[str, bytes]:
    """All six figures, PNG files by name.

    Args:
        parameters: the helicopter.
        parameter_set: its name, for the titles.
        dpi: resolution.
    """
    models = plant_models(parameters)
    with mpl.rc_context(_STYLE):
        canvases = {
            "figure_2_12_whole_plant": _plant(models.whole, "2.12", "Whole plant, 13 outputs"),
            "figure_2_13_without_position": _plant(
                models.without_position, "2.13", "Plant without position and yaw angle, 9 outputs"
            ),
            "figure_2_14_horizontal": _plant(models.horizontal, "2.14", "Horizontal plant, 6 outputs"),
            "figure_2_15_eigenvectors": _eigenvectors(models.horizontal),
            "figure_2_16_single_inputs": _single_inputs(models.horizontal),
            "figure_2_17_vertical": _plant(models.vertical, "2.17", "Vertical plant, outputs w and r"),
        }
        return {f"{name}.png": _png(canvas, parameter_set, dpi) for name, canvas in canvases.items()}


def write_figures(parameters: HelicopterParameters, parameter_set: str, folder: Path) -> list[Path]:
    """Write all six figures into a folder, which is made if need be.

    Args:
        parameters: the helicopter.
        parameter_set: its name, for the titles.
        folder: where.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, png in draw_figures(parameters, parameter_set).items():
        path = folder / name
        path.write_bytes(png)
        written.append(path)
    return written


def decibels(values: Array) -> Array:
    """Gain in dB.

    Args:
        values: gains, positive.
    """
    gains: Array = 20.0 * np.log10(values)
    return gains


def _canvas(title: str, rows: int, columns: int, size: tuple[float, float]) -> tuple[Canvas, Any]:
    canvas = Canvas(figsize=size, layout="constrained")
    FigureCanvasAgg(canvas)
    canvas.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold", color="#111827")
    return canvas, canvas.subplots(rows, columns, squeeze=False)


def _png(canvas: Canvas, parameter_set: str, dpi: int) -> bytes:
    note = "; ticks at the upper edge: poles" if canvas.axes[0].get_xscale() == "log" else ""
    canvas.text(
        0.995,
        0.985,
        f"parameters {parameter_set}, scaled by source Table 2.4{note}",
        ha="right",
        va="top",
        fontsize=8,
        color=_GREY,
    )
    stream = io.BytesIO()
    canvas.savefig(stream, format="png", dpi=dpi, metadata={"Software": None})
    return stream.getvalue()


def _frequency_axis(axis: Any, model: StateSpace) -> None:
    """Logarithmic, with a tick on the upper edge at the frequency of every pole that is seen."""
    axis.set_xscale("log")
    axis.set_xlim(FREQUENCIES[0], FREQUENCIES[-1])
    axis.set_xlabel("frequency [rad/s]")
    axis.grid(visible=True, which="minor", axis="x", linewidth=0.35)
    for size in sorted({round(abs(pole), 3) for pole in model.poles}):
        if FREQUENCIES[0] < size < FREQUENCIES[-1]:
            axis.axvline(size, ymin=0.97, ymax=1.0, color=_GREY, linewidth=1.2)


def _plant(model: StateSpace, figure: str, text: str) -> Canvas:
    values = singular_values(model, FREQUENCIES)
    canvas, axes = _canvas(f"{text} (source Figure {figure})", 1, 2, (10.0, 4.0))
    gain, condition = axes[0]
    gains = decibels(values)
    gain.fill_between(FREQUENCIES, gains[:, -1], gains[:, 0], color=_FIRST, alpha=0.05, linewidth=0)
    for index in range(1, gains.shape[1] - 1):
        gain.plot(FREQUENCIES, gains[:, index], color=_BETWEEN, linewidth=1.0)
    gain.plot(FREQUENCIES, gains[:, 0], color=_FIRST, linewidth=1.8, label="largest")
    gain.plot(FREQUENCIES, gains[:, -1], color=_LAST, linewidth=1.8, label="smallest")
    if gains.shape[1] > 2:
        gain.plot([], [], color=_BETWEEN, linewidth=1.0, label="between")
    gain.set_ylabel("singular values [dB]")
    gain.axhline(0.0, color=_GREY, linewidth=0.8, linestyle=":")
    gain.legend(frameon=False, loc="lower left")
    _frequency_axis(gain, model)

    numbers = condition_numbers(values)
    condition.plot(FREQUENCIES, numbers, color=_FIRST, linewidth=1.8)
    if numbers.max() > 30.0:
        condition.set_yscale("log")
        condition.grid(visible=True, which="minor", axis="y", linewidth=0.35)
    else:
        condition.set_ylim(0.9, max(3.0, 1.1 * float(numbers.max())))
        condition.axhline(1.0, color=_GREY, linewidth=0.8, linestyle=":")
    condition.set_ylabel("condition number")
    _frequency_axis(condition, model)
    return canvas


def _eigenvectors(model: StateSpace) -> Canvas:
    upper = [mode for mode in modes(model) if mode.pole.imag > 0.0]
    upper.sort(key=lambda mode: (-round(abs(mode.pole)), -mode.pole.real))
    canvas, axes = _canvas("Eigenvectors of the horizontal plant (source Figure 2.15)", 1, 4, (12.0, 4.2))
    for axis, mode, name in zip(axes[0], upper, MODE_NAMES, strict=False):
        _phasors(axis, mode, model.states, name)
    axes[0][0].set_ylabel("imaginary part")
    handles, labels = axes[0][0].get_legend_handles_labels()
    canvas.legend(handles, labels, loc="outside lower center", ncols=len(SHOWN), frameon=False)
    return canvas


def _phasors(axis: Any, mode: Mode, states: Sequence[str], name: str) -> None:
    circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
    for radius in (0.5, 1.0):
        axis.plot(radius * circle.real, radius * circle.imag, color="#e5e7eb", linewidth=0.8, zorder=0)
    for state in SHOWN:
        part = mode.shape[states.index(state)]
        colour = _COLOURS[state]
        axis.plot([0.0, part.real], [0.0, part.imag], color=colour, linewidth=1.2, alpha=0.8)
        axis.plot(
            part.real,
            part.imag,
            _MARKERS[state],
            color=colour,
            markersize=12 if state == "v" else 8,
            markeredgecolor="white",
            markeredgewidth=0.6,
            linestyle="none",
            label=_SYMBOLS.get(state, state),
        )
    axis.set_aspect("equal")
    axis.set_xlim(-1.1, 1.1)
    axis.set_ylim(-1.1, 1.1)
    axis.set_xticks([-1.0, 0.0, 1.0])
    axis.set_yticks([-1.0, 0.0, 1.0])
    axis.set_xlabel("real part")
    pole = f"{mode.pole.real:.4g} + {mode.pole.imag:.4g}i rad/s".replace("-", "−")
    axis.set_title(f"{name}\n{pole}", fontsize=9, color="#111827", loc="left")


def _single_inputs(model: StateSpace) -> Canvas:
    response = frequency_response(model, FREQUENCIES)
    canvas, axes = _canvas("One cyclic input and both (source Figure 2.16)", 1, 2, (10.0, 4.3))
    for axis, output in zip(axes[0], ("theta", "u"), strict=True):
        row = np.abs(response[:, model.outputs.index(output), :])
        together = np.linalg.norm(row, axis=1)
        axis.plot(FREQUENCIES, decibels(together), color=_BETWEEN, linewidth=3.5, label="both together")
        for column, colour in ((0, _FIRST), (1, _LAST)):
            name = model.inputs[column]
            label = f"{_SYMBOLS.get(name, name)} alone"
            axis.plot(FREQUENCIES, decibels(row[:, column]), "--", color=colour, linewidth=1.4, label=label)
        axis.axhline(0.0, color=_GREY, linewidth=0.8, linestyle=":")
        axis.set_ylabel(f"gain to {_SYMBOLS.get(output, output)} [dB]")
        _frequency_axis(axis, model)
    handles, labels = axes[0][0].get_legend_handles_labels()
    canvas.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    return canvas
