"""Tables of the flight report: words and numbers from the figures of merit of one flight or several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees
from typing import Any

import yaml

from heli_flight.flight_statistics import NEAR_LIMIT
from heli_flight.page_tables import BAD, NOTHING, SOFT, TEXT, Cell, Table, number, significant

Summary = Mapping[str, Any]

_DEGREE = degrees(1.0)
_ESTIMATED = {
    "m": ("mm", 1e3, 1),
    "rad": ("deg", _DEGREE, 3),
    "m_s": ("cm/s", 1e2, 2),
    "rad_s": ("deg/s", _DEGREE, 2),
}
"""Unit, factor from SI and digits of an estimated quantity."""

_WORDS = {"theta": "pitch θ", "phi": "roll φ", "psi": "yaw ψ", "B_1s": "B₁ₛ", "A_1s": "A₁ₛ"} | {
    "theta_0": "θ₀",
    "theta_t": "θₜ",
}


def _cell(value: float | None, factor: float = 1.0, digits: int = 2) -> Cell:
    return Cell(number(None if value is None else value * factor, digits))


def hover_table(summaries: Sequence[Summary]) -> Table:
    """One row for every hover, in the manner of the source's Table 5.2."""
    rows = []
    for summary in summaries:
        for hover in summary["metrics"]["hover"]:
            end = hover["start_s"] + hover["duration_s"]
            rows.append(
                (
                    Cell(summary["name"]),
                    Cell(f"{hover['start_s']:.1f} – {end:.1f}"),
                    *(_cell(hover[f"sigma_{axis}_m"], 100.0) for axis in "xyz"),
                    *(_cell(hover[f"sigma_{angle}_rad"], _DEGREE) for angle in ("psi", "theta", "phi")),
                    _cell(hover["max_xy_m"], 100.0),
                    _cell(hover["max_z_m"], 100.0),
                    *(_cell(hover[f"mean_{axis}_m"], 100.0) for axis in "xyz"),
                )
            )
    header = (
        *("flight", "time [s]", "σ x", "σ y", "σ z", "σ ψ", "σ θ", "σ φ"),
        *("farthest in xy", "farthest in z", "mean x", "mean y", "mean z"),
    )
    note = "True position and attitude against the reference: σ standard deviation, mean offset; cm and deg."
    return Table("", note, header, tuple(rows))


def step_table(summaries: Sequence[Summary]) -> Table:
    """One row for every step."""
    rows = []
    for summary in summaries:
        for step in summary["metrics"]["steps"]:
            turned = step["axis"] == "psi"
            unit, factor, word = ("rad", _DEGREE, "deg") if turned else ("m", 100.0, "cm")
            rows.append(
                (
                    Cell(summary["name"]),
                    Cell(f"{step['start_s']:.1f}"),
                    Cell("ψ" if turned else step["axis"]),
                    Cell(f"{number(step[f'amplitude_{unit}'] * factor, 1)} {word}"),
                    _cell(step["rise_time_s"]),
                    _cell(step["overshoot_percent"], digits=1),
                    _cell(step["settling_time_s"]),
                    Cell(f"{number(step[f'final_error_{unit}'] * factor)} {word}"),
                    *(_cell(step.get(f"cross_{axis}_max_m"), 100.0) for axis in "xyz"),
                    _cell(step["theta_range_rad"], _DEGREE),
                    _cell(step["phi_range_rad"], _DEGREE),
                )
            )
    header = (
        *("flight", "at [s]", "axis", "step", "rise [s]", "overshoot [%]", "settled [s]", "final error"),
        *("x moves", "y moves", "z moves", "pitch range", "roll range"),
    )
    note = (
        "Rise from 10 to 90 %; settled within 2 cm or 2 deg; final error: mean of the last 0.5 s; motion of "
        "the other axes in cm; pitch and roll from lowest to highest in deg."
    )
    return Table("", note, header, tuple(rows))


def command_table(summaries: Sequence[Summary]) -> Table:
    """Range, spread, rate and time at the limits of every command."""
    rows = []
    for summary in summaries:
        for command in summary["metrics"]["commands"]:
            turned = "mean_rad" in command
            unit, factor, word = ("rad", _DEGREE, "deg") if turned else ("V", 1.0, "V")
            share = command["at_limit_percent"]
            rows.append(
                (
                    Cell(summary["name"]),
                    Cell(f"{_WORDS.get(command['channel'], command['channel'])} [{word}]", TEXT),
                    *(
                        _cell(command[f"{name}_{unit}"], factor)
                        for name in ("lower_limit", "lowest", "mean", "highest", "upper_limit", "sigma")
                    ),
                    _cell(command[f"rms_rate_{unit}_s"], factor, 1),
                    Cell(number(share), BAD if share > 1.0 else ""),
                )
            )
    header = (
        *("flight", "command", "lower limit", "lowest", "mean", "highest", "upper limit", "σ"),
        *("rms rate [1/s]", "at a limit [% of the time]"),
    )
    note = (
        f"While the controllers steer. At a limit: within {100.0 * NEAR_LIMIT:g} % of the travel of its end. "
        "The two cyclic angles share one swash plate: what one uses the other has not."
    )
    return Table("Commands against limits", note, header, tuple(rows))


