"""Frequency responses: spectrum of the data, model with its band, prior."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.linear_model import StateSpace
from heli_flight.design_charts import decibel
from heli_flight.graphs import Curve, Graph, Kind, Plot
from heli_flight.identification import Identified, hold_of
from heli_flight.identification_figures import (
    MEASURED,
    PRIOR,
    SIMULATION,
    in_rows,
    shown,
)
from heli_identification.sampling import Hold
from heli_identification.spectra import Spectrum, spectrum
from heli_identification.uncertainty import QUANTILE_95
from heli_identification.validation import Response, response

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

FASTEST = 60.0
"""Highest frequency that is shown [rad/s]."""


def response_graphs(found: Identified, prior: StateSpace | None) -> list[Graph]:
    """Magnitude, phase and coherence; none if the data are too short for a spectrum.

    Args:
        found: identification.
        prior: model that stands beside it, of the same states.
    """
    try:
        measured = spectrum(max(found.records, key=len))
    except InputError:
        return []
    frequencies = measured.frequencies[measured.frequencies <= FASTEST]
    estimate = found.estimate
    model = response(estimate.structure, estimate.covariance, frequencies)
    beside = None if prior is None else _response(prior, estimate.structure.outputs, frequencies)
    if hold_of(estimate.structure) is Hold.LATE:
        # the spectrum's input is the command: held for a period from half a period after its stamp on
        turn = frequencies * found.records[0].period
        held = (np.exp(-1j * turn) * np.sinc(turn / (2.0 * np.pi)))[:, None, None]
        model = Response(frequencies, model.values * held, model.deviation * np.abs(held))
        beside = None if beside is None else beside * held
    return [
        magnitude_graph(found, measured, model, beside),
        phase_graph(found, measured, model, beside),
        coherence_graph(found, measured),
    ]


def magnitude_graph(
    found: Identified, measured: Spectrum, model: Response, prior: ComplexArray | None
) -> Graph:
    """|G| of every path: spectral estimate, model with its band, prior."""

    def curves(p: int, m: int) -> tuple[Curve, ...]:
        f = model.frequencies
        values, deviation = np.abs(model.values[:, p, m]), model.deviation[:, p, m]
        seen = np.abs(measured.values[: len(f), p, m])
        scatter = measured.deviation[: len(f), p, m]
        found_curves = [
            _band("spectrum, 95 %", f, decibel(_low(seen, scatter)), decibel(_high(seen, scatter)), MEASURED),
            Curve("spectrum", f, decibel(seen), MEASURED, kind=Kind.POINTS),
            _band(
                "model, 95 %",
                f,
                decibel(_low(values, deviation)),
                decibel(_high(values, deviation)),
                SIMULATION,
            ),
            Curve("model", f, decibel(values), SIMULATION),
        ]
        if prior is not None:
            found_curves.append(Curve("prior", f, decibel(np.abs(prior[:, p, m])), PRIOR, kind=Kind.DASHED))
        return tuple(found_curves)

    rows = []
    for p, output in enumerate(found.estimate.structure.outputs):
        plots = []
        for m, name in enumerate(found.estimate.structure.inputs):
            size = decibel(np.abs(model.values[:, p, m]))
            if not np.any(model.values[:, p, m]):
                # a path the structure does not have
                size = decibel(np.abs(measured.values[: len(size), p, m]))
            window = (float(size.min()) - 15.0, float(size.max()) + 15.0)
            title = f"{shown(output)} by {shown(name)}"
            plots.append(Plot(title, "frequency [rad/s]", "[dB]", curves(p, m), log=True, y_range=window))
        rows.append(tuple(plots))
    how = (
        "with the external signal as instrument"
        if measured.external
        else "of input and output, biased by feedback"
    )
    caption = f"Frequency responses in SI. Spectral estimate (Welch, 5.12 s) {how}; model with its 95 % band."
    return Graph("magnitude", "Frequency responses: magnitude", caption, tuple(rows))


def phase_graph(found: Identified, measured: Spectrum, model: Response, prior: ComplexArray | None) -> Graph:
    """Phases of every path; that of the spectrum within half a turn of the model's."""
    rows = []
    f = model.frequencies
    for p, output in enumerate(found.estimate.structure.outputs):
        plots = []
        for m, name in enumerate(found.estimate.structure.inputs):
            values = model.values[:, p, m]
            phase = np.degrees(np.unwrap(np.angle(values)))
            share = model.deviation[:, p, m] / np.maximum(np.abs(values), 1e-300)
            half = np.degrees(np.minimum(QUANTILE_95 * share / np.sqrt(2.0), np.pi))
            told = measured.deviation[: len(f), p, m] < 0.5 * np.abs(measured.values[: len(f), p, m])
            seen = phase + np.degrees(np.angle(measured.values[: len(f), p, m] * values.conj()))
            curves = [
                Curve("spectrum", f[told], seen[told], MEASURED, kind=Kind.POINTS),
                _band("model, 95 %", f, phase - half, phase + half, SIMULATION),
                Curve("model", f, phase, SIMULATION),
            ]
            if prior is not None:
                beside = phase + np.degrees(np.unwrap(np.angle(prior[:, p, m] * values.conj())))
                curves.append(Curve("prior", f, beside, PRIOR, kind=Kind.DASHED))
            title = f"{shown(output)} by {shown(name)}"
            plots.append(Plot(title, "frequency [rad/s]", "[deg]", tuple(curves), log=True))
        rows.append(tuple(plots))
    caption = "The spectrum where its error is below half its size, within half a turn of the model."
    return Graph("phase", "Frequency responses: phase", caption, tuple(rows))


def coherence_graph(found: Identified, measured: Spectrum) -> Graph:
    """Share of every output's power that the external signals explain."""
    kept = measured.frequencies <= FASTEST
    f = measured.frequencies[kept]
    plots = [
        Plot(
            shown(name),
            "frequency [rad/s]",
            "",
            (Curve("coherence", f, measured.coherence[kept, index], MEASURED),),
            log=True,
            y_range=(0.0, 1.02),
        )
        for index, name in enumerate(found.estimate.structure.outputs)
    ]
    what = "external signals" if measured.external else "inputs"
    caption = (
        f"Share of each output's power that the {what} explain together: 1 is no noise and no nonlinearity."
    )
    return Graph("coherence", "Coherence", caption, in_rows(plots, 3), row_height=160)


def _band(label: str, x: Array, low: Array, high: Array, colour: int) -> Curve:
    return Curve(label, x, low, colour, kind=Kind.BAND, upper=high)


def _low(size: Array, deviation: Array) -> Array:
    # half the deviation of the complex value is along the value
    low: Array = np.maximum(size - QUANTILE_95 * deviation / np.sqrt(2.0), 0.01 * size)
    return low


def _high(size: Array, deviation: Array) -> Array:
    high: Array = size + QUANTILE_95 * deviation / np.sqrt(2.0)
    return high


def _response(model: StateSpace, outputs: tuple[str, ...], frequencies: Array) -> ComplexArray:
    """Shape (f, p, m)."""
    rows = [model.outputs.index(name) for name in outputs]
    eye = np.eye(len(model.states))
    found = [
        model.C[rows] @ np.linalg.solve(1j * w * eye - model.A, model.B) + model.D[rows] for w in frequencies
    ]
    return np.array(found, dtype=np.complex128)
