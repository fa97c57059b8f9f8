"""H-infinity synthesis by the library: SLICOT's SB10AD through slycot, as `control.hinfsyn` calls it.

The routine may return a gamma its closed loop does not have, without an error (spec 0.4). What comes from
here is a proposal; `certified` decides. slycot is optional: without it this route refuses and says so.
"""

from __future__ import annotations

import math
import os
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from heli_control.certificate import AGREEMENT
from heli_control.generalized_plant import GeneralizedPlant, lower_lft
from heli_control.hinf_norm import hinf_norm
from heli_control.realisation import Realisation
from heli_control.riccati_synthesis import NO_OPTIMUM, NoController

_BISECTION, _SUBOPTIMAL = 1, 4
_STARTS = (1e4, 1e6, 1e8)
_NOTHING = 1e-8
_LEVEL = 1e3
_MEANING = {
    1: "[A - jw, B2; C1, D12] loses rank (A5)",
    2: "[A - jw, B1; C2, D21] loses rank (A5)",
    3: "D12 has no full column rank (A3)",
    4: "D21 has no full row rank (A4)",
    6: "gamma is too small",
    7: "the X equation was not solved",
    8: "the Y equation was not solved",
    12: "no stabilising controller was found",
}


def available() -> bool:
    """Whether slycot is installed."""
    try:
        _slycot()
    except ImportError:
        return False
    return True


def _slycot() -> Any:
    # slycot brings a BLAS of its own; its threads only get in the way of numpy's on matrices this small
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    return import_module("slycot")


def library_gamma(plant: GeneralizedPlant, tolerance: float = 2e-5) -> float:
    """The smallest gamma of the library's controllers: its own bisection, checked at its end.

    Args:
        plant: that meets A1 to A5.
        tolerance: relative.

    Raises:
        NoController: slycot is missing, or SB10AD reports a failure for every gamma to start from.
    """
    problem = NoController("not tried")
    for start in _STARTS:
        try:
            found = float(_sb10ad(plant, start, _BISECTION, tolerance)[0])
        except NoController as error:
            problem = error
            if error.final:
                break
            continue
        if found < _NOTHING * start:
            raise NoController(NO_OPTIMUM, final=True)
        return _verified(plant, found, tolerance)
    raise problem


def _verified(plant: GeneralizedPlant, found: float, tolerance: float) -> float:
    """The level found, if the library's controller there has it as its norm; else by bisection on that norm.

    SB10AD's own bisection was seen to stop far above the optimum and below it.
    """
    level = (1.0 + 0.5 * AGREEMENT) * found
    norm = _norm(plant, level)
    below = (1.0 - AGREEMENT) * found
    if norm <= (1.0 + AGREEMENT) * level and _norm(plant, below) > (1.0 + 0.1 * AGREEMENT) * below:
        return found
    low, high = (0.0, min(norm, found)) if norm <= (1.0 + AGREEMENT) * level else (found, 1.3 * found)
    while _norm(plant, high) > (1.0 + 0.1 * AGREEMENT) * high:
        low, high = high, 1.3 * high
        if high > max(_STARTS):
            raise NoController(f"SB10AD has no controller that keeps its gamma up to {max(_STARTS):g}")
    while high - low > tolerance * high:
        middle = math.sqrt(low * high) if low > 0.0 else 0.5 * high
        norm = _norm(plant, middle)
        if norm > (1.0 + 0.1 * AGREEMENT) * middle:
            low = middle
        else:
            high = min(middle, norm) if norm > low else middle
        if high < _NOTHING * found:
            raise NoController(NO_OPTIMUM, final=True)
    return high


def _norm(plant: GeneralizedPlant, gamma: float) -> float:
    """Of the closed loop with the library's controller for gamma; infinite where it has none."""
    try:
        return hinf_norm(lower_lft(plant, library_controller(plant, gamma)), 1e-5).value
    except (ValueError, np.linalg.LinAlgError):
        return math.inf


def library_controller(plant: GeneralizedPlant, gamma: float) -> Realisation:
    """The library's controller of a given gamma, u = K y.

    Raises:
        NoController: slycot is missing, or SB10AD reports a failure.
    """
    # errors scaled: for some sizes SB10AD was seen to refuse every gamma below 67, whatever the plant
    scale = _LEVEL / gamma
    given = replace(plant, C1=scale * plant.C1, D11=scale * plant.D11, D12=scale * plant.D12)
    a, b, c, d = _sb10ad(given, _LEVEL, _SUBOPTIMAL, 0.0)[1:5]
    matrices = tuple(np.array(matrix, dtype=np.float64) for matrix in (a, b, c, d))
    if not all(np.isfinite(matrix).all() for matrix in matrices):
        raise NoController("SB10AD returned numbers that are not finite")
    return Realisation(*matrices)


def _sb10ad(plant: GeneralizedPlant, gamma: float, job: int, tolerance: float) -> Any:
    try:
        slycot = _slycot()
    except ImportError:
        raise NoController("slycot is not installed", final=True) from None
    system = plant.whole
    if not system.order:
        raise NoController("SB10AD takes no plant without states", final=True)
    inputs, outputs = system.B.shape[1], system.C.shape[0]
    _, controls, _, measurements = plant.sizes
    try:
        return slycot.sb10ad(
            system.order, inputs, outputs, controls, measurements, gamma, *system, job=job, gtol=tolerance
        )
    except slycot.exceptions.SlycotError as error:
        info = getattr(error, "info", 0)
        raise NoController(f"SB10AD: {_MEANING.get(info, 'failed')} (info {info})") from None