def wind_table(summaries: Sequence[Summary]) -> Table:
    """Mean, spread and extremes of the air."""
    rows = [
        (
            Cell(summary["name"]),
            Cell(wind["axis"], TEXT),
            *(_cell(wind[f"{name}_m_s"]) for name in ("mean", "sigma", "lowest", "highest")),
        )
        for summary in summaries
        for wind in summary["metrics"]["wind"]
        if wind["lowest_m_s"] != 0.0 or wind["highest_m_s"] != 0.0
    ]
    header = ("flight", "towards", "mean", "σ", "lowest", "highest")
    return Table("Wind", "Velocity of the air in m/s while the controllers steer.", header, tuple(rows))


def estimation_table(summaries: Sequence[Summary]) -> Table:
    """Errors of the navigation beside what it claims."""
    rows = []
    for summary in summaries:
        for error in summary["metrics"]["estimation"]:
            unit = next(unit for unit in _ESTIMATED if f"rms_{unit}" in error)
            word, factor, digits = _ESTIMATED[unit]
            name = _WORDS.get(error["quantity"], error["quantity"])
            rows.append(
                (
                    Cell(summary["name"]),
                    Cell(f"{name} [{word}]", TEXT),
                    *(_cell(error[f"{key}_{unit}"], factor, digits) for key in ("rms", "mean", "max")),
                    _cell(error[f"claimed_sigma_{unit}"], factor, digits),
                    _cell(error["inside_two_sigma_percent"], digits=1),
                )
            )
    header = ("flight", "quantity", "rms", "mean", "largest", "claimed σ", "inside 2 σ [%]")
    note = "Estimated less true while the controllers steer; a normal error is inside 2 σ for 95.4 %."
    return Table("Errors of the navigation", note, header, tuple(rows))


def sampling_table(summary: Summary) -> Table:
    """Rates and losses of every topic of one flight."""
    rows = []
    for topic in summary["sampling"]:
        lost = BAD if topic["lost"] else ""
        pause = topic["longest_pause_s"]
        rows.append(
            (
                Cell(topic["topic"]),
                Cell(topic["type"], TEXT),
                Cell(f"{topic['messages']:,}"),
                Cell(NOTHING if topic["expected"] is None else f"{topic['expected']:,}"),
                Cell(str(topic["lost"]), lost),
                Cell(str(topic["gaps"]), lost),
                Cell(number(topic["first_gap_s"], 3), lost),
                Cell(significant(topic["nominal_rate_hz"], 4), SOFT),
                Cell(significant(topic["rate_hz"], 4)),
                Cell(number(None if pause is None else 1e3 * pause, 1), lost),
            )
        )
    header = (
        *("topic", "type", "messages", "expected", "lost", "gaps", "first gap [s]"),
        *("nominal [Hz]", "recorded [Hz]", "longest pause [ms]"),
    )
    note = "By the stamps of simulated time: a message that is missing leaves a gap between its neighbours."
    return Table(summary["name"], note, header, tuple(rows))


def difference_table(summaries: Sequence[Summary], parameters: Sequence[Mapping[str, Any]]) -> Table:
    """Parameters in which compared flights differ.

    Args:
        summaries: of the flights. parameters: of each, nested.
    """
    flat = [dict(_flat(one)) for one in parameters]
    names = sorted({name for one in flat for name in one})
    rows = tuple(
        (Cell(name), *(Cell(str(one.get(name, NOTHING)), TEXT) for one in flat))
        for name in names
        if len({str(one.get(name)) for one in flat}) > 1
    )
    note = f"Of {len(names)} parameters; all others are the same." if rows else "All parameters are the same."
    return Table("Parameters that differ", note, ("parameter", *(s["name"] for s in summaries)), rows)


def parameter_table(parameters: Mapping[str, Any]) -> Table:
    """All parameters of one flight."""
    rows = tuple((Cell(name), Cell(str(value), TEXT)) for name, value in sorted(_flat(parameters)))
    return Table("", "", ("parameter", "value"), rows)


def _flat(nested: Any, path: str = "") -> list[tuple[str, Any]]:
    """Names joined by points, and their values."""
    if not isinstance(nested, Mapping):
        return [(path, nested)]
    found = []
    for key, value in nested.items():
        found += _flat(value, f"{path}.{key}" if path else str(key))
    return found


def mapping(text: str) -> dict[str, Any]:
    """A YAML or JSON mapping in a bag's remarks; empty if it is none."""
    try:
        document = yaml.safe_load(text)
    except yaml.YAMLError:
        return {}
    return document if isinstance(document, dict) else {}
