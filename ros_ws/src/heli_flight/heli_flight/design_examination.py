"""What the design report says beside the controllers: plants, S/KS/T, the trade-off, static gains."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from heli_common.model_file import ModelFile
from heli_control.controller_designs import DesignSummary
from heli_control.flight_plants import FLIGHT_AXES, flight_plant
from heli_control.published_gains import GAIN_TABLES
from heli_control.realisation import response
from heli_control.skst_examination import rank_cases, slow_poles
from heli_control.system_properties import modes, transmission_zeros
from heli_control.trade_off import attitude_sweep
from heli_control.weights_file import read_weights
from heli_flight.design_metrics import WeightsFolder, finite, pair


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
                    "pole": pair(mode.pole),
                    "controllability": mode.controllability,
                    "observability": mode.observability,
                }
                for mode in modes(plant.scaled)
            ],
            "transmission_zeros": [pair(zero) for zero in transmission_zeros(plant.scaled)],
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
                "pole": pair(slow.cancellation.pole),
                "zero": pair(slow.cancellation.zero),
                "zero_apart": finite(slow.cancellation.distance),
                "hidden": slow.cancellation.hidden,
                "closed": pair(slow.closed),
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
        {"factor": one.factor, "gamma_min": finite(one.gamma), "refused": one.refused, **one.figures}
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
