"""Test signals on the 100 Hz grid, each of peak 1: patterns, chirp, PRBS, noise, multisine (source 2.5, 2.6).

Every function gives the whole signal at once, and the same one for the same arguments. Those with a band have
no power outside it by construction, except where their text says otherwise.
"""

from __future__ import annotations

from math import log, pi

import numpy as np
from numpy.typing import NDArray

from heli_common.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Band = tuple[float, float]
"""Lowest and highest angular frequency [rad/s]."""

PATTERNS: dict[str, tuple[float, ...]] = {
    "steps": (1, 0, -1, 0),
    "doublets": (1, -1, 0, 0),
    "3-2-1-1": (1, 1, 1, -1, -1, 1, -1, 0, 0, 0, -1, -1, -1, 1, 1, -1, 1, 0, 0, 0),
}
"""Levels, each held for the hold time; every pattern has mean 0."""

RAMPS = (0.0, 1.0, 0.0, -1.0, 0.0)
"""Corners of the triangle, a hold time apart."""

LONGEST_PERIOD = 20.0
"""Of a multisine [s]: a minute holds three periods, and what differs between them is noise (D)."""

HALF_POWER = 2.783
"""Clock period of a random binary signal times the frequency at which its power has fallen to one half."""

FEWEST_BITS, MOST_BITS = 3, 12


def pattern(levels: tuple[float, ...], count: int, hold: int) -> Array:
    """Levels held one after the other, as often as all of them fit; then 0.

    Args:
        levels: of one pattern.
        count: samples.
        hold: samples of each level.

    Returns:
        (count,)
    """
    once = np.repeat(np.asarray(levels, dtype=np.float64), hold)
    signal = np.zeros(count)
    whole = count // once.size * once.size
    signal[:whole] = np.tile(once, whole // once.size)
    return signal


def ramps(count: int, hold: int) -> Array:
    """Triangles up, down, up, each leg one or two hold times long, as often as all fit; then 0.

    Args:
        count: samples.
        hold: samples from 0 to 1.

    Returns:
        (count,)
    """
    corners = hold * np.arange(len(RAMPS))
    once = np.interp(np.arange(corners[-1]), corners, RAMPS)
    return pattern(tuple(once.tolist()), count, 1)


def chirp(count: int, band: Band) -> Array:
    """A sine whose frequency grows exponentially over the band; its ends leak a little beyond it.

    Args:
        count: samples.
        band: it sweeps over.

    Returns:
        (count,)
    """
    low, high = band
    growth = log(high / low) / count
    phase = low * CONTROL_PERIOD / growth * np.expm1(growth * np.arange(count))
    return np.asarray(np.sin(phase))


def noise(count: int, band: Band, rng: np.random.Generator) -> Array:
    """Gaussian noise with equal power at every frequency of the band, none outside, mean 0.

    Args:
        count: samples; the signal repeats after them.
        band: that holds all power.
        rng: of amplitudes and phases.

    Returns:
        (count,) of peak 1.
    """
    lines = _lines(count, band)
    spectrum = np.zeros(count // 2 + 1, dtype=np.complex128)
    spectrum[lines] = rng.standard_normal(lines.size) + 1j * rng.standard_normal(lines.size)
    return _peak_one(np.fft.irfft(spectrum, count))


def multisine(count: int, band: Band, rng: np.random.Generator, place: int = 0, of: int = 1) -> Array:
    """Sines of equal amplitude with Schroeder's phases, so of low crest factor, mean 0 over each period.

    Several channels share the lines in turn, so that they are orthogonal over each period.

    Args:
        count: samples.
        band: that holds all lines.
        rng: of the place in the period at which the signal begins.
        place: of this channel, from 0.
        of: channels.

    Returns:
        (count,) of peak 1.
    """
    period = multisine_period(count)
    lines = _lines(period, band)[place::of]
    order = np.arange(lines.size)
    spectrum = np.zeros(period // 2 + 1, dtype=np.complex128)
    spectrum[lines] = np.exp(-1j * pi * order * (order + 1) / max(1, lines.size))
    once = _peak_one(np.fft.irfft(spectrum, period))
    start = int(rng.integers(period))
    return np.asarray(once[(start + np.arange(count)) % period])


def multisine_period(count: int) -> int:
    """Samples of one period of a multisine of so many samples."""
    longest = round(LONGEST_PERIOD / CONTROL_PERIOD)
    return count // -(-count // longest)


def prbs(count: int, band: Band, rng: np.random.Generator) -> Array:
    """Pseudo-random binary signal of a shift register of greatest period; mean 0 over each period.

    Its lines begin at the lower end of the band. At the upper end their power has fallen to one half; a
    two-valued signal cannot be limited harder. The levels are -1 and (N - 1)/(N + 1), with N the length of
    the register's period: that makes the mean 0.

    Args:
        count: samples.
        band: of its power.
        rng: of the register's feedback and of the place in the period at which the signal begins.

    Returns:
        (count,) of peak 1.
    """
    clock, bits = prbs_clock(band), prbs_bits(band)
    length = 2**bits - 1
    ones = _register(bits, rng)
    levels = np.where(ones, (length - 1) / (length + 1), -1.0)
    start = int(rng.integers(length * clock))
    return np.asarray(levels[(start + np.arange(count)) // clock % length])


def prbs_clock(band: Band) -> int:
    """Samples for which a PRBS keeps its value at least."""
    return max(1, round(HALF_POWER / band[1] / CONTROL_PERIOD))


def prbs_bits(band: Band) -> int:
    """Bits of the longest register whose lines stay above the lower end of the band; 0 if there is none."""
    longest = 2.0 * pi / band[0] / (prbs_clock(band) * CONTROL_PERIOD)
    fitting = [bits for bits in range(FEWEST_BITS, MOST_BITS + 1) if 2**bits - 1 <= longest]
    return fitting[-1] if fitting else 0


def fade(count: int, edge: int) -> Array:
    """Raised cosine from 0 to 1 over `edge` samples at the start and back at the end.

    Returns:
        (count,)
    """
    from_end = np.minimum(np.arange(count), np.arange(count)[::-1])
    share = np.clip((from_end + 0.5) / max(edge, 1), 0.0, 1.0) if edge else np.ones(count)
    return np.asarray(0.5 - 0.5 * np.cos(pi * share))


def line_count(count: int, band: Band) -> int:
    """Harmonics of a period of so many samples inside a band."""
    return int(_lines(count, band).size)


def _lines(period: int, band: Band) -> NDArray[np.int64]:
    """Harmonics of a period of so many samples that lie in the band, the ends included."""
    spacing = 2.0 * pi / (period * CONTROL_PERIOD)
    first = max(1, int(np.ceil(band[0] / spacing - 1e-9)))
    last = min((period - 1) // 2, int(np.floor(band[1] / spacing + 1e-9)))
    return np.arange(first, last + 1)


def _peak_one(signal: Array) -> Array:
    return np.asarray(signal / np.max(np.abs(signal)))


def _register(bits: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """One period of a shift register; its feedback is drawn until the period is the greatest there is."""
    length = 2**bits - 1
    while True:
        feedback = 2 * int(rng.integers(2 ** (bits - 1))) + 1
        state, output = 1, []
        for _ in range(length):
            output.append(bool(state & 1))
            state = (state >> 1) | ((state & feedback).bit_count() % 2 << (bits - 1))
            if state == 1:
                break
        if len(output) == length:
            return np.array(output)
