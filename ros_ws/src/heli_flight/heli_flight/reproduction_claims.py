"""Every printed figure and claim of the source beside ours: reproduced, or why not (spec 5)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import degrees
from statistics import fmean

from heli_flight.published_flights import (
    DEAD_TIME,
    FARTHEST,
    HOVER,
    NOISE_DEG,
    OPERATING_POINT_DEG,
    TITLES,
    WIND,
)
from heli_flight.reproduction_comparison import Compared, close, judged
from heli_flight.reproduction_results import (
    AXES,
    FACTORS,
    SIGMAS,
    UNITS,
    Outcomes,
    flown_controllers,
    hover_figure,
    of,
    plateau_figures,
    shown,
)
from heli_flight.reproduction_statistics import interval, paired_ratio
from heli_flight.reproduction_step_claims import step_claims

DEG = degrees(1.0)


def compared(outcomes: Outcomes) -> list[Compared]:
    """Every figure and claim of the source that has been flown."""
    parts: Iterable[Sequence[Compared]] = (
        _hover(outcomes),
        _farthest(outcomes),
        step_claims(outcomes),
        _wind(outcomes),
        _noise(outcomes),
        _operating_point(outcomes),
        _wireless(outcomes),
    )
    return [entry for part in parts for entry in part]


def _hover(outcomes: Outcomes) -> list[Compared]:
    """Rows of Table 5.2: LQ by its size, the others by their ratio to LQ."""
    rows = []
    for controller in flown_controllers(outcomes, "F2"):
        if controller not in HOVER:
            continue
        for place, axis in enumerate(AXES):
            ours = hover_figure(outcomes, controller, SIGMAS[place])
            found = interval(list(ours.values()))
            if found is None:
                continue
            printed, unit = HOVER[controller][place] * FACTORS[place], UNITS[place]
            scaled = found.scaled(FACTORS[place])
            title = f"{TITLES[controller]}: sigma {axis}"
            if controller == "lq":
                ratio = scaled.mean / printed
                rows.append(
                    judged(
                        "F2",
                        f"lq {axis}",
                        f"{title} (calibrated)",
                        f"{printed:.2f} {unit}",
                        shown(scaled, 2, unit),
                        close(ratio),
                        ratio,
                    )
                )
                continue
            to_lq = paired_ratio(ours, hover_figure(outcomes, "lq", SIGMAS[place]))
            if to_lq is None:
                continue
            wanted = HOVER[controller][place] / HOVER["lq"][place]
            ratio = to_lq.mean / wanted
            rows.append(
                judged(
                    "F2",
                    f"{controller} {axis}",
                    f"{title}, over that of LQ",
                    f"{wanted:.2f}",
                    shown(to_lq),
                    close(ratio),
                    ratio,
                )
            )
    return rows


def _farthest(outcomes: Outcomes) -> list[Compared]:
    rows = []
    for controller, printed in FARTHEST.items():
        found = interval(list(hover_figure(outcomes, controller, "max_xy_m").values()))
        if found is not None:
            ours = found.scaled(100.0)
            ratio = found.mean / printed
            words = ("about " if controller == "lq" else "less than ") + f"{100.0 * printed:.1f} cm"
            rows.append(
                judged(
                    "F2",
                    f"{controller} farthest",
                    f"{TITLES[controller]}: farthest in the xy plane",
                    words,
                    shown(ours, 1, "cm"),
                    close(ratio) or (controller != "lq" and ratio < 1.0),
                    ratio,
                )
            )
    return rows


def _wind(outcomes: Outcomes) -> list[Compared]:
    """Figures 5.11, 5.12: pitch at the source's speed, and whether it was flown through."""
    rows = []
    for controller, printed in WIND.items():
        flights = of(outcomes, "F3", controller)
        if not flights:
            continue
        title, speed = TITLES[controller], printed.speed
        survived = [plateau_figures(outcomes, controller, float(step), "asked") for step in range(1, 9)]
        highest = max(
            (step for step, flown in enumerate(survived, 1) if len(flown) == len(flights)), default=0
        )
        rows.append(
            judged(
                "F3",
                f"{controller} speed",
                f"{title}: wind from the front that is flown in",
                f"{speed:g} m/s",
                f"{highest} m/s by all of {len(flights)}",
                highest >= speed,
            )
        )
        if printed.pitch_deg is not None:
            pitch = interval(_at_speed(outcomes, controller, speed, "mean_theta"))
            still = interval(plateau_figures(outcomes, controller, 0.0, "mean_theta"))
            if pitch is not None and still is not None:
                change = pitch.scaled(DEG).mean - still.scaled(DEG).mean
                rows.append(
                    judged(
                        "F3",
                        f"{controller} pitch",
                        f"{title}: change of pitch in {speed:g} m/s",
                        f"{printed.pitch_deg:g} deg",
                        f"{change:.2f} deg".replace("-", "−"),
                        close(change / printed.pitch_deg),
                        change / printed.pitch_deg,
                    )
                )
    offsets = {name: _at_speed(outcomes, name, 4.0, "mean_x") for name in ("lq", "gst", "ncf")}
    if all(offsets.values()):
        known = {name: 100.0 * abs(fmean(values)) for name, values in offsets.items()}
        words = ", ".join(f"{TITLES[name]} {value:.2f}" for name, value in known.items()) + " cm"
        rows.append(
            judged(
                "F3",
                "offset",
                "offset ahead in 4 m/s",
                "LQ most, GS/T less, loop shaping none",
                words,
                known["lq"] > known["gst"] > known["ncf"],
            )
        )
    return rows


