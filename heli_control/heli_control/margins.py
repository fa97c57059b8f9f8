"""Stability margins of a loop from its frequency response, continuous or sampled (spec 3.6).

L is the loop for negative feedback, stable when closed; the response of a sampled loop is taken on the unit
circle and nothing else changes. With S = (I + L)^-1 and T = I - S:

    channel i, the others closed    L_i = 1 / S_ii - 1
    all channels by one factor      the eigenvalues of L, each like a scalar loop
    disk margin                     alpha = 1 / max mu((S - T) / 2)       (Seiler, Packard, Gahinet 2020)

A disk margin alpha bears in every channel at once any gain from (2 - alpha)/(2 + alpha) to its inverse, or
any phase up to 2 atan(alpha / 2). mu of independent channels is bounded from above by the largest singular
value of D (S - T)/2 D^-1, D diagonal: exact for two channels, where the best D has a closed form; for more it
is searched for, and alpha may come out some percent too small, never too large.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from heli_control.loop_analysis import crossovers, sensitivity_peaks

Array = NDArray[np.float64]
Response = NDArray[np.complex128]

S_LIMIT_DB, T_LIMIT_DB = 6.0, 2.0
"""Largest |S| and |T| that spec 3.6 allows."""

_SCALING_ROUNDS, _SCALING_STEPS, _SCALING_RANGE = 3, 20, 8.0
_AT_REST, _AT_NYQUIST = 0.03, 1e-9
"""An end of the frequencies counts as real when the imaginary part is below this share: at rest only nearly
so, because zero itself is often a pole."""

_ROUNDING = 1e-9
"""Spectral radius and norm of a scalar are the same but for rounding."""

_TURN = 2.0 * math.pi
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclass(frozen=True)
class ScalarMargins:
    """Margins of a scalar loop; infinite where no frequency seen limits them.

    Attributes:
        gain_up_db: factor that the gain may rise by [dB].
        gain_down_db: factor that it may fall by [dB], positive.
        phase_deg: phase that may be lost or gained [deg].
        delay_ms: dead time that may be added [ms].
        crossovers: where the magnitude crosses 0 dB [rad/s], ascending.
    """

    gain_up_db: float
    gain_down_db: float
    phase_deg: float
    delay_ms: float
    crossovers: tuple[float, ...]


@dataclass(frozen=True)
class DiskMargin:
    """Gain and phase that may change at once in every channel.

    Attributes:
        alpha: size of the disk, 0 .. 2 and more.
        frequency: where it is smallest [rad/s].
        gain_db: gain up or down guaranteed [dB]; infinite from alpha = 2 on.
        phase_deg: phase guaranteed [deg].
    """

    alpha: float
    frequency: float
    gain_db: float
    phase_deg: float


@dataclass(frozen=True)
class LoopMargins:
    """Everything of one loop.

    Attributes:
        channels: of each channel with the others closed, by name.
        channel_disks: disk margin of each such channel.
        uniform: all channels changed by the same factor, phase or dead time.
        disk: all channels changed independently.
        peak_S_db: largest singular value of S [dB]; at `frequency_S` [rad/s].
        peak_T_db: largest singular value of T [dB]; at `frequency_T` [rad/s].
    """

    channels: dict[str, ScalarMargins]
    channel_disks: dict[str, DiskMargin]
    uniform: ScalarMargins
    disk: DiskMargin
    peak_S_db: float
    frequency_S: float
    peak_T_db: float
    frequency_T: float

    @property
    def within_limits(self) -> bool:
        """Whether |S| and |T| keep the limits of spec 3.6."""
        return self.peak_S_db <= S_LIMIT_DB and self.peak_T_db <= T_LIMIT_DB


def loop_margins(loop: Response, omega: Array, names: tuple[str, ...]) -> LoopMargins:
    """All margins of a square loop that is stable when closed.

    Args:
        loop: L for negative feedback, shape (k, m, m).
        omega: ascending [rad/s], shape (k,); fine enough for what is between to be straight.
        names: of the m channels.

    Raises:
        ValueError: shapes that do not belong together.
    """
    k, m = len(omega), len(names)
    if loop.shape != (k, m, m):
        raise ValueError(f"loop of shape {loop.shape}; allowed: {(k, m, m)}")
    opened = channel_loops(loop)
    sensitivity = _sensitivity(loop)
    peaks = []
    for response in (sensitivity, np.eye(m) - sensitivity):
        peaks.append(float(omega[np.argmax(np.linalg.svd(response, compute_uv=False)[:, 0])]))
    peak_s, peak_t = sensitivity_peaks(loop)
    return LoopMargins(
        channels={name: scalar_margins(opened[:, i], omega) for i, name in enumerate(names)},
        channel_disks={name: disk_margin(opened[:, i, None, None], omega) for i, name in enumerate(names)},
        uniform=uniform_margins(loop, omega),
        disk=disk_margin(loop, omega),
        peak_S_db=peak_s,
        frequency_S=peaks[0],
        peak_T_db=peak_t,
        frequency_T=peaks[1],
    )


def loops(plant: Response, controller: Response) -> tuple[Response, Response]:
    """L at the plant's input, shape (k, m, m), and at its output, (k, p, p), for negative feedback.

    Args:
        plant: G, shape (k, p, m).
        controller: u = K y, the minus sign of the feedback included, shape (k, m, p).
    """
    return -np.matmul(controller, plant), -np.matmul(plant, controller)


def channel_loops(loop: Response) -> Response:
    """Each channel's scalar loop with all others closed, shape (k, m), from L of shape (k, m, m)."""
    diagonal = np.diagonal(_sensitivity(loop), axis1=1, axis2=2)
    return np.asarray(1.0 / diagonal - 1.0, dtype=np.complex128)


