"""Tables of the design report that compare controllers: words and numbers from its metrics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from heli_control.margins import S_LIMIT_DB, T_LIMIT_DB
from heli_control.uncertainty import OPERATORS
from heli_flight.page_tables import (
    BAD,
    GOOD,
    NOTHING,
    SOFT,
    TEXT,
    UNLIMITED,
    Cell,
    Table,
    number,
    significant,
)

Metrics = Mapping[str, Any]


def overview_tables(controllers: Sequence[Metrics]) -> list[Table]:
    """All controllers side by side."""
    return [
        _syntheses(controllers),
        _crossovers(controllers),
        _designed(controllers),
        _flown(controllers),
        _phases(controllers),
    ]


def robustness_table(controllers: Sequence[Metrics]) -> Table:
    """The source's tests: tolerated size and where it is smallest."""
    cells = []
    for kind, axis, entry in _axes(controllers):
        tests = {test["operator"]: test for test in entry["tests"]}
        cells.append(
            (
                Cell(kind),
                Cell(axis, TEXT),
                *(
                    Cell(f"{significant(tests[name]['tolerated'])} at {_where(tests[name]['frequency'])}")
                    for name in OPERATORS
                ),
            )
        )
    note = (
        "Largest stable perturbation, in scaled signals, for which the loop is surely stable, and the "
        "frequency [rad/s] that limits it. With six outputs and two commands |S_e| and |T_e| depend on "
        "the scales."
    )
    header = ("kind", "axis", *(f"{text} ({name})" for name, text in OPERATORS.items()))
    return Table("Robustness tests (source sec. 3.3.2)", note, header, tuple(cells))


def _axes(controllers: Sequence[Metrics]) -> list[tuple[str, str, Metrics]]:
    return [(one["kind"], axis, entry) for one in controllers for axis, entry in one["axes"].items()]


def _syntheses(controllers: Sequence[Metrics]) -> Table:
    cells = []
    for kind, axis, entry in _axes(controllers):
        made, order = entry["synthesis"] or {}, entry["order"]
        certified = bool(made) and made["norm"] <= 1.001 * made["gamma"]
        cells.append(
            (
                Cell(kind),
                Cell(axis, TEXT),
                Cell(str(order["continuous"])),
                Cell(number(made.get("gamma_min"), 3)),
                Cell(number(made.get("gamma"), 3)),
                Cell(number(made.get("norm"), 3), "" if not made else GOOD if certified else BAD),
                Cell(made.get("route", NOTHING), TEXT),
                Cell(significant(made.get("routes_apart"), 2)),
                Cell(str(order.get("reduced", NOTHING))),
                Cell(significant(order.get("reduction_bound"), 2)),
                Cell(significant(order.get("reduction_error"), 2)),
                Cell(str(order["flown"])),
                Cell(significant(order.get("sampling_error"), 2)),
            )
        )
    note = (
        "Norm: of the closed loop, recomputed; certified when it is at most γ. Reduction by balancing "
        "within a bound of 0.1 % of the controller's norm, for information: what flies is not reduced. "
        "Sampling error: relative, below 25 rad/s."
    )
    header = (
        "kind", "axis", "order", "γ least", "γ asked", "norm certified", "route", "routes apart",
        "order reduced", "bound", "error", "order flown", "sampling error",
    )  # fmt: skip
    return Table("Synthesis and order", note, header, tuple(cells))


def _crossovers(controllers: Sequence[Metrics]) -> Table:
    paths = ("theta", "phi", "u", "v", "q", "p", "w", "r", "Omega")
    cells = []
    for kind, axis, entry in _axes(controllers):
        figures = entry["figures"]
        cells.append(
            (
                Cell(kind),
                Cell(axis, TEXT),
                Cell(number(figures.get("L_u"))),
                Cell(number(figures.get("S_u"))),
                *(Cell(_band(figures, name)) for name in paths),
            )
        )
    note = (
        "rad/s. L_u: largest singular value through 0 dB; S_u: largest singular value through −3 dB; "
        "paths: 0 dB, with the lower end where a path is a band-pass."
    )
    return Table("Cross-overs", note, ("kind", "axis", "L_u", "S_u", *paths), tuple(cells))


