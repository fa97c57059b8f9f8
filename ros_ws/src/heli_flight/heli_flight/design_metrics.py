"""Everything the design report says in numbers, as one mapping ready for JSON (spec 3.6).

Infinite margins and figures that do not exist are None. Angles are in degrees, peaks in dB, frequencies in
rad/s, times in ms.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_control.controller_designs import LQ, MOTOR, DesignSummary, Loop, design
from heli_control.controller_file import ControllerFile
from heli_control.discretisation import phase_losses
from heli_control.flight_design import AxisDesign, software
from heli_control.flight_plants import DRIVE, FLIGHT_AXES, flight_plant
from heli_control.loop_figures import FREQUENCIES, loop_figures
from heli_control.margins import DiskMargin, LoopMargins, loop_margins, loops
from heli_control.published_gains import GAIN_TABLES, Gains, static_gains
from heli_control.realisation import Array, response
from heli_control.sampled_loop import LoopTiming, SampledLoop, loop_response, sampled_margins
from heli_control.skst_examination import rank_cases, slow_poles
from heli_control.system_properties import modes, transmission_zeros
from heli_control.trade_off import attitude_sweep
from heli_control.uncertainty import robustness_tests
from heli_control.weights_file import read_weights

_POINTS = 600


@dataclass(frozen=True)
class WeightsFolder:
    """Where a user's weights are: `KIND.yaml` for every kind that differs; None for the shipped ones."""

    folder: Path | None = None

    def path(self, kind: str) -> Path | None:
        """Of one kind, None if it does not differ."""
        path = self.folder / f"{kind}.yaml" if self.folder else None
        return path if path and path.is_file() else None


def designed(kind: str, model: ModelFile, weights: WeightsFolder) -> DesignSummary:
    """One controller.

    Raises:
        InputError: as `controller_designs.design`.
    """
    return design(kind, model, weights.path(kind))


def controller_metrics(summary: DesignSummary) -> dict[str, Any]:
    """One controller: every figure of every axis, printed figures, static gains, weights."""
    provenance = summary.file.provenance
    return {
        "kind": summary.kind,
        "axes": {axis: _axis(summary, axis, loop) for axis, loop in summary.loops.items()},
        "published": [
            asdict(row.published) | {"ours": row.ours, "reproduced": row.reproduced}
            for row in summary.published
        ],
        "static_gains": _static_gains(summary),
        "weights": _listed(provenance.get("weights", {})),
        "method": str(provenance.get("method", "")),
    }


def plant_metrics(model: ModelFile, axes: Iterable[str]) -> dict[str, Any]:
    """Poles, zeros, Hautus distances and condition of the scaled plants."""
    found = {}
    for axis in axes:
        plant = flight_plant(model, axis)
        sizes = np.linalg.svd(response(plant.scaled, np.array([1.0, 10.0])), compute_uv=False)
        found[axis] = {
            "states": list(plant.si.states),
            "inputs": list(plant.si.inputs),
            "outputs": list(plant.si.outputs),
            "modes": [
                {
                    "pole": _pair(mode.pole),
                    "controllability": mode.controllability,
                    "observability": mode.observability,
                }
                for mode in modes(plant.scaled)
            ],
            "transmission_zeros": [_pair(zero) for zero in transmission_zeros(plant.scaled)],
            "condition": dict(zip(("1", "10"), (sizes[:, 0] / sizes[:, -1]).tolist(), strict=True)),
        }
    return found