def scalar_margins(loop: Response, omega: Array) -> ScalarMargins:
    """Margins of a scalar loop that is stable when closed.

    Args:
        loop: L for negative feedback, shape (k,).
        omega: ascending [rad/s], shape (k,).
    """
    loop = np.where(loop == 0.0, np.finfo(float).tiny, loop)
    levels, met = _real_axis_levels(loop), _phases_at_crossover(loop, omega)
    return ScalarMargins(
        gain_up_db=min((-level for level in levels if level < 0.0), default=math.inf),
        gain_down_db=min((level for level in levels if level > 0.0), default=math.inf),
        phase_deg=min((math.degrees(min(phase, _TURN - phase)) for _, phase in met), default=math.inf),
        delay_ms=min((1e3 * phase / frequency for frequency, phase in met), default=math.inf),
        crossovers=tuple(crossovers(loop, omega)),
    )


def uniform_margins(loop: Response, omega: Array) -> ScalarMargins:
    """Margins when all channels change alike: those of the eigenvalues of L, worst of all.

    Args:
        loop: L for negative feedback, shape (k, m, m), stable when closed.
        omega: ascending [rad/s], shape (k,).
    """
    each = [scalar_margins(locus, omega) for locus in eigenvalue_loci(loop).T]
    return ScalarMargins(
        min(one.gain_up_db for one in each),
        min(one.gain_down_db for one in each),
        min(one.phase_deg for one in each),
        min(one.delay_ms for one in each),
        tuple(sorted(frequency for one in each for frequency in one.crossovers)),
    )


def eigenvalue_loci(loop: Response) -> Response:
    """Eigenvalues of L over frequency, shape (k, m), each column continuous."""
    loci = np.asarray(np.linalg.eigvals(loop), dtype=np.complex128)
    for index in range(1, len(loci)):
        apart = np.abs(loci[index - 1][:, None] - loci[index][None, :])
        loci[index] = loci[index][linear_sum_assignment(apart)[1]]
    return loci


def disk_margin(loop: Response, omega: Array) -> DiskMargin:
    """The balanced disk margin of a loop that is stable when closed.

    Args:
        loop: L for negative feedback, shape (k, m, m).
        omega: [rad/s], shape (k,).
    """
    half = _sensitivity(loop) - 0.5 * np.eye(loop.shape[1])
    # mu lies between spectral radius and norm: scale only where it may be the largest
    surely = np.abs(np.linalg.eigvals(half)).max(axis=1)
    near = np.flatnonzero(np.linalg.norm(half, 2, axis=(1, 2)) >= (1.0 - _ROUNDING) * surely.max())
    alpha = disk_sizes(loop[near])
    worst = int(near[np.argmin(alpha)])
    size = float(alpha.min())
    gain = math.inf if size >= 2.0 else 20.0 * math.log10((2.0 + size) / (2.0 - size))
    return DiskMargin(size, float(omega[worst]), gain, 2.0 * math.degrees(math.atan(0.5 * size)))


