"""Innovation gates, and who is believed when a sensor and the filter disagree.

A reading further from what is expected than `gate` deviations is not used, and its encoder is doubted: three
lines in a row outside the gate, or no line passed although the filter has long been beyond one. Then either
the encoder has failed or the IMU has: a gyro's bias has jumped under an axis of the gimbal, an
accelerometer's under the arms. What the encoder does next decides, and until then its cell is not used:

- A line says that it is alive, so it was the IMU, and a jump of its bias is allowed for. Several arms in
  doubt together say so at once.
- A second of silence in flight says that it is stuck, and it is lost: no longer used. At the stop silence is
  no wonder and the encoder is believed.
- A jump by three counts within a sample is none of the helicopter's: the encoder has lost counts.

Of the three arms one may be lost; after that, and if nothing fits any more, the filter is begun anew.

A lost encoder is believed again when it comes back with a jump that brings it near to where it should be, as
one does that was stuck; or after ten lines in a row none of which was further off than one count. One that
has lost counts does neither.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled
from heli_navigation.error_covariance import widen
from heli_navigation.filter_memory import ARMS, ENCODERS, SIZE, Estimate, Memory, Work
from heli_navigation.filter_parameters import FilterConstants

Array = NDArray[np.float64]

_DOUBT, _LOST, _AGREED = int(Memory.doubt), int(Memory.lost), int(Memory.agreed)
_JUMPS, _SILENT = int(Memory.jumps), int(Memory.silent)
_COVARIANCE = int(Memory.covariance)
_RATES = int(Work.rates)
_P, _V, _E = int(Estimate.position), int(Estimate.velocity), int(Estimate.angle)
_G, _F = int(Estimate.gyro_bias), int(Estimate.force_bias)

LINES_TO_DOUBT = 3
"""Lines in a row outside the gate that are as bad as waiting for `patience`."""

LINES_TO_TRUST = 10.0
TRUSTED_WITHIN = 1.0
"""Lines in a row so near to their place [counts] after which a lost encoder is believed again."""

JUMP = 3.0
"""Change of count within a sample that no motion makes [counts]."""

ARM_PATIENCE = 3.0
"""An arm is doubted so much longer than a gimbal axis, for the others to say what they see."""

SILENCE = 1.0
"""For which a doubted encoder may pass no line in flight before it is lost [s]."""

FORCE_JUMPS = 3.0
"""Jumps of the accelerometers within `CALM` [s] of each other after which the estimate is begun anew."""
CALM = 2.0


@compiled
def believable(innovation: float, variance: float, c: FilterConstants) -> bool:
    """Whether an innovation is within the gate.

    Args:
        innovation: measured less expected.
        variance: of it.
        c: constants of the filter.
    """
    return innovation * innovation <= c.gate * variance


@compiled
def doubt_line(memory: Array, encoder: int, jump: float, c: FilterConstants) -> None:
    """Note a line outside its gate.

    Args:
        memory: of the filter, in the parts of `Memory`.
        encoder: which.
        jump: by how many counts it has changed.
        c: constants of the filter.
    """
    memory[Memory.refused + encoder] += 1.0
    if abs(jump) >= JUMP and _may_be_lost(memory, encoder):
        lose(memory, encoder)
    elif encoder < ARMS and memory[_SILENT + encoder] > 0.0:
        _force_jump(memory, c)
    else:
        memory[_DOUBT + encoder] += patience(encoder, c) / LINES_TO_DOUBT


@compiled
def patience(encoder: int, c: FilterConstants) -> float:
    """How long an encoder may disagree before it is judged [s].

    Args:
        encoder: which.
        c: constants of the filter.
    """
    return c.patience * ARM_PATIENCE if encoder < ARMS else c.patience


@compiled
def trust_line(
    memory: Array, encoder: int, jump: float, innovation: float, inside: bool, c: FilterConstants
) -> None:
    """Note a line of a lost encoder; believe it again if it came back, or has long been right.

    Args:
        memory: of the filter, in the parts of `Memory`.
        encoder: which.
        jump: by how many counts it has changed.
        innovation: measured less expected [rad].
        inside: whether it was within its gate.
        c: constants of the filter.
    """
    off = abs(innovation) / c.cell
    back = inside and abs(jump) >= JUMP and off <= 0.5 * abs(jump)
    memory[_AGREED + encoder] = memory[_AGREED + encoder] + 1.0 if inside and off <= TRUSTED_WITHIN else 0.0
    if back or memory[_AGREED + encoder] >= LINES_TO_TRUST:
        memory[_LOST + encoder], memory[_DOUBT + encoder], memory[_AGREED + encoder] = 0.0, 0.0, 0.0


@compiled
def confirm_line(memory: Array, encoder: int) -> None:
    """Note a line within its gate; it also shows that an undecided encoder is alive.

    Args:
        memory: of the filter, in the parts of `Memory`.
        encoder: which.
    """
    memory[_DOUBT + encoder] = 0.0
    memory[Memory.lines] += 1.0
    if encoder >= ARMS and memory[_SILENT + encoder] > 0.0:
        memory[_JUMPS + encoder - ARMS] += 1.0
    memory[_SILENT + encoder] = 0.0


@compiled
def judge(memory: Array, depth: float, work: Array, c: FilterConstants) -> bool:
    """Decide about every encoder that has been doubted for too long; False if nothing fits any more.

    Args:
        memory: of the filter, in the parts of `Memory`.
        depth: of the platform, NED z [m].
        work: scratch in the order of `Work`; rates are read.
        c: constants of the filter.
    """
    memory[Memory.calm] += c.period
    for encoder in range(ENCODERS):
        if memory[_DOUBT + encoder] >= patience(encoder, c) * (1.0 - 1e-9):
            if encoder < ARMS:
                _judge_arm(memory, encoder, c)
            else:
                _judge_axis(memory, encoder - ARMS, work, c)
        if memory[_SILENT + encoder] > 0.0:
            memory[_SILENT + encoder] += c.period
            if memory[_SILENT + encoder] > SILENCE:
                _end_silence(memory, encoder, depth > c.still_depth, c)
    return bool(memory[Memory.follow] < FORCE_JUMPS)


@compiled
def _end_silence(memory: Array, encoder: int, at_stop: bool, c: FilterConstants) -> None:
    memory[_SILENT + encoder] = 0.0
    if not at_stop and _may_be_lost(memory, encoder):
        lose(memory, encoder)
    elif encoder < ARMS:
        _force_jump(memory, c)
    else:
        memory[_JUMPS + encoder - ARMS] += 1.0


@compiled
def _may_be_lost(memory: Array, encoder: int) -> bool:
    """Two arms and an IMU can do without the third, one arm cannot."""
    if encoder >= ARMS:
        return True
    return bool(memory[_LOST] + memory[_LOST + 1] + memory[_LOST + 2] + memory[Memory.coasting] == 0.0)


@compiled
def _judge_arm(memory: Array, arm: int, c: FilterConstants) -> None:
    alone = _may_be_lost(memory, arm)
    for other in range(ENCODERS):
        if other != arm and memory[_DOUBT + other] + memory[_SILENT + other] + memory[_LOST + other] > 0.0:
            alone = False
    if alone:
        memory[_DOUBT + arm] = 0.0
        if memory[_SILENT + arm] == 0.0:
            memory[_SILENT + arm] = c.period
    else:
        _force_jump(memory, c)


@compiled
def _force_jump(memory: Array, c: FilterConstants) -> None:
    """Allow for a jump of the accelerometers' bias that began a while ago."""
    late = c.patience * ARM_PATIENCE
    for arm in range(ARMS):
        late = max(late, c.patience * ARM_PATIENCE + memory[_SILENT + arm])
        memory[_DOUBT + arm], memory[_SILENT + arm] = 0.0, 0.0
    covariance = memory[_COVARIANCE : Memory.gyro]
    widen(covariance, _F, c.force_jump)
    widen(covariance, _V, c.force_jump * late * late)
    widen(covariance, _P, 0.25 * c.force_jump * late * late * late * late)
    memory[Memory.force_jumps] += 1.0
    memory[Memory.follow] = memory[Memory.follow] + 1.0 if memory[Memory.calm] < CALM else 1.0
    memory[Memory.calm] = 0.0


