"""Every printed figure and claim of the source beside ours: reproduced, or why not (spec 5)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import degrees
from statistics import fmean

from heli_flight.published_flights import (
    CONTROLLERS,
    DEAD_TIME,
    FARTHEST,
    HOVER,
    NOISE_DEG,
    OPERATING_POINT_DEG,
    TITLES,
    WIND,
)
from heli_flight.reproduction_reasons import REASONS
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
    step_figures,
)
from heli_flight.reproduction_statistics import interval, paired_ratio

TOLERANCE = 0.30
"""Relative difference to print that counts as reproduced (spec 5)."""

DEG = degrees(1.0)


@dataclass(frozen=True)
class Compared:
    """One printed figure or claim.

    Attributes:
        experiment: F1 .. F8. what: in words.
        published: as printed.
        ours: as flown, mean and interval.
        ratio: ours over published; None where that says nothing.
        holds: whether it is reproduced; None if nothing was flown that decides it.
        why: why not, empty if it is.
    """

    experiment: str
    what: str
    published: str
    ours: str
    ratio: float | None
    holds: bool | None
    why: str = ""


def compared(outcomes: Outcomes) -> list[Compared]:
    """Every figure and claim of the source that has been flown."""
    parts: Iterable[Sequence[Compared]] = (
        _hover(outcomes),
        _farthest(outcomes),
        _steps(outcomes),
        _wind(outcomes),
        _noise(outcomes),
        _operating_point(outcomes),
        _wireless(outcomes),
    )
    return [entry for part in parts for entry in part]


def _judged(
    experiment: str,
    key: str,
    what: str,
    published: str,
    ours: str,
    holds: bool | None,
    ratio: float | None = None,
) -> Compared:
    why = "" if holds else REASONS.get(f"{experiment} {key}", "")
    return Compared(experiment, what, published, ours, ratio, holds, why)


def close(ratio: float) -> bool:
    """Whether ours over published counts as reproduced."""
    return abs(ratio - 1.0) <= TOLERANCE


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
                    _judged(
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
                _judged(
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
                _judged(
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


def _steps(outcomes: Outcomes) -> list[Compared]:
    """What sec. 3.5 says of Figures 3.27 to 3.38, as comparisons of numbers."""

    def mean(controller: str, axis: str, name: str) -> float | None:
        values = step_figures(outcomes, controller, axis, name)
        return fmean(values) if values else None

    rows: list[Compared] = []

    def less(
        key: str,
        what: str,
        printed: str,
        pairs: Sequence[tuple[str, str]],
        axis: str,
        name: str,
        factor: float,
        unit: str,
    ) -> None:
        """Whether the first of each pair has the smaller figure."""
        values = {one: mean(one, axis, name) for pair in pairs for one in pair}
        if any(value is None for value in values.values()):
            return
        known = {one: factor * value for one, value in values.items() if value is not None}
        words = ", ".join(f"{TITLES[one]} {value:.2f}" for one, value in known.items()) + f" {unit}"
        rows.append(_judged("F1", key, what, printed, words, all(known[a] < known[b] for a, b in pairs)))

    less(
        "lq fast",
        "rise time of 0.30 m ahead",
        "LQ always fast: before GS/T and loop shaping",
        [("lq", "gst"), ("lq", "ncf")],
        "x",
        "rise_time_s",
        1.0,
        "s",
    )
    less(
        "lq oscillates",
        "pitch after 2.5 s, sigma",
        "LQ goes on oscillating, GS/T and loop shaping do not",
        [("gst", "lq"), ("ncf", "lq")],
        "x",
        "late_theta_rad",
        DEG,
        "deg",
    )
    less(
        "gst overshoots",
        "overshoot ahead",
        "GS/T 1DOF more than LQ",
        [("lq", "gst")],
        "x",
        "overshoot_percent",
        1.0,
        "%",
    )
    less(
        "gst slower",
        "rise time ahead",
        "GS/T 1DOF slower than LQ",
        [("lq", "gst")],
        "x",
        "rise_time_s",
        1.0,
        "s",
    )
    side = mean("ncf2", "y", "overshoot_percent")
    if side is not None:
        rows.append(
            _judged(
                "F1",
                "ncf2 side",
                "loop shaping 2DOF: overshoot to the right",
                "none (Figure 3.36)",
                f"{side:.1f} %",
                side < 5.0,
            )
        )
    less(
        "gst2 smoother",
        "pitch rate of the step, rms",
        "2DOF smoother than 1DOF: GS/T",
        [("gst2", "gst")],
        "x",
        "rms_q_rad_s",
        DEG,
        "deg/s",
    )
    less(
        "ncf2 smoother",
        "pitch rate of the step, rms",
        "2DOF smoother than 1DOF: loop shaping",
        [("ncf2", "ncf")],
        "x",
        "rms_q_rad_s",
        DEG,
        "deg/s",
    )
    others = [name for name in CONTROLLERS if name != "ncf2"]
    less(
        "ncf2 fastest",
        "rise time ahead",
        "loop shaping 2DOF faster than all others (Figure 3.35)",
        [("ncf2", one) for one in others],
        "x",
        "rise_time_s",
        1.0,
        "s",
    )
    less(
        "ncf2 slower",
        "rise time ahead",
        "loop shaping 2DOF slower than 1DOF (Figure 3.37)",
        [("ncf", "ncf2")],
        "x",
        "rise_time_s",
        1.0,
        "s",
    )
    less(
        "ncf2 overshoot",
        "overshoot ahead",
        "loop shaping 2DOF less than 1DOF (sec. 3.5.3)",
        [("ncf2", "ncf")],
        "x",
        "overshoot_percent",
        1.0,
        "%",
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
            _judged(
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
                    _judged(
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
            _judged(
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
                _judged(
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
                _judged(
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
            _judged(
                "F8",
                controller,
                f"{TITLES.get(controller, controller)}: dead time of {DEAD_TIME:g} s",
                "not flyable: the cable was used",
                ours,
                len(reasons) == len(flights),
            )
        )
    return rows
