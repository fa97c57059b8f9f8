"""Everything the design report says in numbers, as one mapping ready for JSON (spec 3.6).

Infinite margins and figures that do not exist are None. Angles are in degrees, peaks in dB, frequencies in
rad/s, times in ms.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from heli_common.linear_model import StateSpace
from heli_common.model_file import ModelFile
from heli_control.controller_designs import LQ, MOTOR, DesignSummary, Loop, design
from heli_control.controller_file import ControllerFile
from heli_control.discretisation import phase_losses
from heli_control.flight_design import AxisDesign
from heli_control.flight_plants import DRIVE, FLIGHT_AXES, flight_plant
from heli_control.loop_figures import FREQUENCIES, loop_figures
from heli_control.margins import DiskMargin, LoopMargins, loop_margins, loops
from heli_control.published_gains import Gains, static_gains
from heli_control.realisation import Array, response
from heli_control.sampled_loop import LoopTiming, SampledLoop, loop_response, sampled_margins
from heli_control.uncertainty import robustness_tests

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


def pair(value: complex) -> list[float | None]:
    """Real and imaginary part."""
    return [finite(value.real), finite(value.imag)]


def finite(value: float) -> float | None:
    """A number as JSON can hold it: None if it is infinite or none."""
    return float(value) if math.isfinite(value) else None


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
            asdict(test) | {"frequency": finite(test.frequency), "norm": finite(test.norm)}
            for test in robustness_tests(loop.plant, loop.feedback)
        ],
    }


def _margins(margins: LoopMargins) -> dict[str, Any]:
    channels = margins.channels.values()
    return {
        "channels": {
            name: {
                "gain_up_db": finite(one.gain_up_db),
                "gain_down_db": finite(one.gain_down_db),
                "phase_deg": finite(one.phase_deg),
                "delay_ms": finite(one.delay_ms),
                "disk_alpha": margins.channel_disks[name].alpha,
                "crossovers": list(one.crossovers),
            }
            for name, one in margins.channels.items()
        },
        "least": {
            name: finite(min(getattr(one, name) for one in channels))
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
    """Margins with hold, servos, pulse frames and latency; None for the drive, which has no servo."""
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
        "gain_up_db": finite(whole.gain_up_db),
        "gain_down_db": finite(whole.gain_down_db),
        "delay_ms": finite(whole.delay_ms),
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
        "norm_frequency": finite(found.frequency),
        "route": found.route,
        "routes_apart": found.disagreement,
        "attempts": [
            {key: finite(value) if isinstance(value, float) else value for key, value in asdict(one).items()}
            for one in found.attempts
        ],
        "assumptions": [
            {
                "name": one.name,
                "holds": one.holds,
                "distance": finite(one.distance),
                "frequency": finite(one.frequency),
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
        "gain_db": finite(disk.gain_db),
        "phase_deg": disk.phase_deg,
    }


def _listed(value: Any) -> Any:
    """Plain lists and mappings, ready for JSON and YAML."""
    if isinstance(value, Mapping):
        return {str(key): _listed(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_listed(entry) for entry in value]
    return value
