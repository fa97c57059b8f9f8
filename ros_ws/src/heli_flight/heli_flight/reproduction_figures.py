"""The source's figures of its flights, as ours: Figures 3.27 to 3.38, 5.5 to 5.14, and those of app. E."""

from __future__ import annotations

from math import degrees

import numpy as np

from heli_flight.flight_record import Array
from heli_flight.graphs import Curve, Graph, Kind, Plot
from heli_flight.published_flights import CONTROLLERS, TITLES, WIND
from heli_flight.reproduction_flights import Outcome
from heli_flight.reproduction_results import Outcomes, flown_controllers, of, plateau_figures
from heli_flight.reproduction_statistics import interval

DEG = degrees(1.0)
COLOURS = {name: number for number, name in enumerate(CONTROLLERS)}
STEPS = {
    ("3.27", "3.28"): ("lq", "gst"),
    ("3.29", "3.30"): ("lq", "ncf"),
    ("3.31", "3.32"): ("lq", "gst2"),
    ("3.33", "3.34"): ("gst", "gst2"),
    ("3.35", "3.36"): ("lq", "ncf2"),
    ("3.37", "3.38"): ("ncf", "ncf2"),
}
"""Figures of the steps ahead and to the right, and the two controllers that each shows."""
HOVERS = {"5.5": "lq", "5.6": "gst", "5.7": "ncf", "5.9": "gst2", "5.10": "ncf2"}
WINDS = {"5.11": ("lq",), "5.12": ("gst",), "": ("ncf", "gst2", "ncf2")}
NOISES = {"5.13": "lq", "5.14": "ncf2"}
STEP_SHOWN = 10.0
"""How long a step is drawn, as the source's are [s]."""
PLANES = (("x", "y"), ("z", "y"), ("x", "z"))


def colour(controller: str) -> int:
    """Number of a controller's colour."""
    return COLOURS.get(controller, len(COLOURS))


def drawn(outcomes: Outcomes, experiment: str, controller: str) -> Outcome | None:
    """The outcome with curves, if there is one."""
    found = [one for one in of(outcomes, experiment, controller).values() if one.curves]
    return found[0] if found else None


def step_graphs(outcomes: Outcomes) -> list[Graph]:
    """Figures 3.27 to 3.38."""
    graphs = []
    for figures, pair in STEPS.items():
        for figure, axis in zip(figures, ("x", "y"), strict=True):
            flights = {name: found for name in pair if (found := drawn(outcomes, "F1", name)) is not None}
            if len(flights) == len(pair):
                graphs.append(_step_graph(figure, axis, flights))
    return graphs


def _step_graph(figure: str, axis: str, flights: dict[str, Outcome]) -> Graph:
    other, angle, speed = ("y", "theta", "u") if axis == "x" else ("x", "phi", "v")
    place: list[Curve] = []
    angles: list[Curve] = []
    speeds: list[Curve] = []
    for name, flight in flights.items():
        curves = flight.curves
        begin = _jump(curves["time"], curves[f"{axis}_ref"])
        shown = (curves["time"] >= begin - 0.5) & (curves["time"] < begin + STEP_SHOWN)
        time = curves["time"][shown] - begin
        start = curves[f"{axis}_ref"][0]
        if not place:
            place.append(Curve("reference", time, curves[f"{axis}_ref"][shown] - start, 7, Kind.DASHED))
        title, number = TITLES[name], colour(name)
        place.append(Curve(title, time, curves[axis][shown] - start, number))
        place.append(Curve("", time, curves[other][shown], number, Kind.DASHED))
        angles.append(Curve(title, time, DEG * curves[angle][shown], number))
        speeds.append(Curve(title, time, curves[speed][shown], number))
    titles = " and ".join(TITLES[name] for name in flights)
    way = "ahead" if axis == "x" else "to the right"
    return Graph(
        f"step_{figure.replace('.', '_')}",
        f"Figure {figure}: 0.30 m {way}, {titles}",
        f"Full line {axis}, dashed {other} and the reference; the way back after 6 s.",
        (
            (
                Plot("position", "time [s]", "m", tuple(place)),
                Plot("pitch" if axis == "x" else "roll", "time [s]", "deg", tuple(angles)),
                Plot(f"velocity {speed}", "time [s]", "m/s", tuple(speeds)),
            ),
        ),
    )