@compiled
def _judge_axis(memory: Array, axis: int, work: Array, c: FilterConstants) -> None:
    """Allow for a jump along the direction of the gyros that moves this angle."""
    length = 0.0
    for k in range(3):
        length += work[_RATES + 3 * axis + k] * work[_RATES + 3 * axis + k]
    for k in range(3):
        for other in range(3):
            share = work[_RATES + 3 * axis + k] * work[_RATES + 3 * axis + other] / length
            memory[_COVARIANCE + SIZE * (_G + k) + _G + other] += share * c.bias_jump
    memory[_COVARIANCE + (SIZE + 1) * (_E + axis)] += 4.0 * c.cell_variance
    memory[_DOUBT + ARMS + axis] = 0.0
    if memory[Memory.coasting] == 0.0 and memory[_SILENT + ARMS + axis] == 0.0:
        memory[_SILENT + ARMS + axis] = c.period


@compiled
def lose(memory: Array, encoder: int) -> None:
    """Use an encoder no longer.

    Args:
        memory: of the filter, in the parts of `Memory`.
        encoder: which.
    """
    memory[_LOST + encoder], memory[_DOUBT + encoder], memory[_AGREED + encoder] = 1.0, 0.0, 0.0
    memory[_SILENT + encoder] = 0.0
