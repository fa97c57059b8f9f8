"""From commands to what the servos did, by what is known of them (spec 2.5, 6.4).

A pulse frame latches every 20 ms, 5 ms after the control grid; each shaft follows as a second-order system
with a limited rate. Needed where the position of the actuators was not recorded, as on the source's rig.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, exp, pi, radians, sin

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from heli_common.quantities import quantity
from heli_common.timing import COMMAND_LATENCY_NS, PWM_PERIOD_NS, SENSOR_PERIOD_NS

Array = NDArray[np.float64]

PLATE_LEVER, TAIL_LEVER = 6.0, 4.0
"""Shaft angle per blade angle (spec 2.5, D)."""
CONVERTER_LAG = 0.005
"""Of the rotor speed's frequency-to-voltage converter [s] (spec 2.6, D)."""
AZIMUTHS = (0.0, 2.0 * pi / 3.0, 4.0 * pi / 3.0)
"""Of the swash-plate servos from the nose [rad] (spec 2.5, D)."""


@dataclass(frozen=True)
class ServoTiming:
    """What is known of a servo."""

    bandwidth: float = quantity(2.0 * pi * 25.0, "rad/s", "T", "natural frequency of the servo", 1.0, 1e3)
    damping: float = quantity(0.7, "-", "D", "damping ratio of the servo", 0.05, 5.0)
    rate_limit: float = quantity(radians(500.0), "rad/s", "D", "fastest shaft rate", 0.1, 1e3)


def servo_positions(
    stamps: NDArray[np.int64],
    commands: Array,
    inputs: Sequence[str],
    timing: ServoTiming | None = None,
) -> Array:
    """Positions of the actuators at the stamps of the commands, shape (N, m).

    The servos are taken to stand at the first command in the beginning.

    Args:
        stamps: of the commands [ns], shape (N,), on a regular grid.
        commands: [rad], shape (N, m).
        inputs: m of B_1s A_1s theta_0 theta_t.
        timing: of the servos.
    """
    servo = timing or ServoTiming()
    levers = shaft_levers(inputs)
    step = SENSOR_PERIOD_NS
    grid = np.arange(int(stamps[0]), int(stamps[-1]) + 1, step)
    # the frame under way at an instant, and the newest command it could know
    frame = (grid - COMMAND_LATENCY_NS) // PWM_PERIOD_NS * PWM_PERIOD_NS
    known = np.searchsorted(stamps, frame, side="right") - 1
    latched = (commands @ levers.T)[np.maximum(known, 0)]
    w, z, seconds = servo.bandwidth, servo.damping, step * 1e-9
    whole = np.zeros((3, 3))
    whole[:2] = [[0.0, 1.0, 0.0], [-w * w, -2.0 * z * w, w * w]]
    held = expm(whole * seconds)[:2]
    decay = exp(-2.0 * z * w * seconds)
    shaft: Array = latched[0].copy()
    rate: Array = np.zeros(len(levers))
    found = np.empty((len(grid), len(levers)))
    for index, asked in enumerate(latched):
        found[index] = shaft
        free = held @ np.vstack((shaft, rate, asked))
        # the servo asks for a rate, w / 2 z times its error, and cannot ask for more than its limit
        wanted = w / (2.0 * z) * (asked - shaft)
        fastest = np.clip(wanted, -servo.rate_limit, servo.rate_limit)
        limited = fastest != wanted
        led = (rate - fastest) * (1.0 - decay) / (2.0 * z * w)
        shaft = np.where(limited, shaft + fastest * seconds + led, free[0])
        rate = np.where(limited, fastest + (rate - fastest) * decay, free[1])
    positions: Array = found[np.searchsorted(grid, stamps)] @ np.linalg.pinv(levers).T
    return positions


def after_converter(voltages: Array, period: float, lag: float = CONVERTER_LAG) -> Array:
    """Held voltages after the lag of the converter that measures the speed, averaged over each holding.

    Everything between voltage and speed is linear, so the lag of the measurement may stand before the drive.

    Args:
        voltages: each held for one period, deviations or absolute [V], shape (N, m).
        period: [s].
        lag: of the converter [s].
    """
    kept = exp(-period / lag)
    mean = lag / period * (1.0 - kept)
    state: Array = voltages[0].copy()
    found = np.empty_like(voltages)
    for index, voltage in enumerate(voltages):
        found[index] = voltage + mean * (state - voltage)
        state = voltage + kept * (state - voltage)
    return found


def as_late_as_speed(torques: Array, period: float, lag: float = CONVERTER_LAG) -> Array:
    """A torque, linear between samples, after the same lag.

    Args:
        torques: at the samples [N m], shape (N,).
        period: [s].
        lag: of the converter [s].
    """
    kept = exp(-period / lag)
    mean = lag / period * (1.0 - kept)
    state = float(torques[0])
    found = np.empty_like(torques)
    found[0] = state
    for index in range(1, len(torques)):
        before, now = float(torques[index - 1]), float(torques[index])
        state = kept * state + (mean - kept) * before + (1.0 - mean) * now
        found[index] = state
    return found


def shaft_levers(inputs: Sequence[str]) -> Array:
    """Shaft angles by blade angles, shape (4, m): three servos of the swash plate, one of the tail.

    Raises:
        ValueError: an input that no servo moves.
    """
    columns = {
        "B_1s": [*(PLATE_LEVER * cos(psi) for psi in AZIMUTHS), 0.0],
        "A_1s": [*(PLATE_LEVER * sin(psi) for psi in AZIMUTHS), 0.0],
        "theta_0": [PLATE_LEVER, PLATE_LEVER, PLATE_LEVER, 0.0],
        "theta_t": [0.0, 0.0, 0.0, TAIL_LEVER],
    }
    for name in inputs:
        if name not in columns:
            raise ValueError(f"input {name!r} is none of {', '.join(columns)}")
    return np.array([columns[name] for name in inputs]).T
