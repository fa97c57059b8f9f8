"""Tables of the hovers F2: Table 5.2, the order of the controllers, largest deviations and attitude."""

from __future__ import annotations

from math import degrees

from heli_flight.page_tables import BAD, GOOD, SOFT, TEXT, Cell, Table, number
from heli_flight.published_flights import HOVER, TITLES
from heli_flight.reproduction_comparison import close
from heli_flight.reproduction_results import (
    AXES,
    FACTORS,
    SIGMAS,
    UNITS,
    Outcomes,
    flown_controllers,
    hover_figure,
    of,
    shown,
)
from heli_flight.reproduction_statistics import interval, order, paired_ratio, rank_correlation

DEG = degrees(1.0)


def hover_table(outcomes: Outcomes) -> Table:
    """Table 5.2 with intervals, and ratios to LQ beside the source's."""
    cells = []
    for controller in flown_controllers(outcomes, "F2"):
        flights = of(outcomes, "F2", controller)
        lost = sum(bool(one.lost) for one in flights.values())
        for place, axis in enumerate(AXES):
            ours, factor = hover_figure(outcomes, controller, SIGMAS[place]), FACTORS[place]
            found = interval(list(ours.values()))
            if found is None:
                continue
            printed = HOVER.get(controller, (None,) * 4)[place]
            to_lq = paired_ratio(ours, hover_figure(outcomes, "lq", SIGMAS[place]))
            wanted = None if printed is None else printed / HOVER["lq"][place]
            spread = sorted(factor * value for value in ours.values())
            ratio = None if printed is None else found.mean / printed
            judged = (
                ratio
                if controller == "lq"
                else None
                if to_lq is None or wanted is None
                else to_lq.mean / wanted
            )
            mark = "" if judged is None else GOOD if close(judged) else BAD
            cells.append(
                (
                    Cell(TITLES.get(controller, controller), TEXT),
                    Cell(f"{axis} [{UNITS[place]}]", TEXT),
                    Cell(number(None if printed is None else factor * printed)),
                    Cell(shown(found.scaled(factor))),
                    Cell(f"{spread[0]:.2f} … {spread[-1]:.2f}", SOFT),
                    Cell(number(ratio)),
                    Cell(number(wanted)),
                    Cell(shown(to_lq), mark),
                    Cell(f"{lost} of {len(flights)}", BAD if lost else SOFT),
                )
            )
    note = (
        "Sigma of the true pose over a hover of 63 s. Ratios to LQ: geometric means over the same seeds. "
        "The gusts were calibrated on the LQ row alone. Marks: LQ by its size, the others by their ratio."
    )
    header = (
        "controller", "axis", "published", "ours [95 %]", "least … largest seed", "ours / published",
        "published / LQ", "ours / LQ [95 %]", "lost",
    )  # fmt: skip
    return Table("Table 5.2: deviation in hover", note, header, tuple(cells))


def order_table(outcomes: Outcomes) -> Table:
    """Order of the controllers along each axis, the source's and ours."""
    cells = []
    for place, axis in enumerate(AXES):
        found = {
            name: mean.mean
            for name in flown_controllers(outcomes, "F2")
            if (mean := interval(list(hover_figure(outcomes, name, SIGMAS[place]).values()))) is not None
        }
        printed = {name: row[place] for name, row in HOVER.items() if name in found}
        tau = rank_correlation(found, printed)
        cells.append(
            (
                Cell(axis),
                Cell(" < ".join(order(printed)), TEXT),
                Cell(" < ".join(order(found)), TEXT),
                Cell(number(tau)),
            )
        )
    note = "Smallest deviation first. Kendall's tau: 1 the same order, 0 unrelated, −1 reversed."
    return Table("Order of the controllers", note, ("axis", "published", "ours", "tau"), tuple(cells))


def farthest_table(outcomes: Outcomes) -> Table:
    """Largest deviation in the plane and attitude in hover."""
    columns = (
        ("max_xy_m", 100.0, 2), ("max_z_m", 100.0, 2), ("sigma_theta_rad", DEG, 3), ("sigma_phi_rad", DEG, 3),
    )  # fmt: skip
    cells = tuple(
        (
            Cell(TITLES.get(name, name), TEXT),
            *(
                Cell(shown(None if found is None else found.scaled(factor), digits))
                for figure, factor, digits in columns
                for found in (interval(list(hover_figure(outcomes, name, figure).values())),)
            ),
        )
        for name in flown_controllers(outcomes, "F2")
    )
    note = "The source: GS/T less than 4 cm in the xy plane, loop shaping 1.5 cm."
    header = (
        "controller",
        "farthest in xy [cm]",
        "farthest in z [cm]",
        "sigma pitch [deg]",
        "sigma roll [deg]",
    )
    return Table("Largest deviations and attitude in hover", note, header, cells)
