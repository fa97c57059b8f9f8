"""What the source says of its steps, Figures 3.27 to 3.38, as comparisons of numbers (sec. 3.5)."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees
from statistics import fmean

from heli_flight.published_flights import CONTROLLERS, TITLES
from heli_flight.reproduction_comparison import Compared, judged
from heli_flight.reproduction_results import Outcomes, step_figures

DEG = degrees(1.0)


def step_claims(outcomes: Outcomes) -> list[Compared]:
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
        rows.append(judged("F1", key, what, printed, words, all(known[a] < known[b] for a, b in pairs)))

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
            judged(
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
