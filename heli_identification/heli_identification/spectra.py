"""Frequency responses from data alone: Welch's method with the external signal as instrument.

With the external signal r the response is S_yr S_ur^-1, all inputs at once, which feedback does not bias (L.
Ljung, 1999, sec. 13.5); without one it is S_yu S_uu^-1, which feedback does bias.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import csd

from heli_common.errors import InputError
from heli_identification.records import Record

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Spectral estimate of all paths.

    Attributes:
        frequencies: [rad/s], shape (f,).
        values: responses, shape (f, p, m).
        coherence: share of each output's power that the external signals explain, 0 .. 1, shape (f, p).
        deviation: standard deviation of the complex value, shape (f, p, m).
        external: whether an external signal was the instrument.
    """

    frequencies: Array
    values: ComplexArray
    coherence: Array
    deviation: Array
    external: bool


def spectrum(record: Record, length: float = 5.12) -> Spectrum:
    """Spectral estimate of the responses from all inputs to all outputs.

    Args:
        record: data.
        length: of a window [s].

    Raises:
        InputError: fewer than three windows.
    """
    window = round(length / record.period)
    if len(record) < 3 * window:
        raise InputError(
            f"{record.duration:.1f} s of data", allowed=f"at least {3 * length:g} s", key="spectrum"
        )
    external = record.r is not None and bool(np.all(np.ptp(record.r, axis=0) > 0.0))
    r = record.r if external and record.r is not None else record.u
    frequencies, own = _cross(r, r, record.period, window)
    _, into = _cross(record.u, r, record.period, window)
    _, through = _cross(record.y, r, record.period, window)
    _, power = _cross(record.y, record.y, record.period, window)
    inverse = np.linalg.pinv(into)
    values = through @ inverse
    explained = np.einsum("fpr,frs,fps->fp", through, np.linalg.pinv(own), through.conj()).real
    whole = np.maximum(np.einsum("fpp->fp", power).real, 1e-300)
    share = np.clip(explained / whole, 0.0, 1.0)
    averages = 2.0 * len(record) / window - 1.0
    # what the response leaves of the output: y - G u, whose correlation with r is the error of S_yr
    _, mixed = _cross(record.y, record.u, record.period, window)
    _, moved = _cross(record.u, record.u, record.period, window)
    left = (
        whole
        - 2.0 * np.einsum("fpm,fpm->fp", mixed, values.conj()).real
        + np.einsum("fpm,fmn,fpn->fp", values, moved, values.conj()).real
    )
    noise = np.maximum(left, 0.0) / averages
    spread = np.einsum("frm,frs,fsm->fm", inverse, own, inverse.conj()).real
    deviation = np.sqrt(np.maximum(noise[:, :, None] * spread[:, None, :], 0.0))
    return Spectrum(frequencies, values, share, deviation, external)


def _cross(left: Array, right: Array, period: float, window: int) -> tuple[Array, ComplexArray]:
    """Frequencies without zero [rad/s], shape (f,), and E left right*, shape (f, left, right)."""
    frequencies, found = csd(right.T[None, :, :], left.T[:, None, :], fs=1.0 / period, nperseg=window)
    return 2.0 * np.pi * frequencies[1:], np.moveaxis(found[..., 1:], -1, 0)
