"""Tables of the identification report: coefficients beside the source's, fits, poles, residuals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from heli_common.linear_model import StateSpace
from heli_flight.identification import Identified
from heli_flight.identification_figures import shown
from heli_flight.page_tables import BAD, GOOD, NOTHING, SOFT, TEXT, Cell, Table, number, significant
from heli_identification.pole_uncertainty import uncertain_poles
from heli_identification.published_coefficients import published
from heli_identification.residual_tests import autocorrelation, cross_correlation
from heli_identification.structures import Structure
from heli_identification.uncertainty import QUANTILE_95

Complex = NDArray[np.complex128]

EXPECTED_OUTSIDE = 0.05
"""Share of correlations that white residuals have outside their 95 % bounds."""


def coefficient_table(found: Identified, prior: Structure | None) -> Table:
    """Every coefficient with its error, the prior's value and the source's.

    Args:
        found: identification.
        prior: the same structure with the values of a prior model.
    """
    estimate = found.estimate
    columns = published(estimate.structure.name)
    rows = []
    for index, parameter in enumerate(estimate.structure.parameters):
        name = parameter.name
        beside = [Cell(significant(float(prior.values[index]), 4))] if prior is not None else []
        printed = [Cell(_printed(column, name), SOFT) for column in columns.values()]
        if name not in estimate.names:
            told = [Cell("fixed", SOFT), Cell(NOTHING), Cell(NOTHING), Cell(NOTHING)]
        else:
            place = estimate.names.index(name)
            error, least = float(estimate.errors[place]), float(np.sqrt(estimate.fisher[place, place]))
            share = 100.0 * error / max(abs(parameter.value), 1e-300)
            low, high = estimate.intervals[place].tolist()
            told = [
                Cell(significant(error, 2)),
                Cell(f"{significant(low, 4)} … {significant(high, 4)}"),
                Cell(f"{share:.1f} %" if share < 1000.0 else "> 1000 %", BAD if share > 50.0 else ""),
                Cell(significant(least, 2)),
            ]
        value = Cell(significant(float(parameter.value), 5))
        rows.append((Cell(name), value, Cell(parameter.unit, TEXT), *told, *beside, *printed))
    header = ("coefficient", "value", "unit", "standard error", "95 % interval", "relative", "Cramér-Rao")
    titles = tuple(f"source: {title}" for title in columns)
    note = (
        "Standard errors by Fisher's information."
        if estimate.white
        else "Residuals are coloured: standard errors are the robust ones, over 1 s; the Cramér-Rao bound "
        "would hold for white ones."
    )
    return Table("", note, (*header, *(("prior",) if prior is not None else ()), *titles), tuple(rows))


def _printed(column: Mapping[str, float], name: str) -> str:
    return significant(column.get(name), 5)


def fit_table(found: Identified) -> Table:
    """Fit of every segment and of all."""
    fit = found.fit
    if fit is None:
        raise ValueError("nothing was validated")
    rows = [
        (Cell(str(index + 1)), *(Cell(number(value, 1)) for value in segment))
        for index, segment in enumerate(fit.segments.tolist())
    ]
    rows.append((Cell("all"), *(Cell(number(value, 1)) for value in fit.percent.tolist())))
    note = "100 (1 − |y − y_sim| / |y − mean y|) %, free simulation."
    return Table("Fit of every segment [%]", note, ("segment", *map(shown, fit.outputs)), tuple(rows))


def pole_table(found: Identified, prior: StateSpace | None) -> Table:
    """Poles with the half widths of their 95 % intervals, the prior's beside."""
    estimate = found.estimate
    poles = uncertain_poles(estimate.structure, estimate.covariance)
    half = QUANTILE_95 * np.sqrt(np.maximum(np.einsum("nii->ni", poles.covariance), 0.0))
    others = _matched(poles.values, prior)
    rows = []
    for index, pole in enumerate(poles.values.tolist()):
        if pole.imag < 0.0:
            continue
        imaginary = f"{number(pole.imag, 3)} ± {number(float(half[index, 1]), 3)}" if pole.imag else NOTHING
        beside = [Cell(_pole(others[index]))] if others else []
        real = Cell(f"{number(pole.real, 3)} ± {number(float(half[index, 0]), 3)}")
        rows.append((real, Cell(imaginary), Cell(number(abs(pole), 3)), *beside))
    header = ("real part [1/s]", "± imaginary part [1/s]", "magnitude [1/s]")
    return Table("", "", header + (("prior, nearest",) if others else ()), tuple(rows))


def _matched(poles: Complex, prior: StateSpace | None) -> list[complex]:
    """The prior pole nearest to each."""
    if prior is None:
        return []
    known: list[complex] = prior.poles.tolist()
    return [min(known, key=lambda other: abs(other - pole)) for pole in poles.tolist()]


def _pole(pole: complex) -> str:
    return f"{number(pole.real, 3)} ± {number(abs(pole.imag), 3)}i" if pole.imag else number(pole.real, 3)


def residual_table(found: Identified) -> Table:
    """Sizes of the residuals and what their tests say."""
    estimate, period = found.estimate, found.records[0].period
    residuals = np.vstack(estimate.residuals)
    inputs = np.vstack([r.u[: len(e)] for r, e in zip(found.records, estimate.residuals, strict=True)])
    own, cross = autocorrelation(residuals), cross_correlation(residuals, inputs)
    earlier = cross.lags > 0
    outside = np.mean(np.abs(cross.values[earlier]) > cross.bound, axis=0)
    rms = np.sqrt(np.mean(residuals**2, axis=0))
    rows = [
        (
            Cell(shown(output)),
            Cell(significant(float(rms[row]), 3)),
            _share(float(own.outside[row])),
            *(_share(float(share)) for share in outside[row]),
        )
        for row, output in enumerate(estimate.structure.outputs)
    ]
    header = (
        "output",
        "rms, SI",
        "autocorrelations outside",
        *(f"with {shown(name)} outside" for name in estimate.structure.inputs),
    )
    note = f"Of the lags to {25 * period:g} s, of inputs the earlier ones; white residuals have 5 % outside."
    return Table("", note, header, tuple(rows))


def _share(share: float) -> Cell:
    return Cell(f"{100.0 * share:.0f} %", GOOD if share <= 2.0 * EXPECTED_OUTSIDE else BAD)


def weak_lines(found: Identified) -> Sequence[str]:
    """What the data do not tell, in words."""
    return [
        f"{', '.join(each.names)}: {each.reason} (relative error "
        f"{'infinite' if not np.isfinite(each.deviation) else significant(each.deviation, 2)})"
        for each in found.estimate.weak
    ]