def disk_sizes(loop: Response) -> Array:
    """alpha at every frequency, shape (k,), of L of shape (k, m, m)."""
    half = _sensitivity(loop) - 0.5 * np.eye(loop.shape[1])
    return np.asarray(1.0 / np.maximum(_scaled_norm(half), np.finfo(float).tiny), dtype=np.float64)


def _scaled_norm(matrices: Response) -> Array:
    """Smallest over diagonal D of the largest singular value of D M D^-1."""
    k, m = matrices.shape[:2]
    logs: Array = np.zeros((k, m))
    if m == 2:
        # D leaves |det| and the diagonal; b and c are best when they are of one size
        size = np.abs(matrices)
        frobenius = size[:, 0, 0] ** 2 + size[:, 1, 1] ** 2 + 2.0 * size[:, 0, 1] * size[:, 1, 0]
        rest = frobenius**2 - 4.0 * np.abs(np.linalg.det(matrices)) ** 2
        return np.asarray(np.sqrt(0.5 * (frobenius + np.sqrt(np.maximum(rest, 0.0)))), dtype=np.float64)
    best = _largest(matrices, logs)
    for _ in range(_SCALING_ROUNDS):
        for channel in range(1, m):
            tried = _with(logs, channel, _line_search(matrices, logs, channel))
            norm = _largest(matrices, tried)
            logs = np.asarray(np.where((norm < best)[:, None], tried, logs), dtype=np.float64)
            best = np.minimum(norm, best)
    return best


def _line_search(matrices: Response, logs: Array, channel: int) -> Array:
    """The best log D of one channel by golden section; the norm is convex in it."""
    low, high = logs[:, channel] - _SCALING_RANGE, logs[:, channel] + _SCALING_RANGE
    for _ in range(_SCALING_STEPS):
        span = _GOLDEN * (high - low)
        left, right = high - span, low + span
        nearer = _largest(matrices, _with(logs, channel, left)) < _largest(
            matrices, _with(logs, channel, right)
        )
        low, high = np.where(nearer, low, left), np.where(nearer, right, high)
    return np.asarray(0.5 * (low + high), dtype=np.float64)


def _with(logs: Array, channel: int, values: Array) -> Array:
    changed = logs.copy()
    changed[:, channel] = values
    return changed


def _largest(matrices: Response, logs: Array) -> Array:
    scaled = matrices * np.exp(logs[:, :, None] - logs[:, None, :])
    return np.asarray(np.linalg.norm(scaled, 2, axis=(1, 2)), dtype=np.float64)


def _sensitivity(loop: Response) -> Response:
    return np.asarray(np.linalg.inv(np.eye(loop.shape[1]) + loop), dtype=np.complex128)


def _real_axis_levels(loop: Response) -> list[float]:
    """|L| in dB wherever L crosses the negative real axis; at rest and at Nyquist's frequency it does too."""
    imaginary = loop.imag
    ends = [(0, _AT_REST), (-1, _AT_NYQUIST)]
    found = [
        20.0 * math.log10(abs(loop[end]))
        for end, share in ends
        if loop[end].real < 0.0 and abs(loop[end].imag) <= share * abs(loop[end].real)
    ]
    for index in np.flatnonzero(np.sign(imaginary[:-1]) * np.sign(imaginary[1:]) < 0.0):
        share = imaginary[index] / (imaginary[index] - imaginary[index + 1])
        real = float(loop.real[index] + share * (loop.real[index + 1] - loop.real[index]))
        if real < 0.0:
            found.append(20.0 * math.log10(-real))
    return found


def _phases_at_crossover(loop: Response, omega: Array) -> list[tuple[float, float]]:
    """Frequency [rad/s], and phase above -180 deg [rad], 0 .. 2 pi, wherever |L| crosses 1."""
    level, found = np.log(np.abs(loop)), []
    for index in np.flatnonzero(np.sign(level[:-1]) * np.sign(level[1:]) < 0.0):
        share = float(level[index] / (level[index] - level[index + 1]))
        frequency = float(omega[index] * (omega[index + 1] / omega[index]) ** share)
        turned = float(np.angle(loop[index + 1] / loop[index]))
        phase = float(np.angle(-loop[index])) + share * turned
        found.append((frequency, phase % _TURN))
    return found
