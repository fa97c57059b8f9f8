"""Amplitude spectra of a flight: deviation, attitude, velocity and commands in flight, and the raw IMU."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import degrees

import numpy as np
from scipy.signal import welch

from heli_common.flight_state import FlightState
from heli_flight.figures import ESTIMATE, TRUTH
from heli_flight.flight_record import Array, FlightRecord, Motion, Stamps
from heli_flight.graphs import Curve, Graph, Kind, Plot
from heli_flight.metrics import reference_legs

STRETCH = 20.48
"""Longest stretch of a spectrum [s]; shorter flights take half of what they have."""

SHORTEST = 2.0
"""A flight shorter than this has no spectrum [s]."""

_DEGREE = degrees(1.0)


@dataclass(frozen=True)
class Signal:
    """One quantity: title, unit, factor from SI, and where truth and estimate of it are found."""

    title: str
    unit: str
    truth: Callable[[FlightRecord], tuple[Stamps, Array]]
    estimate: Callable[[FlightRecord], tuple[Stamps, Array]] | None = None


def _motion(title: str, unit: str, factor: float, column: Callable[[Motion], Array]) -> Signal:
    return Signal(
        title,
        unit,
        lambda record: (record.truth.stamps, factor * column(record.truth)),
        lambda record: (record.estimate.stamps, factor * column(record.estimate)),
    )


def _command(title: str, column: int) -> Signal:
    return Signal(
        title, "deg", lambda record: (record.servo_command[0], _DEGREE * record.servo_command[1][:, column])
    )


def _imu(title: str, unit: str, factor: float, field: str) -> Signal:
    def source(record: FlightRecord) -> tuple[Stamps, Array]:
        series = record.series["imu"]
        return series.stamps, factor * series.column(field)

    return Signal(title, unit, source)


def _column(group: str, column: int) -> Callable[[Motion], Array]:
    def found(motion: Motion) -> Array:
        values: Array = getattr(motion, group)[:, column]
        return np.asarray(np.unwrap(values), dtype=np.float64) if group == "attitude" else values

    return found


ROWS = (
    tuple(_motion(f"position {n}", "cm", 100.0, _column("position", c)) for c, n in enumerate("xyz")),
    tuple(
        _motion(n, "deg", _DEGREE, _column("attitude", c))
        for c, n in ((1, "pitch θ"), (2, "roll φ"), (0, "yaw ψ"))
    ),
    tuple(_motion(f"velocity {n}", "cm/s", 100.0, _column("velocity", c)) for c, n in enumerate("uvw")),
    (_command("B₁ₛ", 0), _command("A₁ₛ", 1), _command("θ₀", 2)),
    tuple(_imu(f"gyro {n}", "deg/s", _DEGREE, f"angular_velocity.{n}") for n in "xyz"),
    tuple(_imu(f"accelerometer {n}", "m/s²", 1.0, f"linear_acceleration.{n}") for n in "xyz"),
)


def spectrum_graph(records: Sequence[FlightRecord], names: Sequence[str]) -> Graph | None:
    """Amplitude spectral densities in the longest hover, else in the longest free flight; None without.

    Args:
        records: flights, at least one.
        names: one for each flight.
    """
    spans = [calmest(record) for record in records]
    rows = []
    for signals in ROWS:
        plots = [_plot(signal, records, names, spans) for signal in signals]
        if any(plot.curves for plot in plots):
            rows.append(tuple(plots))
    if not rows:
        return None
    caption = (
        f"Amplitude spectral density by Welch's method, stretches of {STRETCH:g} s at most, in the "
        "longest hover (without one in the longest free flight). Motion: the estimate beside the truth; "
        "the IMU is as measured, body axes FLU."
    )
    return Graph("spectra", "Spectra", caption, tuple(rows), row_height=200)


def _plot(
    signal: Signal,
    records: Sequence[FlightRecord],
    names: Sequence[str],
    spans: Sequence[tuple[int, int] | None],
) -> Plot:
    curves: list[Curve] = []
    for flight, (record, name, span) in enumerate(zip(records, names, spans, strict=True)):
        if span is None:
            continue
        alone = len(records) == 1
        if alone and signal.estimate is not None:
            curves += _curve(ESTIMATE, *signal.estimate(record), span, 1, Kind.WIDE)
        word = (TRUTH if signal.estimate is not None else "recorded") if alone else name
        curves += _curve(word, *signal.truth(record), span, flight, Kind.LINE)
    return Plot(signal.title, "[Hz]", f"[{signal.unit}/√Hz]", tuple(curves), log=True, y_log=True)


def _curve(
    label: str, stamps: Stamps, values: Array, span: tuple[int, int], colour: int, kind: Kind
) -> list[Curve]:
    inside = (stamps >= span[0]) & (stamps < span[1])
    found = amplitude_spectrum(stamps[inside], values[inside])
    return [] if found is None else [Curve(label, *found, colour, kind)]


def amplitude_spectrum(stamps: Stamps, values: Array) -> tuple[Array, Array] | None:
    """Frequencies [Hz] and amplitude spectral density [unit of the values per root Hz], without zero.

    Missing samples are filled by a straight line.

    Args:
        stamps: [ns], shape (n,), ascending. values: shape (n,).

    Returns:
        None if there is less than `SHORTEST` of it, or nothing moves.
    """
    known = np.isfinite(values)
    stamps, values = stamps[known], values[known]
    if len(stamps) < 16 or stamps[-1] - stamps[0] < SHORTEST * 1e9:
        return None
    period = int(np.median(np.diff(stamps)))
    grid = np.arange(stamps[0], stamps[-1] + 1, period)
    even = np.interp(grid, stamps, values)
    length = min(len(even) // 2, round(STRETCH * 1e9 / period))
    frequencies, power = welch(even, 1e9 / period, nperseg=length, detrend="linear")
    shown = (frequencies > 1.5 * frequencies[1]) & (power > 0.0)
    if not shown.any():
        return None
    return np.asarray(frequencies[shown]), np.sqrt(power[shown])


def calmest(record: FlightRecord) -> tuple[int, int] | None:
    """First and last stamp [ns] of the longest hover, else of the longest free flight; None without any."""
    hovers = [(leg.start_ns, leg.end_ns) for leg in reference_legs(record) if leg.jump is None]
    flown = [(s.start_ns, s.end_ns) for s in record.stages if s.state is FlightState.FLYING]
    long = [span for span in hovers if span[1] - span[0] >= SHORTEST * 1e9] or flown
    return max(long, key=lambda span: span[1] - span[0], default=None)