def _band(figures: Metrics, name: str) -> str:
    upper, lower = figures.get(name), figures.get(f"{name}, lower")
    if upper is None:
        return ""
    return number(upper) if lower is None else f"{number(lower)} … {number(upper)}"


def _margin_cells(entry: Metrics) -> tuple[Cell, ...]:
    least, disk = entry["least"], entry["disk"]
    return (
        Cell(number(entry["peak_S_db"]), BAD if entry["peak_S_db"] > S_LIMIT_DB else GOOD),
        Cell(number(entry["peak_T_db"]), BAD if entry["peak_T_db"] > T_LIMIT_DB else GOOD),
        Cell(number(least["gain_up_db"], 1, UNLIMITED)),
        Cell(number(least["gain_down_db"], 1, UNLIMITED)),
        Cell(number(least["phase_deg"], 1, UNLIMITED)),
        Cell(number(least["delay_ms"], 0, UNLIMITED)),
        Cell(number(disk["alpha"])),
        Cell(number(disk["gain_db"], 1, UNLIMITED)),
        Cell(number(disk["phase_deg"], 1)),
        Cell(number(disk["frequency"], 1)),
    )


_MARGINS = (
    "|S_u| [dB]", "|T_u| [dB]", "gain up [dB]", "gain down [dB]", "phase [deg]", "delay [ms]",
    "disk α", "disk gain [dB]", "disk phase [deg]", "at [rad/s]",
)  # fmt: skip


def _designed(controllers: Sequence[Metrics]) -> Table:
    cells = tuple(
        (
            Cell(kind),
            Cell(axis, TEXT),
            *_margin_cells(entry["continuous"]),
            Cell(number(entry["output"]["peak_S_db"]), SOFT),
            Cell(number(entry["output"]["peak_T_db"]), SOFT),
        )
        for kind, axis, entry in _axes(controllers)
    )
    note = (
        "Continuous loop at the plant input. Limits: |S_u| 6 dB, |T_u| 2 dB. Gain, phase and delay: least"
        " of the commands, one at a time; disk: all at once. At the output, where six signals are closed "
        "through two commands, |S_e| and |T_e| depend on the scales."
    )
    return Table("Loop as designed", note, ("kind", "axis", *_MARGINS, "|S_e| [dB]", "|T_e| [dB]"), cells)


def _flown(controllers: Sequence[Metrics]) -> Table:
    cells: list[tuple[Cell, ...]] = []
    for kind, axis, entry in _axes(controllers):
        flown = entry["flown"]
        if flown is None:
            continue
        if "unstable" in flown:
            cells.append((Cell(kind), Cell(axis, TEXT), Cell(flown["unstable"], BAD)))
            continue
        whole = flown["all_at_once"]
        cells.append(
            (
                Cell(kind),
                Cell(axis, TEXT),
                *_margin_cells(flown),
                Cell(number(whole["gain_up_db"], 1, UNLIMITED)),
                Cell(number(whole["gain_down_db"], 1, UNLIMITED)),
                Cell(number(whole["delay_ms"], 0, UNLIMITED)),
            )
        )
    note = (
        "Sampled controller, hold, 5 ms latency, 20 ms pulse frames and 25 Hz servos, exactly; without "
        "friction of the arm and without the position controller. Right: all commands by one factor or "
        "one delay, by the eigenvalues of the closed loop. The drive has neither servo nor pulse frames."
    )
    header = ("kind", "axis", *_MARGINS, "all: gain up [dB]", "all: gain down [dB]", "all: delay [ms]")
    return Table("Loop as it flies", note, header, tuple(cells))


def _phases(controllers: Sequence[Metrics]) -> Table:
    parts = ("sample", "latency", "frame", "servo", "all")
    cells = tuple(
        (
            Cell(kind),
            Cell(axis, TEXT),
            Cell(number(entry["figures"].get("L_u"))),
            *(Cell(number(entry["phase_lost_deg"].get(part), 1)) for part in parts),
        )
        for kind, axis, entry in _axes(controllers)
        if entry["flown"] is not None
    )
    note = "At the cross-over of L_u [deg]: half a sample, latency, what the pulse frames add, servo."
    return Table("Phase lost between sample and blade", note, ("kind", "axis", "L_u [rad/s]", *parts), cells)


def _where(frequency: float | None) -> str:
    return UNLIMITED if frequency is None else significant(frequency)
