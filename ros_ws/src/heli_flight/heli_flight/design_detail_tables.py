"""Tables of the design report on printed figures, plants, S/KS/T, the trade-off and the syntheses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from heli_control.published import BOUND, PEAK
from heli_flight.design_tables import Metrics
from heli_flight.page_tables import BAD, GOOD, NOTHING, SOFT, TEXT, Cell, Table, number, significant


def published_table(rows: Sequence[Metrics]) -> Table:
    """Every printed figure beside ours."""
    cells = []
    for row in rows:
        ours = row["ours"]
        if ours is None:
            apart = NOTHING
        elif row["criterion"] in (PEAK, BOUND):
            apart = f"{ours - row['value']:+.2f} dB".replace("-", "−")
        else:
            apart = f"× {ours / row['value']:.2f}"
        verdict = Cell("reproduced", GOOD) if row["reproduced"] else Cell("differs", BAD)
        cells.append(
            (
                Cell(row["kind"]),
                Cell(row["axis"], TEXT),
                Cell(row["name"], TEXT),
                Cell(f"{row['value']:g}"),
                Cell(number(ours)),
                Cell(row["unit"], TEXT),
                Cell(apart),
                Cell(row["criterion"], TEXT),
                verdict,
                Cell("" if row["reproduced"] else row["reason"], "reason"),
            )
        )
    header = ("kind", "axis", "figure", "published", "ours", "unit", "apart", "counts if", "verdict", "why")
    return Table("Loop figures", "", header, tuple(cells))


def gain_table(table: Metrics) -> Table:
    """One printed table of static gains with ours below each row."""
    columns = tuple(dict.fromkeys(name for row in table["published"].values() for name in row))
    cells = []
    for command, row in table["published"].items():
        sources = {"source": row} | {
            kind: gains[command] for kind, gains in table["ours"].items() if command in gains
        }
        for who, gains in sources.items():
            cells.append(
                (
                    Cell(command if who == "source" else ""),
                    Cell(who, TEXT if who == "source" else "text soft"),
                    *(Cell(number(gains[name], 3) if name in gains else "") for name in columns),
                )
            )
    note = "deg per deg, per deg/s and per m/s, " + (
        "u = K_r r" if "forward" in table["about"] else "u = −K x"
    )
    return Table(f"Source Table {table['table']}: {table['about']}", note, ("", "of", *columns), tuple(cells))


def plant_tables(plants: Mapping[str, Metrics]) -> list[Table]:
    """Poles with their Hautus distances, and transmission zeros, of each axis."""
    made = []
    for axis, plant in plants.items():
        cells = tuple(
            (
                Cell(_complex(mode["pole"])),
                Cell(number(abs(complex(*mode["pole"])))),
                Cell(significant(mode["controllability"])),
                Cell(significant(mode["observability"])),
            )
            for mode in plant["modes"]
            if mode["pole"][1] >= 0.0
        )
        zeros = ", ".join(_complex(zero) for zero in plant["transmission_zeros"] if zero[1] >= 0.0)
        condition = ", ".join(
            f"{significant(value)} at {at} rad/s" for at, value in plant["condition"].items()
        )
        note = (
            f"States {', '.join(plant['states'])}; inputs {', '.join(plant['inputs'])}; outputs "
            f"{', '.join(plant['outputs'])}. Transmission zeros: {zeros or 'none'}. Condition number "
            f"(singular values): {condition}."
        )
        header = ("pole [rad/s]", "size", "controllability", "observability")
        made.append(Table(f"{axis.capitalize()} plant", note, header, cells))
    return made


def examination_tables(found: Metrics) -> list[Table]:
    """A5 and cancellation, S/KS/T beside GS/T."""
    rank = tuple(
        (
            Cell(row["axis"]),
            Cell("as it is" if not row["appended"] else "with " + " and ".join(row["appended"]), TEXT),
            Cell(row["scheme"], TEXT),
            Cell(significant(row["distance"]) if row["holds"] else "0"),
            Cell(significant(row["frequency"])),
            Cell("holds", GOOD) if row["holds"] else Cell("violated", BAD),
        )
        for row in found["rank"]
    )
    poles = tuple(
        (
            Cell(row["kind"]),
            Cell(row["axis"], TEXT),
            Cell(_complex(row["pole"])),
            Cell(_complex(row["zero"])),
            Cell(significant(row["zero_apart"], 2)),
            Cell(significant(row["hidden"], 2), BAD if row["hidden"] < 1e-2 else ""),
            Cell(_complex(row["closed"])),
            Cell(significant(row["moved"], 2), BAD if row["moved"] < 1e-6 else ""),
        )
        for row in found["slow_poles"]
    )
    made = [
        Table(
            "Assumption A5 of (B1, C2)",
            "Smallest singular value of [A − jω, B1; C2, D21] over all frequencies, and where. That of "
            "GS/T is held down by D21 = W_d at any frequency; no pole of the plant brings it to zero.",
            ("axis", "plant", "scheme", "distance", "at [rad/s]", "A5"),
            rank,
        )
    ]
    if poles:
        note = (
            "Poles of the plant below 1 rad/s, the controller's nearest transmission zero, how far the mode "
            "is hidden in K G (0: cancelled, 1: untouched), and the closed loop's nearest pole: a cancelled "
            "one stays."
        )
        header = (
            "kind", "axis", "pole [rad/s]", "zero of K", "apart", "hidden", "closed loop", "moved [rad/s]",
        )  # fmt: skip
        made.append(Table("Slow poles", note, header, poles))
    return made


def sweep_table(rows: Sequence[Metrics]) -> Table:
    """Cross-overs, peaks and gamma over the factor."""
    names = ("theta", "phi", "u", "v", "q", "p", "L_u", "|S_u|", "|T_u|")
    cells = tuple(
        (
            Cell(f"{row['factor']:.3g}"),
            Cell(number(row["gamma_min"], 3)),
            *(Cell(number(row.get(name))) for name in names),
            Cell(row["refused"], "reason"),
        )
        for row in rows
    )
    return Table("", "Last cross-overs [rad/s], peaks [dB].", ("factor", "γ least", *names, ""), cells)


def assumption_table(controllers: Sequence[Metrics]) -> Table:
    """A1 to A5 of every synthesis with their distances to violation."""
    names = tuple(
        dict.fromkeys(one["name"] for _, _, made in _syntheses(controllers) for one in made["assumptions"])
    )
    cells = []
    for kind, axis, made in _syntheses(controllers):
        found = {one["name"]: one for one in made["assumptions"]}
        cells.append((Cell(kind), Cell(axis, TEXT), *(_assumption(found.get(name)) for name in names)))
    note = (
        "Distance to violation with balanced states: smallest singular value of the matrix concerned; for"
        " A2 γ less what no controller can change; ∞: nothing to stabilise or detect."
    )
    return Table("Assumptions", note, ("kind", "axis", *names), tuple(cells))


def attempt_table(controllers: Sequence[Metrics]) -> Table:
    """Every proposal of both routes and its fate."""
    cells: list[tuple[Cell, ...]] = []
    for kind, axis, made in _syntheses(controllers):
        for one in made["attempts"]:
            cells.append(
                (
                    Cell(kind),
                    Cell(axis, TEXT),
                    Cell(one["route"], TEXT),
                    Cell(one["measures"], TEXT),
                    Cell(number(one["optimal_gamma"], 4)),
                    Cell(number(one["gamma"], 4)),
                    Cell(number(one["norm"], 4)),
                    Cell("refused", BAD) if one["refused"] else Cell("certified", GOOD),
                    Cell(one["refused"], "reason"),
                )
            )
        if not made["attempts"]:
            text = Cell(made["route"], TEXT)
            numbers = (Cell(number(made[name], 4)) for name in ("gamma_min", "gamma", "norm"))
            cells.append(
                (
                    Cell(kind),
                    Cell(axis, TEXT),
                    text,
                    Cell("", SOFT),
                    *numbers,
                    Cell("certified", GOOD),
                    Cell(""),
                )
            )
    header = ("kind", "axis", "route", "measures", "γ least", "γ asked", "norm", "fate", "why refused")
    return Table("Attempts", "In the order tried.", header, tuple(cells))


def _syntheses(controllers: Sequence[Metrics]) -> list[tuple[str, str, Metrics]]:
    return [
        (one["kind"], axis, entry["synthesis"])
        for one in controllers
        for axis, entry in one["axes"].items()
        if entry["synthesis"] is not None
    ]


def _assumption(one: Mapping[str, Any] | None) -> Cell:
    if one is None:
        return Cell(NOTHING)
    text = "∞" if one["distance"] is None else significant(one["distance"])
    return Cell(text, "" if one["holds"] else BAD)


def _complex(value: Sequence[float | None]) -> str:
    real, imaginary = value
    if real is None or imaginary is None:
        return "none"
    if imaginary == 0.0:
        return number(real, 3)
    return f"{number(real, 3)} ± {number(abs(imaginary), 3)} j"
