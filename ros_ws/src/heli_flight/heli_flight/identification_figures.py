"""What an identification shows: simulation beside measurement, poles, residuals (Figures 2.10-2.23)."""

from __future__ import annotations

from math import degrees

import numpy as np
from numpy.typing import NDArray

from heli_common.linear_model import StateSpace
from heli_flight.design_charts import GREEK
from heli_flight.graphs import Curve, Graph, Kind, Plot
from heli_flight.identification import SIMULATED, Identified
from heli_identification.pole_uncertainty import uncertain_poles
from heli_identification.residual_tests import autocorrelation, cross_correlation

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MEASURED, SIMULATION, PRIOR = 0, 1, 2
"""Numbers of colours."""
SHOWN = 4
"""Segments of validation that are drawn; the table has all."""
FIGURES = {
    "full": "2.18, 2.19",
    "servo_rotor": "2.20, 2.21",
    "vertical": "2.22",
    "vertical_full": "2.22",
    "drive": "2.10, 2.11",
    "drive_torque": "2.10, 2.11",
}
_UNITS = {"u": "m/s", "v": "m/s", "w": "m/s", "M_A": "N m", "Omega": "rad/s"}
_ANGLES = ("theta", "phi")


def comparison_graph(found: Identified) -> Graph:
    """Free simulation beside measurement, two outputs in a row."""
    fit = found.fit
    if fit is None:
        raise ValueError("nothing was validated")
    count = round(SIMULATED / found.records[0].period)
    used = min(SHOWN, len(fit.segments)) * count
    time = np.arange(used, dtype=np.float64) * found.records[0].period
    breaks = np.arange(used) % count == count - 1
    plots = []
    for index, name in enumerate(fit.outputs):
        factor = _factor(name)
        simulated = np.where(breaks, np.nan, fit.simulated[:used, index])
        curves = (
            Curve("measured", time, factor * fit.measured[:used, index], MEASURED, kind=Kind.WIDE),
            Curve("simulated", time, factor * simulated, SIMULATION),
        )
        title = f"{shown(name)}: fit {fit.percent[index]:.1f} %"
        plots.append(Plot(title, "time [s]", f"[{unit(name)}]", curves, x_range=(0.0, float(time[-1]))))
    figure = FIGURES.get(found.estimate.structure.name, "2.18")
    caption = (
        f"Data that were not estimated from: free simulation over {SIMULATED:g} s each from a fitted initial "
        f"state, deviations from the mean (source Figures {figure}). The first {used // count} of "
        f"{len(fit.segments)} segments; the fit is that of all."
    )
    return Graph("comparison", "Simulation beside measurement", caption, in_rows(plots, 2))


def pole_graph(found: Identified, prior: StateSpace | None) -> Graph:
    """Poles with their ellipses, all and those near the origin (source Figure 2.23)."""
    estimate = found.estimate
    poles = uncertain_poles(estimate.structure, estimate.covariance)
    curves = []
    for index in range(len(poles.values)):
        ring = poles.ellipse(index)
        curves.append(Curve("95 %" if index == 0 else "", ring.real, ring.imag, SIMULATION))
    curves.append(Curve("identified", poles.values.real, poles.values.imag, SIMULATION, kind=Kind.CROSSES))
    known: ComplexArray = poles.values
    if prior is not None:
        curves.append(Curve("prior", prior.poles.real, prior.poles.imag, PRIOR, kind=Kind.CROSSES))
        known = np.concatenate((known, prior.poles))
    near = np.abs(known) < 0.2 * np.max(np.abs(known))
    plots = [_pole_plot("all", tuple(curves), known)]
    for title, part in (("fast ones above the axis", ~near & (known.imag > 0.0)), ("near the origin", near)):
        if np.any(part):
            plots.append(_pole_plot(title, tuple(curves), known[part]))
    caption = (
        "Ellipses hold a pole with 95 % by the covariance of the coefficients, to first order; lines for "
        "real poles (source Figure 2.23)."
    )
    return Graph("poles", "Pole map", caption, (tuple(plots),), row_height=380)


def _pole_plot(title: str, curves: tuple[Curve, ...], inside: ComplexArray) -> Plot:
    """A window about some poles."""
    size = float(np.max(np.abs(inside)))
    ranges = []
    for part in (inside.real, inside.imag):
        margin = max(0.2 * float(np.ptp(part)), 0.02 * size)
        ranges.append((float(part.min()) - margin, float(part.max()) + margin))
    return Plot(
        title, "real part [1/s]", "imaginary part [1/s]", curves, x_range=ranges[0], y_range=ranges[1]
    )


def residual_graph(found: Identified) -> Graph:
    """Autocorrelations of the residuals and correlations with past and later inputs, with 95 % bounds."""
    structure, period = found.estimate.structure, found.records[0].period
    residuals = np.vstack(found.estimate.residuals)
    inputs = np.vstack([r.u[: len(e)] for r, e in zip(found.records, found.estimate.residuals, strict=True)])
    own, cross = autocorrelation(residuals), cross_correlation(residuals, inputs)
    both = period * cross.lags.astype(np.float64)
    rows = []
    for row, output in enumerate(structure.outputs):
        later = own.lags > 0
        lags = period * own.lags[later].astype(np.float64)
        curve = Curve("autocorrelation", lags, own.values[later, row], MEASURED, kind=Kind.STEMS)
        plots = [_correlation_plot(f"{shown(output)} with itself", curve, float(own.bound[row]))]
        for column, name in enumerate(structure.inputs):
            values = cross.values[:, row, column]
            curve = Curve("with the input", both, values, SIMULATION, kind=Kind.STEMS)
            title = f"{shown(output)} with {shown(name)}"
            plots.append(_correlation_plot(title, curve, float(cross.bound[row, column])))
        rows.append(tuple(plots))
    caption = (
        "Dotted: white residuals stay inside 95 % of the time. Positive lags are earlier inputs: what stands "
        "out there the model leaves unexplained. Negative lags are later inputs, which feedback ties to the "
        "residuals."
    )
    return Graph("residuals", "Residuals of the estimation", caption, tuple(rows), row_height=130)


def _correlation_plot(title: str, curve: Curve, bound: float) -> Plot:
    return Plot(title, "lag [s]", "", (curve,), limits=(-bound, bound))


def shown(name: str) -> str:
    """A signal as it is written in charts."""
    return GREEK.get(name, name)


def unit(name: str) -> str:
    """In which an output is drawn."""
    return _UNITS.get(name, "deg" if name in _ANGLES else "deg/s")


def _factor(name: str) -> float:
    return 1.0 if name in _UNITS else degrees(1.0)


def in_rows(plots: list[Plot], columns: int) -> tuple[tuple[Plot, ...], ...]:
    """Plots in rows; columns that do not come out even become fewer."""
    while len(plots) % columns:
        columns -= 1
    return tuple(tuple(plots[at : at + columns]) for at in range(0, len(plots), columns))
