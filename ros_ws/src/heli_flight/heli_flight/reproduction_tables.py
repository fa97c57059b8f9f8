"""Tables of the reproduction: the comparison, steps, wind, noise, identification, link."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

from heli_flight.page_tables import BAD, GOOD, NOTHING, SOFT, TEXT, Cell, Table, number
from heli_flight.published_flights import NOISE_DEG, TITLES
from heli_flight.reproduction_comparison import Compared
from heli_flight.reproduction_results import (
    Outcomes,
    flown_controllers,
    of,
    plateau_figures,
    shown,
    step_figures,
)
from heli_flight.reproduction_statistics import interval

DEG = degrees(1.0)


def comparison_table(rows: Sequence[Compared]) -> Table:
    """Published, ours, ratio, reproduced or why not."""
    words = {True: Cell("reproduced", GOOD), False: Cell("no", BAD), None: Cell(NOTHING, SOFT)}
    cells = tuple(
        (
            Cell(row.experiment),
            Cell(row.what, TEXT),
            Cell(row.published, TEXT),
            Cell(row.ours, TEXT),
            Cell(number(row.ratio)),
            words[row.holds],
            Cell(row.why, "reason"),
        )
        for row in rows
    )
    held = sum(row.holds is True for row in rows)
    note = f"{held} of {len(rows)} reproduced: figures within 30 %, claims as comparisons of ours."
    header = ("flight", "what", "published", "ours: mean [95 %]", "ratio", "verdict", "why not")
    return Table("Published beside ours", note, header, cells)


def step_table(outcomes: Outcomes) -> Table:
    """F1: figures of merit of the steps, both directions of an axis together."""
    cells = []
    for name in flown_controllers(outcomes, "F1"):
        for axis, angle, rate, cross in (("x", "theta", "q", "y"), ("y", "phi", "p", "x")):
            figures = (
                ("rise_time_s", 1.0, 2), ("overshoot_percent", 1.0, 1), ("settling_time_s", 1.0, 2),
                (f"cross_{cross}_max_m", 100.0, 2), (f"{angle}_range_rad", DEG, 2),
                (f"late_{angle}_rad", DEG, 3), (f"rms_{rate}_rad_s", DEG, 2), ("final_error_m", 100.0, 2),
            )  # fmt: skip
            means = [interval(step_figures(outcomes, name, axis, figure)) for figure, _, _ in figures]
            cells.append(
                (
                    Cell(TITLES.get(name, name), TEXT),
                    Cell("ahead" if axis == "x" else "right", TEXT),
                    *(
                        Cell(NOTHING if found is None else number(factor * found.mean, digits))
                        for found, (_, factor, digits) in zip(means, figures, strict=True)
                    ),
                )
            )
    note = "Means over both directions and all seeds. What the source says of its curves is above."
    header = (
        "controller", "axis", "rise [s]", "overshoot [%]", "settling to 2 cm [s]", "cross-axis [cm]",
        "angle, range [deg]", "angle after 2.5 s, sigma [deg]", "rate, rms [deg/s]", "end error [cm]",
    )  # fmt: skip
    return Table("Steps of 0.30 m", note, header, tuple(cells))


def wind_table(outcomes: Outcomes) -> Table:
    """F3: pitch, offset and unrest at every speed of the wind."""
    cells = []
    for name in flown_controllers(outcomes, "F3"):
        flights = of(outcomes, "F3", name)
        for speed in range(9):

            def mean(figure: str, factor: float, digits: int, name: str = name, speed: int = speed) -> Cell:
                found = interval(plateau_figures(outcomes, name, float(speed), figure))
                return Cell(shown(None if found is None else found.scaled(factor), digits))

            through = len(plateau_figures(outcomes, name, float(speed), "asked"))
            cells.append(
                (
                    Cell(TITLES.get(name, name), TEXT),
                    Cell(str(speed)),
                    Cell(f"{through} of {len(flights)}", "" if through == len(flights) else BAD),
                    mean("mean_theta", DEG, 2),
                    mean("mean_x", 100.0, 2),
                    mean("sigma_x", 100.0, 2),
                    mean("sigma_theta", DEG, 2),
                    mean("sigma_q", DEG, 1),
                )
            )
    note = "Means over the last 8.5 s of each step of the wind, gusts of the room included."
    header = (
        "controller", "wind [m/s]", "flown through", "pitch [deg]", "position ahead [cm]",
        "sigma x [cm]", "sigma pitch [deg]", "sigma pitch rate [deg/s]",
    )  # fmt: skip
    return Table("Wind from the front", note, header, tuple(cells))


def noise_table(outcomes: Outcomes) -> Table:
    """F4: the level at which each is lost, both kinds of noise."""

    def level(experiment: str, controller: str) -> tuple[Cell, Cell]:
        flights = of(outcomes, experiment, controller)
        found = interval([DEG * float(one.figures["level"]) for one in flights.values()])
        unlost = sum(one.figures["lost"] is None for one in flights.values())
        reasons = {
            str(one.figures["reason"]).split(" of ")[0] for one in flights.values() if one.figures["reason"]
        }
        words = "; ".join(sorted(reasons)) + (f"; {unlost} of {len(flights)} never" if unlost else "")
        return Cell(shown(found)), Cell(words.lstrip("; "), "reason")

    cells = []
    for name in flown_controllers(outcomes, "F4"):
        borne, lost_at = NOISE_DEG.get(name, (None, None))
        printed = (
            NOTHING
            if borne is None and lost_at is None
            else f"lost at {lost_at:g}"
            if lost_at
            else f"borne at {borne:g}"
        )
        cells.append(
            (Cell(TITLES.get(name, name), TEXT), Cell(printed, TEXT), *level("F4", name), *level("F4b", name))
        )
    note = "Sigma of 5 s of noise on B_1s [deg] at which the flight is lost, by bisection, one draw a seed."
    header = ("controller", "published", "held at 100 Hz [95 %]", "lost by", "up to 5 Hz [95 %]", "lost by")
    return Table("Noise on the longitudinal cyclic", note, header, tuple(cells))


def identification_table(outcomes: Outcomes) -> Table:
    """F5: whether it was flown, and what its data say."""
    cells = []
    for name in flown_controllers(outcomes, "F5"):
        for outcome in of(outcomes, "F5", name).values():
            figures = outcome.figures
            block = figures.get("horizontal", {})
            fits = block.get("fit", {})
            values, errors = block.get("values", {}), block.get("errors", {})
            cells.append(
                (
                    Cell(TITLES.get(name, name), TEXT),
                    Cell(f"{figures['flown']} of {figures['planned']}", BAD if outcome.lost else GOOD),
                    *(Cell(number(fits.get(signal), 0)) for signal in ("u", "v", "q", "p")),
                    *(
                        Cell(
                            f"{number(values[key])} ± {number(2 * errors[key])}" if key in values else NOTHING
                        )
                        for key in ("X_u", "Y_v")
                    ),
                    Cell(outcome.lost or figures.get("remark", ""), "reason"),
                )
            )
    note = (
        "Identified from the cyclic's PRBS, fit on its second draw. The source: X_u −1.07, Y_v −1.19. "
        "More in docs/identification.md."
    )
    header = ("flown with", "excitations", "fit u [%]", "v", "q", "p", "X_u [1/s]", "Y_v [1/s]", "remarks")
    return Table("Identification flights", note, header, tuple(cells))


def apart_table(outcomes: Outcomes) -> Table:
    """F7: nonlinear minus linear."""
    columns: tuple[tuple[str, float, int], ...] = (
        ("x", 100.0, 2), ("y", 100.0, 2), ("u", 100.0, 2), ("v", 100.0, 2),
        ("theta", DEG, 3), ("phi", DEG, 3),
    )  # fmt: skip
    cells = []
    for name in flown_controllers(outcomes, "F7"):
        found = [one.figures["apart"] for one in of(outcomes, "F7", name).values() if "apart" in one.figures]
        shown_cells = []
        for key, factor, digits in columns:
            mean = interval([one[key] for one in found])
            shown_cells.append(Cell(NOTHING if mean is None else number(factor * mean.mean, digits)))
        cells.append((Cell(TITLES.get(name, name), TEXT), *shown_cells))
    header = ("controller", "x [cm]", "y [cm]", "u [cm/s]", "v [cm/s]", "pitch [deg]", "roll [deg]")
    note = "Root mean square over the steps of the velocity reference, in flight minus linear plant."
    return Table("Linear and nonlinear model", note, header, tuple(cells))


def link_table(outcomes: Outcomes) -> Table:
    """F8: what the wireless link does, and the delay that the linear loop bears beyond its own."""
    cells = []
    for name in flown_controllers(outcomes, "F8"):
        flights = list(of(outcomes, "F8", name).values())
        lost = [one for one in flights if one.lost]
        when = interval([float(one.figures["after"]) for one in lost])
        margin = 1e3 * float(flights[0].figures["delay_margin"])
        reason = lost[0].lost if lost else ""
        cells.append(
            (
                Cell(TITLES.get(name, name), TEXT),
                Cell(f"{len(lost)} of {len(flights)}"),
                Cell(shown(when, 1)),
                Cell(number(margin, 0)),
                Cell(reason, "reason"),
            )
        )
    note = "The dead time of 0.1 s begins in hover. Delay margin: of the linear sampled loop, horizontal."
    header = ("controller", "lost", "after [s]", "delay margin [ms]", "reason of the first")
    return Table("Wireless link", note, header, tuple(cells))