def _at_speed(outcomes: Outcomes, controller: str, speed: float, name: str) -> list[float]:
    """A figure of F3 between the two steps of the wind around a speed, of each seed."""
    below, above = float(int(speed)), float(int(speed) + (speed > int(speed)))
    low, high = (plateau_figures(outcomes, controller, step, name) for step in (below, above))
    share = speed - below
    return [a + share * (b - a) for a, b in zip(low, high, strict=False)] if share else low


def _noise(outcomes: Outcomes) -> list[Compared]:
    """Figures 5.13, 5.14: the level that each bears, for both kinds of noise."""
    rows = []
    for controller, (borne, lost_at) in NOISE_DEG.items():
        for experiment, kind in (("F4", "held at 100 Hz"), ("F4b", "up to 5 Hz")):
            flights = of(outcomes, experiment, controller)
            found = interval([DEG * float(one.figures["level"]) for one in flights.values()])
            if found is None:
                continue
            unlost = sum(one.figures["lost"] is None for one in flights.values())
            printed = f"lost at {lost_at:g} deg" if lost_at is not None else f"borne up to {borne:g} deg"
            ours = f"{shown(found, 2, 'deg')}" + (
                f", {unlost} of {len(flights)} never lost" if unlost else ""
            )
            wanted = lost_at if lost_at is not None else borne
            if wanted is None:
                continue
            holds = found.mean >= wanted if lost_at is None else close(found.mean / wanted)
            rows.append(
                judged(
                    experiment,
                    controller,
                    f"{TITLES[controller]}: noise on B_1s {kind}, where it is lost",
                    printed,
                    ours,
                    holds,
                    found.mean / wanted,
                )
            )
    return rows


def _operating_point(outcomes: Outcomes) -> list[Compared]:
    """Table 5.3: means over all hovers of all controllers."""
    names = {
        "theta": ("mean_theta_rad", 1.0),
        "phi": ("mean_phi_rad", 1.0),
        "A_M": ("mean_theta_0_rad", -1.0),
        "B_1s": ("mean_B_1s_rad", 1.0),
        "A_1s": ("mean_A_1s_rad", 1.0),
        "A_R": ("mean_theta_t_rad", 1.0),
    }
    rows = []
    for name, printed in OPERATING_POINT_DEG.items():
        figure, sign = names[name]
        values = [
            sign * DEG * value
            for controller in flown_controllers(outcomes, "F2")
            for value in hover_figure(outcomes, controller, figure).values()
        ]
        found = interval(values)
        if found is not None:
            ratio = found.mean / printed
            rows.append(
                judged(
                    "F6",
                    name,
                    f"operating point: {name}",
                    f"{printed:.3f} deg".replace("-", "−"),
                    shown(found, 3, "deg"),
                    close(ratio),
                    ratio,
                )
            )
    return rows


def _wireless(outcomes: Outcomes) -> list[Compared]:
    rows = []
    for controller in flown_controllers(outcomes, "F8"):
        flights = of(outcomes, "F8", controller)
        reasons = [one for one in flights.values() if one.lost]
        when = interval([float(one.figures["after"]) for one in reasons])
        ours = f"lost {len(reasons)} of {len(flights)}" + (f", after {shown(when, 1, 's')}" if when else "")
        rows.append(
            judged(
                "F8",
                controller,
                f"{TITLES.get(controller, controller)}: dead time of {DEAD_TIME:g} s",
                "not flyable: the cable was used",
                ours,
                len(reasons) == len(flights),
            )
        )
    return rows