def examination(
    model: ModelFile, weights: WeightsFolder, summaries: Mapping[str, DesignSummary]
) -> dict[str, Any]:
    """S/KS/T beside GS/T: distances to a violation of A5, and what becomes of the slow poles."""
    s_ks_t, gs_t = (read_weights(kind, weights.path(kind)) for kind in ("skst", "gst"))
    return {
        "rank": [
            {
                "axis": axis,
                "scheme": case.scheme,
                "appended": list(case.appended),
                "distance": case.disturbance.distance,
                "frequency": case.disturbance.frequency,
                "holds": case.disturbance.holds,
                "distance_control": case.control.distance,
            }
            for axis in FLIGHT_AXES
            for case in rank_cases(
                flight_plant(model, axis, s_ks_t.axes[axis].scales), s_ks_t.axes[axis], gs_t.axes[axis]
            )
        ],
        "slow_poles": [
            {
                "axis": axis,
                "kind": kind,
                "pole": _pair(slow.cancellation.pole),
                "zero": _pair(slow.cancellation.zero),
                "zero_apart": _finite(slow.cancellation.distance),
                "hidden": slow.cancellation.hidden,
                "closed": _pair(slow.closed),
                "moved": slow.moved,
            }
            for kind in ("skst", "gst")
            if kind in summaries
            for axis, loop in summaries[kind].loops.items()
            for slow in slow_poles(loop.plant, loop.feedback)
            if slow.cancellation.pole.imag >= 0.0
        ],
    }


def sweep(model: ModelFile, weights: WeightsFolder) -> list[dict[str, Any]]:
    """The trade-off of eq. 3.30 for `gst`."""
    return [
        {"factor": one.factor, "gamma_min": _finite(one.gamma), "refused": one.refused, **one.figures}
        for one in attitude_sweep(model, read_weights("gst", weights.path("gst")))
    ]


