"""From an estimate to the model file that control design reads, with everything that is known about it.

The identified block replaces that of the prior model file; what the flight does not tell (the other block,
the rest of the operating point) comes from the prior, and `source` says which is which.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heli_common.linear_model import OperatingPoint
from heli_common.model_file import ModelFile
from heli_identification.helicopter_structures import BAR_GAIN, SERVO_ROTOR, VERTICAL
from heli_identification.prediction_error import Estimate
from heli_identification.records import Record, data_hash
from heli_identification.residual_tests import autocorrelation, cross_correlation
from heli_identification.structures import Structure
from heli_identification.validation import Fit

Array = NDArray[np.float64]

SOURCE_TRIM = OperatingPoint(
    theta_0=0.16911,
    theta_t=0.19459,
    phi=-0.09440,
    theta=-0.00693,
    B_1s=0.00653,
    A_1s=0.00050,
    a_1p=0.00927,
    b_1p=0.00071,
    V_i=4.222,
    V_t=6.337,
    M_A=0.821,
    U_mot=5.54,
    I_motor=54.7,
    Omega=163.363,
)
"""Hover of the rebuilt model (spec 1.5), for what no flight and no prior tells."""


def block_of(structure: Structure) -> str:
    """The block of a model file that a structure describes."""
    if "U_mot" in structure.inputs:
        return "drive"
    return "horizontal" if "B_1s" in structure.inputs else "vertical"


def prior_model() -> ModelFile:
    """Structures of the source with its linearised coefficients, at the rebuilt model's hover."""
    return ModelFile(
        name="prior",
        source={"method": "prior values of the structures (source Table 2.6, spec 1.5)"},
        operating_point=SOURCE_TRIM,
        horizontal=SERVO_ROTOR.model(),
        vertical=VERTICAL.model(),
    )


def identified_model(
    name: str,
    estimate: Estimate,
    records: Sequence[Record],
    means: Mapping[str, float],
    *,
    prior: ModelFile | None = None,
    remarks: Mapping[str, Any] | None = None,
    fit: Fit | None = None,
) -> ModelFile:
    """The model file of an estimate.

    Args:
        name: of the model, one word.
        estimate: of a structure.
        records: it was estimated from.
        means: of inputs and outputs over the flight, absolute: the operating point that was flown.
        prior: for everything else.
        remarks: more provenance, plain values.
        fit: on validation data.
    """
    base = prior or prior_model()
    block = block_of(estimate.structure)
    model = estimate.structure.model()
    rest = [key for key in ("horizontal", "vertical", "drive") if key != block]
    source: dict[str, Any] = {
        "method": "identified",
        **dict(remarks or {}),
        "identified": {block: described(estimate, records, fit)},
        "prior": {"name": base.name, "plant_hash": base.plant_hash, "blocks": rest},
    }
    earlier = base.source.get("identified")
    if isinstance(earlier, Mapping):
        source["identified"] = {**earlier, **source["identified"]}
    return ModelFile(
        name=name,
        source=source,
        operating_point=operating_point(base.operating_point, means),
        horizontal=model if block == "horizontal" else base.horizontal,
        vertical=model if block == "vertical" else base.vertical,
        drive=model if block == "drive" else base.drive,
    )


def operating_point(known: OperatingPoint, means: Mapping[str, float]) -> OperatingPoint:
    """The operating point with what the flight tells; the servo rotor follows the swash plate.

    Args:
        known: what stays where the flight is silent.
        means: absolute, by signal name; velocities and rates do not count.
    """
    fields = asdict(known)
    told = {key: float(value) for key, value in means.items() if key in fields}
    for flapping, cyclic in (("a_1p", "B_1s"), ("b_1p", "A_1s")):
        if cyclic in told:
            told[flapping] = BAR_GAIN * told[cyclic]
    return replace(known, **told)


def described(estimate: Estimate, records: Sequence[Record], fit: Fit | None) -> dict[str, Any]:
    """An estimate as plain values for a file or for JSON.

    Args:
        estimate: of a structure.
        records: it was estimated from.
        fit: on validation data.
    """
    structure, intervals = estimate.structure, estimate.intervals
    coefficients: dict[str, Any] = {}
    for parameter in structure.parameters:
        entry: dict[str, Any] = {"value": float(parameter.value), "unit": parameter.unit}
        if parameter.name in estimate.names:
            index = estimate.names.index(parameter.name)
            entry["standard_error"] = number(estimate.errors[index])
            entry["interval_95"] = [number(bound) for bound in intervals[index]]
            entry["cramer_rao"] = number(np.sqrt(estimate.fisher[index, index]))
        else:
            entry["fixed"] = parameter.reason or "not freed"
        coefficients[parameter.name] = entry
    residuals = np.vstack(estimate.residuals)
    inputs = np.vstack(
        [record.u[: len(part)] for record, part in zip(records, estimate.residuals, strict=True)]
    )
    found: dict[str, Any] = {
        "structure": structure.name,
        "noise_model": estimate.noise.value,
        "parameters": coefficients,
        "correlations": {
            "names": list(estimate.names),
            "matrix": np.round(estimate.correlations, 4).tolist(),
        },
        "noise": {
            name: float(value)
            for name, value in zip(estimate.noise_names, estimate.noise_values, strict=True)
        },
        "residuals": {
            "white": estimate.white,
            "standard_errors": "Fisher information" if estimate.white else "robust to coloured residuals",
            "rms": [float(value) for value in np.sqrt(np.mean(residuals**2, axis=0))],
            "autocorrelations_outside": autocorrelation(residuals).outside.tolist(),
            "input_correlations_outside": cross_correlation(residuals, inputs).outside.tolist(),
        },
        "not_identified": [
            {"parameters": list(each.names), "relative_error": number(each.deviation), "reason": each.reason}
            for each in estimate.weak
        ],
        "converged": estimate.converged,
        "steps": len(estimate.steps),
        "data": {
            "sha256": data_hash(records),
            "records": [record.name for record in records],
            "seconds": float(sum(record.duration for record in records)),
            "sample_time_s": float(records[0].period),
        },
    }
    if fit is not None:
        found["validation_fit_percent"] = {
            name: float(value) for name, value in zip(fit.outputs, fit.percent, strict=True)
        }
        found["validation_segments"] = len(fit.segments)
    return found


def number(value: float) -> float | str:
    """A float that YAML and JSON can hold; infinite in words."""
    return float(value) if np.isfinite(value) else "infinite"
