"""From commands to what the servos did, by the timing that is known of them (spec 2.5, 6.4).

A pulse frame latches every 20 ms, 5 ms after the control grid; the servo follows as a second-order system.
Needed where the position of the actuators was not recorded, as on the source's rig.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.signal import dlsim

from heli_common.quantities import quantity
from heli_common.timing import COMMAND_LATENCY_NS, PWM_PERIOD_NS, SENSOR_PERIOD_NS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ServoTiming:
    """What is known of a servo."""

    bandwidth: float = quantity(2.0 * pi * 25.0, "rad/s", "T", "natural frequency of the servo", 1.0, 1e4)
    damping: float = quantity(0.7, "", "D", "damping ratio of the servo", 0.05, 5.0)


def servo_positions(stamps: NDArray[np.int64], commands: Array, timing: ServoTiming | None = None) -> Array:
    """Positions of the actuators at the stamps of the commands, shape (N, m).

    The servos are taken to stand at the first command in the beginning.

    Args:
        stamps: of the commands [ns], shape (N,), on a regular grid.
        commands: [rad], shape (N, m).
        timing: of the servos.
    """
    servo = timing or ServoTiming()
    step = SENSOR_PERIOD_NS
    grid = np.arange(int(stamps[0]), int(stamps[-1]) + 1, step)
    # the frame under way at an instant, and the newest command it could know
    frame = (grid - COMMAND_LATENCY_NS) // PWM_PERIOD_NS * PWM_PERIOD_NS
    known = np.searchsorted(stamps, frame, side="right") - 1
    latched = commands[np.maximum(known, 0)]
    w, z = servo.bandwidth, servo.damping
    whole = np.zeros((3, 3))
    whole[:2] = [[0.0, 1.0, 0.0], [-w * w, -2.0 * z * w, w * w]]
    held = expm(whole * step * 1e-9)
    system = (held[:2, :2], held[:2, 2:], np.array([[1.0, 0.0]]), np.zeros((1, 1)), 1.0)
    places = np.searchsorted(grid, stamps)
    found = np.empty_like(commands)
    for channel in range(commands.shape[1]):
        rest = np.array([commands[0, channel], 0.0])
        _, position, _ = dlsim(system, latched[:, channel], x0=rest)
        found[:, channel] = position[places, 0]
    return found