def gain_tables(controllers: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Each printed table of static gains beside ours."""
    ours = {controller["kind"]: controller["static_gains"] for controller in controllers}
    return [
        {
            "table": table.number,
            "about": table.about,
            "published": {command: dict(row) for command, row in table.gains.items()},
            "ours": {
                kind: ours[kind]["references" if table.references else "state"]
                for kind in table.kinds
                if kind in ours
            },
        }
        for table in GAIN_TABLES
    ]


def versions() -> dict[str, str]:
    """Of what a design depends on."""
    return software()


def _axis(summary: DesignSummary, axis: str, loop: Loop) -> dict[str, Any]:
    omega = FREQUENCIES
    at_input, at_output = loops(response(loop.plant, omega), response(loop.feedback, omega))
    margins = loop_margins(at_input, omega, loop.inputs)
    figures = dict(summary.figures[axis]) | loop_figures(loop.plant, loop.feedback, loop.outputs)
    crossing = figures.get("L_u") or figures.get("crossover")
    return {
        "figures": figures,
        "continuous": _margins(margins),
        "output": _output(at_output),
        "flown": _flown(summary, axis),
        "phase_lost_deg": phase_losses(crossing) if crossing else {},
        "synthesis": _synthesis(summary.axes.get(axis)),
        "order": _orders(summary, axis),
        "tests": [
            asdict(test) | {"frequency": _finite(test.frequency), "norm": _finite(test.norm)}
            for test in robustness_tests(loop.plant, loop.feedback)
        ],
    }


def _margins(margins: LoopMargins) -> dict[str, Any]:
    channels = margins.channels.values()
    return {
        "channels": {
            name: {
                "gain_up_db": _finite(one.gain_up_db),
                "gain_down_db": _finite(one.gain_down_db),
                "phase_deg": _finite(one.phase_deg),
                "delay_ms": _finite(one.delay_ms),
                "disk_alpha": margins.channel_disks[name].alpha,
                "crossovers": list(one.crossovers),
            }
            for name, one in margins.channels.items()
        },
        "least": {
            name: _finite(min(getattr(one, name) for one in channels))
            for name in ("gain_up_db", "gain_down_db", "phase_deg", "delay_ms")
        },
        "disk": _disk(margins.disk),
        "peak_S_db": margins.peak_S_db,
        "peak_T_db": margins.peak_T_db,
        "frequency_S": margins.frequency_S,
        "frequency_T": margins.frequency_T,
    }


def _output(loop: Any) -> dict[str, float]:
    sensitivity = np.linalg.inv(np.eye(loop.shape[1]) + loop)
    peaks = [
        20.0 * math.log10(float(np.linalg.svd(matrix, compute_uv=False)[:, 0].max()))
        for matrix in (sensitivity, np.eye(loop.shape[1]) - sensitivity)
    ]
    return {"peak_S_db": peaks[0], "peak_T_db": peaks[1]}


def _flown(summary: DesignSummary, axis: str) -> dict[str, Any] | None:
    """Margins of the sampled loop with servos, pulse frames and latency; None for the drive, which has none."""
    if not isinstance(summary.file, ControllerFile):
        return None
    block: StateSpace = getattr(summary.file, axis).system
    loop = SampledLoop(flight_plant(summary.model, axis).si, block)
    try:
        whole = sampled_margins(loop)
    except ValueError as error:
        return {"unstable": str(error)}
    nyquist = math.pi / (LoopTiming().pulse_ns * 1e-9)
    omega: Array = np.asarray(np.geomspace(FREQUENCIES[0], 0.999 * nyquist, _POINTS), dtype=np.float64)
    margins = _margins(loop_margins(loop_response(loop, omega), omega, block.outputs))
    all_at_once = {
        "gain_up_db": _finite(whole.gain_up_db),
        "gain_down_db": _finite(whole.gain_down_db),
        "delay_ms": _finite(whole.delay_ms),
        "spectral_radius": whole.spectral_radius,
    }
    return margins | {"all_at_once": all_at_once}


def _synthesis(made: AxisDesign | None) -> dict[str, Any] | None:
    if made is None:
        return None
    found = made.synthesis
    return {
        "gamma_min": found.optimal,
        "gamma": found.gamma,
        "norm": found.norm,
        "norm_frequency": _finite(found.frequency),
        "route": found.route,
        "routes_apart": found.disagreement,
        "attempts": [
            {key: _finite(value) if isinstance(value, float) else value for key, value in asdict(one).items()}
            for one in found.attempts
        ],
        "assumptions": [
            {
                "name": one.name,
                "holds": one.holds,
                "distance": _finite(one.distance),
                "frequency": _finite(one.frequency),
                "text": one.text,
            }
            for one in found.assumptions
        ],
    }


def _orders(summary: DesignSummary, axis: str) -> dict[str, Any]:
    if axis in summary.axes:
        made = summary.axes[axis]
        cut = made.reduction
        return {
            "continuous": len(made.synthesis.controller.states),
            "flown": 1 if summary.kind == MOTOR else len(made.flown.system.states),
            "sampling_error": made.response_error,
            "reduced": cut.system.order,
            "reduction_bound": cut.bound / cut.norm if cut.norm else 0.0,
            "reduction_error": cut.error / cut.norm if cut.norm else 0.0,
        }
    block: StateSpace = getattr(summary.file, axis).system
    return {"continuous": 0, "flown": len(block.states)}


def _static_gains(summary: DesignSummary) -> dict[str, Gains]:
    if summary.kind == MOTOR:
        return {}
    if summary.kind == LQ:
        provenance = summary.file.provenance
        return {"state": {key: row for axis in FLIGHT_AXES for key, row in provenance[axis]["gains"].items()}}
    made = [entry.synthesis.controller for axis, entry in summary.axes.items() if axis != DRIVE]
    return {
        name: {key: row for one in made for key, row in static_gains(one, references=wanted).items()}
        for name, wanted in (("state", False), ("references", True))
    }


def _disk(disk: DiskMargin) -> dict[str, Any]:
    return {
        "alpha": disk.alpha,
        "frequency": disk.frequency,
        "gain_db": _finite(disk.gain_db),
        "phase_deg": disk.phase_deg,
    }


def _pair(value: complex) -> list[float | None]:
    return [_finite(value.real), _finite(value.imag)]


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _listed(value: Any) -> Any:
    """Plain lists and mappings, ready for JSON and YAML."""
    if isinstance(value, Mapping):
        return {str(key): _listed(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_listed(entry) for entry in value]
    return value
