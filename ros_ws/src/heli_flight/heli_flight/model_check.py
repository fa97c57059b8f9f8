"""Is the simulated bench the source's bench? Every printed number beside ours, with a verdict and its reason.

Published and rebuilt numbers come from `heli_bench_sim.reference_results`; ours are computed here from the
helicopter's parameters by `trim` and `linearize`. `model_figures` draws Figures 2.12 to 2.17.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import degrees
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from heli_bench_sim.arm_friction import ArmFrictionParameters
from heli_bench_sim.helicopter import loads
from heli_bench_sim.linear_analysis import modes, scaled, transmission_zeros
from heli_bench_sim.linearize import (
    angular_derivatives,
    horizontal,
    linearize,
    speed_derivatives,
    vertical,
)
from heli_bench_sim.parameters import HelicopterParameters, constants
from heli_bench_sim.reference_results import HORIZONTAL_POLES, REFERENCES, SCALES, Reference
from heli_bench_sim.trim import Trim, trim
from heli_common.linear_model import StateSpace

REPRODUCED, NOT_REPRODUCED, NOT_SCORED = "reproduced", "not reproduced", "not scored"

LEVERS = ("bar_to_blade", "plate_to_blade", "plate_to_bar")
DEGREES = ("theta_0", "theta_t", "phi", "theta", "B_1s", "A_1s", "a_1p", "b_1p")
AS_THEY_ARE = ("V_i", "V_t", "M_A", "U_mot")


@dataclass(frozen=True)
class Row:
    """One printed number and ours."""

    table: str
    key: str
    quantity: str
    unit: str
    published: float | None
    rebuilt: float | None
    ours: float
    to_published: float | None
    """ours less published"""
    to_rebuilt: float | None
    """ours less rebuilt"""
    verdict: str
    """REPRODUCED, NOT_REPRODUCED or NOT_SCORED"""
    explained: bool
    """False if the number is missed and nobody knows why: the model is then not the one of the source"""
    reason: str
    """why it is not reproduced or not scored, or what must be known to read the row; may be empty"""


@dataclass(frozen=True)
class ModelCheck:
    """All rows for one helicopter."""

    parameter_set: str
    rows: tuple[Row, ...]

    @property
    def unexplained(self) -> tuple[Row, ...]:
        """Rows that are missed without a known reason; empty for the shipped sets."""
        return tuple(row for row in self.rows if not row.explained)

    def count(self, verdict: str) -> int:
        """How many rows have a verdict.

        Args:
            verdict: REPRODUCED, NOT_REPRODUCED or NOT_SCORED.
        """
        return sum(row.verdict == verdict for row in self.rows)

    def mapping(self) -> dict[str, Any]:
        """For JSON: plain numbers, strings and None; no NaN."""
        return {
            "parameters": self.parameter_set,
            "reproduced": self.count(REPRODUCED),
            "not_reproduced": self.count(NOT_REPRODUCED),
            "not_scored": self.count(NOT_SCORED),
            "unexplained": [f"{row.table} {row.key}" for row in self.unexplained],
            "rows": [asdict(row) for row in self.rows],
        }


def check_model(
    parameters: HelicopterParameters,
    parameter_set: str,
    friction: ArmFrictionParameters | None = None,
) -> ModelCheck:
    """Compute every number that the source prints and judge it.

    Args:
        parameters: the helicopter.
        parameter_set: name of the shipped set whose rebuilt values and known departures apply.
        friction: of the rig, for the numbers that the source identified in flight.

    Raises:
        ValueError: this helicopter has no steady hover.
    """
    ours = our_values(parameters, friction or ArmFrictionParameters())
    rows = (judge(each, ours[each.table, each.key], parameter_set) for each in REFERENCES)
    return ModelCheck(parameter_set, tuple(rows))


def judge(reference: Reference, ours: float, parameter_set: str) -> Row:
    """Compare one number of ours with what is printed and with what was rebuilt.

    Reproduced is what agrees with both, as far as both exist. A known departure excuses a number only
    while it agrees with the rebuilt value and is no further from print than the departure explains.

    Args:
        reference: published and rebuilt value.
        ours: in the unit of the reference.
        parameter_set: whose rebuilt value and departures apply.
    """
    rebuilt = reference.rebuilt.get(parameter_set)
    to_published = None if reference.published is None else ours - reference.published
    to_rebuilt = None if rebuilt is None else ours - rebuilt
    as_rebuilt = to_rebuilt is None or abs(to_rebuilt) <= reference.rebuilt_tolerance
    known = reference.departures.get(parameter_set)
    missed = f"the rebuilt value is missed by {to_rebuilt:.3g} {reference.unit}" if not as_rebuilt else ""

    if reference.tolerance is None or to_published is None:
        verdict, explained = NOT_SCORED, as_rebuilt
        reasons = [missed, _range(reference, ours), reference.note]
    elif abs(to_published) <= reference.tolerance and as_rebuilt:
        verdict, explained, reasons = REPRODUCED, True, [reference.note]
    elif as_rebuilt and known is not None and abs(to_published) <= known.up_to:
        verdict, explained, reasons = NOT_REPRODUCED, True, [known.reason]
    else:
        verdict, explained = NOT_REPRODUCED, False
        print_missed = abs(to_published) > (reference.tolerance if known is None else known.up_to)
        off = (
            f"print is missed by {to_published:.3g} {reference.unit}, reason unknown" if print_missed else ""
        )
        reasons = [missed, off]
    return Row(
        reference.table,
        reference.key,
        reference.text,
        reference.unit,
        reference.published,
        rebuilt,
        ours,
        to_published,
        to_rebuilt,
        verdict,
        explained,
        "; ".join(reason for reason in reasons if reason),
    )


def _range(reference: Reference, ours: float) -> str:
    if reference.measured_range is None:
        return ""
    lowest, highest = reference.measured_range
    where = "inside" if lowest <= ours <= highest else "outside"
    return f"{where} the measured range {lowest:g} .. {highest:g}"


def our_values(
    parameters: HelicopterParameters, friction: ArmFrictionParameters
) -> dict[tuple[str, str], float]:
    """All our numbers by table and key, in the units of the references.

    Args:
        parameters: the helicopter.
        friction: of the rig.

    Raises:
        ValueError: this helicopter has no steady hover.
    """
    point = trim(parameters)
    full = linearize(parameters, point)
    tables = {
        "2.1": {
            name: getattr(parameters, name) for name in ("bar_to_blade", "plate_to_blade", "plate_to_bar")
        },
        "2.2": drive_values(parameters, point, full),
        "2.3": {name: degrees(getattr(point, name)) for name in DEGREES}
        | {name: getattr(point, name) for name in AS_THEY_ARE},
        "2.4": dict(SCALES),
        "2.5": horizontal_values(horizontal(parameters, point))
        | vertical_values(vertical(parameters, point)),
        "2.6": derivative_values(parameters, full, friction),
    }
    return {(table, key): float(value) for table, values in tables.items() for key, value in values.items()}


def drive_values(parameters: HelicopterParameters, point: Trim, full: StateSpace) -> dict[str, float]:
    """The drive as the source writes it (eq. 2.48, 2.49), as far as the scan can be read.

    M_A' = (-M_A + k_Omega Omega + ...) / T_a, Omega' = k_a (M_A - k_L M_load) with M_load at the motor shaft.

    Args:
        parameters: the helicopter.
        point: hover.
        full: the whole model about it.
    """
    torque_lag = -1.0 / _entry(full, "M_A", "M_A")
    load = loads(point.state, point.inputs, np.zeros(3), constants(parameters))
    load_at_motor = (load.torque + parameters.tail_gear * load.tail_torque) / parameters.motor_gear
    return {
        "T_a": torque_lag,
        "T_a_appendix": torque_lag,
        "k_a": _entry(full, "Omega", "M_A"),
        "k_Omega": _entry(full, "M_A", "Omega") * torque_lag,
        "k_L": point.M_A / load_at_motor,
    }


def horizontal_values(model: StateSpace) -> dict[str, float]:
    """Poles next to the printed ones, number of unstable poles and of zeros.

    Args:
        model: horizontal motion, SI.
    """
    printed = {each.key: each.published or 0.0 for each in HORIZONTAL_POLES}
    pairs = ("roll", "pitch", "unstable", "damped")
    upper = [complex(printed[f"{pair}.real"], printed[f"{pair}.imag"]) for pair in pairs]
    wanted = np.array([*upper, *np.conj(upper)])
    poles = model.poles
    _, match = linear_sum_assignment(np.abs(wanted[:, None] - poles[None, :]))
    values = {
        "unstable_poles": float((poles.real > 0.0).sum()),
        "zeros": float(len(transmission_zeros(scaled(model, SCALES)))),
    }
    for pair, index in zip(pairs, match[: len(pairs)], strict=True):
        values[f"{pair}.real"] = float(poles[index].real)
        values[f"{pair}.imag"] = float(poles[index].imag)
    return values


def vertical_values(model: StateSpace) -> dict[str, float]:
    """The real poles of the vertical plant: two fast ones by size, two slow ones by who takes part.

    Args:
        model: vertical motion and yaw, SI.
    """
    found = modes(model)
    fast, slow = found[:2], found[2:]
    w, r = model.states.index("w"), model.states.index("r")
    heave, yaw = sorted(slow, key=lambda mode: float(mode.participation[r] - mode.participation[w]))
    return {
        "inflow_fast": fast[0].pole.real,
        "inflow_slow": fast[1].pole.real,
        "heave": heave.pole.real,
        "yaw": yaw.pole.real,
    }


def derivative_values(
    parameters: HelicopterParameters, full: StateSpace, friction: ArmFrictionParameters
) -> dict[str, float]:
    """Derivatives of the angular and linear accelerations; two of them on the rig as well.

    Args:
        parameters: the helicopter.
        full: the whole model about hover.
        friction: of the rig; the viscous part, as Coulomb friction has no derivative in flight.
    """
    speed = asdict(speed_derivatives(full))
    return {
        **asdict(angular_derivatives(full)),
        **speed,
        "k": -_entry(full, "a_1p", "a_1p"),
        "X_u.rig": speed["X_u"] - friction.viscous_x / parameters.mass,
        "Y_v.rig": speed["Y_v"] - friction.viscous_y / parameters.mass,
    }


def _entry(model: StateSpace, rate: str, cause: str) -> float:
    return float(model.A[model.states.index(rate), model.states.index(cause)])