def _jump(time: Array, reference: Array) -> float:
    """When a reference first leaves its first value [s]."""
    moved = np.flatnonzero(np.abs(reference - reference[0]) > 1e-3)
    return float(time[moved[0]]) if len(moved) else 0.0


def hover_graphs(outcomes: Outcomes) -> list[Graph]:
    """Figures 5.5 to 5.10: the planes xy, zy, xz, and the attitude."""
    graphs = []
    for figure, name in HOVERS.items():
        flight = drawn(outcomes, "F2", name)
        if flight is None:
            continue
        error = {
            axis: 100.0 * (flight.curves[axis] - flight.curves[f"{axis}_ref"]) for axis in ("x", "y", "z")
        }
        largest = max(12.0, *(float(np.abs(column).max()) for column in error.values()))
        span = (-largest, largest)
        plots = tuple(
            Plot(
                f"{b} over {a}",
                f"{a} [cm]",
                f"{b} [cm]",
                (Curve("", error[a], error[b], colour(name)),),
                x_range=span,
                y_range=span,
            )
            for a, b in PLANES
        )
        key = f"hover_{figure.replace('.', '_')}"
        graphs.append(
            Graph(
                key, f"Figure {figure}: hover, {TITLES[name]}", "Deviation from the reference.", (plots,), 300
            )
        )
    shown = {name: found for name in CONTROLLERS if (found := drawn(outcomes, "F2", name)) is not None}
    if shown:
        rows = tuple(
            (
                Plot(
                    title,
                    "time [s]",
                    "deg",
                    tuple(
                        Curve(TITLES[name], one.curves["time"], DEG * one.curves[angle], colour(name))
                        for name, one in shown.items()
                    ),
                ),
            )
            for angle, title in (("theta", "pitch"), ("phi", "roll"))
        )
        graphs.append(Graph("hover_5_8", "Figure 5.8: attitude in hover", "Of the hovers above.", rows))
    return graphs


def wind_graphs(outcomes: Outcomes) -> list[Graph]:
    """Figures 5.11 and 5.12, and means over the steps of the wind for all controllers."""
    graphs = []
    for figure, names in WINDS.items():
        for name in names:
            flight = drawn(outcomes, "F3", name)
            if flight is None:
                continue
            curves, number = flight.curves, colour(name)
            time = curves["time"]
            rows = tuple(
                (Plot(title, "time [s]", unit, (Curve("", time, factor * curves[signal], number),)),)
                for signal, title, unit, factor in (
                    ("fan", "wind on the axis", "m/s", 1.0),
                    ("x", "position ahead", "cm", 100.0),
                    ("u", "velocity ahead", "m/s", 1.0),
                    ("theta", "pitch", "deg", DEG),
                )
            )
            title = f"Figure {figure}: " if figure else ""
            end = f"Lost: {flight.lost}." if flight.lost else "Flown to the end."
            graphs.append(
                Graph(f"wind_{name}", f"{title}wind from the front, {TITLES[name]}", end, rows, 150)
            )
    overview = _wind_overview(outcomes)
    return ([overview] if overview is not None else []) + graphs


