"""Innovation gates, and who is believed when a sensor and the filter disagree.

A reading further from what is expected than `gate` deviations is not used, and its encoder is doubted: three
lines in a row outside the gate, or no line passed although the filter has long been beyond one. What then is
to blame is decided by what the others say:

- **One arm alone** disagrees with two arms and the IMU: its encoder is lost and no longer used. Several arms
  together, or an arm while the attitude is in doubt, speak against the accelerometers: a jump of their bias is
  allowed for.
- **A gimbal axis** stands against its gyro alone: either the gyro's bias has jumped or the encoder is stuck.
  Both are allowed for, and what the encoder does next decides. A line says that it is alive, so the gyro has
  jumped; a second of silence in flight says that it is stuck, and it is lost. At the stop silence is no wonder
  and the encoder is believed.

A lost encoder is believed again when it comes back with a jump that brings it near to where it should be, as
one does that was stuck; or after ten lines in a row none of which was further off than one count. One that has
lost counts does neither.
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

JUMP_TO_TRUST = 3.0
"""Jump of a lost encoder that may bring it back [counts]; none turns so fast. It shall at least halve the way."""

ARM_PATIENCE = 3.0
"""An arm is doubted so much longer than a gimbal axis, for the others to say what they see."""

SILENCE = 1.0
"""For which a doubted gimbal axis may pass no line in flight before its encoder is lost [s]."""

HELD_PLACE, HELD_SPEED, HELD_FORCE = 0.003, 0.003, 0.0
"""What the cell of a stuck arm may have done to position [m], velocity [m/s] and bias [m/s^2]."""

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
def doubt_line(memory: Array, encoder: int, c: FilterConstants) -> None:
    """Note a line outside its gate.

    Args:
        memory: of the filter, in the parts of `Memory`.
        encoder: which.
        c: constants of the filter.
    """
    memory[Memory.refused + encoder] += 1.0
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
    off = abs(innovation) / c.count
    back = inside and abs(jump) >= JUMP_TO_TRUST and off <= 0.5 * abs(jump)
    memory[_AGREED + encoder] = memory[_AGREED + encoder] + 1.0 if inside and off <= TRUSTED_WITHIN else 0.0
    if back or memory[_AGREED + encoder] >= LINES_TO_TRUST:
        memory[_LOST + encoder], memory[_DOUBT + encoder], memory[_AGREED + encoder] = 0.0, 0.0, 0.0


@compiled
def confirm_line(memory: Array, encoder: int) -> None:
    """Note a line within its gate; it also shows that an undecided gimbal axis is alive.

    Args:
        memory: of the filter, in the parts of `Memory`.
        encoder: which.
    """
    memory[_DOUBT + encoder] = 0.0
    memory[Memory.lines] += 1.0
    if encoder >= ARMS and memory[_SILENT + encoder - ARMS] > 0.0:
        memory[_SILENT + encoder - ARMS] = 0.0
        memory[_JUMPS + encoder - ARMS] += 1.0


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
    for axis in range(ENCODERS - ARMS):
        encoder = ARMS + axis
        if memory[_DOUBT + encoder] >= patience(encoder, c) * (1.0 - 1e-9):
            _judge_axis(memory, axis, work, c)
        if memory[_SILENT + axis] > 0.0:
            memory[_SILENT + axis] += c.period
            if memory[_SILENT + axis] > SILENCE:
                memory[_SILENT + axis] = 0.0
                if depth > c.still_depth:
                    memory[_JUMPS + axis] += 1.0
                else:
                    lose(memory, encoder)
    for arm in range(ARMS):
        if memory[_DOUBT + arm] >= patience(arm, c) * (1.0 - 1e-9) and not _judge_arm(memory, arm, c):
            return False
    return True


@compiled
def _judge_arm(memory: Array, arm: int, c: FilterConstants) -> bool:
    alone = memory[Memory.coasting] == 0.0
    for other in range(ENCODERS):
        if other != arm and memory[_LOST + other] > 0.0:
            alone = False
    for other in range(ARMS):
        if (other != arm and memory[_DOUBT + other] > 0.0) or memory[_SILENT + other] > 0.0:
            alone = False
    covariance = memory[_COVARIANCE : Memory.gyro]
    if alone:
        if memory[Memory.innovation + arm] * memory[Memory.innovation + arm] <= c.gate:
            # it has stood still for an unknown time, and its cell has held the estimate
            widen(covariance, _P, HELD_PLACE * HELD_PLACE)
            widen(covariance, _V, HELD_SPEED * HELD_SPEED)
            widen(covariance, _F, HELD_FORCE * HELD_FORCE)
        lose(memory, arm)
        return True
    late = c.patience * ARM_PATIENCE
    widen(covariance, _F, c.force_jump)
    widen(covariance, _V, c.force_jump * late * late)
    widen(covariance, _P, 0.25 * c.force_jump * late * late * late * late)
    memory[Memory.force_jumps] += 1.0
    for other in range(ARMS):
        memory[_DOUBT + other] = 0.0
    memory[Memory.follow] = memory[Memory.follow] + 1.0 if memory[Memory.calm] < CALM else 1.0
    memory[Memory.calm] = 0.0
    return bool(memory[Memory.follow] < FORCE_JUMPS)


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
    if memory[Memory.coasting] == 0.0 and memory[_SILENT + axis] == 0.0:
        memory[_SILENT + axis] = c.period


@compiled
def lose(memory: Array, encoder: int) -> None:
    """Use an encoder no longer.

    Args:
        memory: of the filter, in the parts of `Memory`.
        encoder: which.
    """
    memory[_LOST + encoder], memory[_DOUBT + encoder], memory[_AGREED + encoder] = 1.0, 0.0, 0.0