def _wind_overview(outcomes: Outcomes) -> Graph | None:
    plots = []
    for figure, title, unit, factor in (
        ("mean_theta", "pitch", "deg", DEG),
        ("mean_x", "position ahead", "cm", 100.0),
        ("sigma_x", "sigma of x", "cm", 100.0),
    ):
        curves = []
        for name in flown_controllers(outcomes, "F3"):
            points = [
                (float(speed), found.scaled(factor))
                for speed in range(9)
                if (found := interval(plateau_figures(outcomes, name, float(speed), figure))) is not None
            ]
            if not points:
                continue
            x = np.array([speed for speed, _ in points])
            mean = np.array([one.mean for _, one in points])
            low, high = (np.array([getattr(one, end) for _, one in points]) for end in ("low", "high"))
            if not np.isnan(low).any():
                curves.append(Curve("", x, low, colour(name), Kind.BAND, high))
            curves.append(Curve(TITLES.get(name, name), x, mean, colour(name)))
        if figure == "mean_theta":
            printed = [(one.speed, one.pitch_deg) for one in WIND.values() if one.pitch_deg is not None]
            x, y = np.array(printed, dtype=np.float64).T
            curves.append(Curve("source", x, y, 7, Kind.CROSSES))
        if curves:
            plots.append(Plot(title, "wind [m/s]", unit, tuple(curves)))
    if not plots:
        return None
    words = "Means over the last 8.5 s of every step of the wind, of the flights that got there; bands: 95 %."
    return Graph("wind", "Pitch and position against the wind", words, (tuple(plots),), 300)


def noise_graphs(outcomes: Outcomes) -> list[Graph]:
    """Figures 5.13 and 5.14."""
    graphs = []
    for figure, name in NOISES.items():
        flight = drawn(outcomes, "F4n", name)
        if flight is None:
            continue
        curves, number = flight.curves, colour(name)
        sigma = DEG * float(flight.figures["sigma"])
        command = Plot(
            "noise, and the command with it",
            "time [s]",
            "deg",
            (
                Curve("noise", curves["time"], DEG * curves["noise"], 7, Kind.WIDE),
                Curve("B_1s", curves["time"], DEG * (curves["B_1s"] + curves["noise"]), number),
            ),
        )
        rows = (
            (
                command,
                Plot("pitch", "time [s]", "deg", (Curve("", curves["time"], DEG * curves["theta"], number),)),
            ),
            tuple(
                Plot(axis, "time [s]", "cm", (Curve("", curves["time"], 100.0 * curves[axis], number),))
                for axis in ("x", "y")
            ),
        )
        end = f"Lost: {flight.lost}." if flight.lost else "Not lost."
        title = f"Figure {figure}: noise of {sigma:.1f} deg on B_1s, {TITLES[name]}"
        graphs.append(Graph(f"noise_{name}", title, end, rows))
    return graphs


def linear_graphs(outcomes: Outcomes) -> list[Graph]:
    """App. E: steps of position and of the velocity reference, on the linear and on the nonlinear model."""
    graphs = []
    for experiment, title in (("F1", "steps of 0.30 m"), ("F7", "steps of the velocity reference")):
        for name in flown_controllers(outcomes, experiment):
            flight = drawn(outcomes, experiment, name)
            if flight is None or "linear_x" not in flight.curves:
                continue
            curves, number = flight.curves, colour(name)
            rows = []
            for signals in (("x", "u", "theta"), ("y", "v", "phi")):
                plots = []
                for signal in signals:
                    factor, unit = {
                        "x": (1.0, "m"),
                        "y": (1.0, "m"),
                        "u": (1.0, "m/s"),
                        "v": (1.0, "m/s"),
                    }.get(signal, (DEG, "deg"))
                    flown = factor * (curves[signal] - curves[signal][:40].mean())
                    linear = factor * curves[f"linear_{signal}"]
                    both = (
                        Curve("nonlinear, in flight", curves["time"], flown, number),
                        Curve("linear", curves["time"], linear, 7, Kind.DASHED),
                    )
                    plots.append(Plot(signal, "time [s]", unit, both))
                rows.append(tuple(plots))
            key = f"linear_{experiment}_{name}"
            words = "Deviations from the hover before; the linear plant has viscous friction only."
            graphs.append(Graph(key, f"{TITLES[name]}: {title}", words, tuple(rows), 170))
    return graphs
