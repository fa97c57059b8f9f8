"""The running estimate: pitch and roll accelerations from speeds, rates and cyclic (source eq. 2.82).

    q' = M_u u + M_v v + M_q q + M_1 B_1s + M_2 A_1s + M_0
    p' = L_u u + L_v v + L_p p + L_1 B_1s + L_2 A_1s + L_0

Over windows of ten samples: the change of the rate against the means of what acts. That keeps the measurement
noise down as the source's averaging does, and its errors nearly white. It is a look at a flight while it is
flown: least squares in closed loop are biased by gusts and by the servo rotor that this structure leaves out.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heli_common.quantities import quantity
from heli_common.timing import CONTROL_PERIOD, CONTROL_PERIOD_NS, ESTIMATE_PERIOD_NS
from heli_common.topics import ESTIMATED
from heli_common.vehicle_state import VehicleState
from heli_identification.recursive_least_squares import RecursiveLeastSquares

WINDOW = ESTIMATE_PERIOD_NS // CONTROL_PERIOD_NS
"""Samples from one regression to the next."""

UNKNOWN_ERROR = 1e9
"""Standard error published while nothing is known."""


@dataclass(frozen=True)
class EstimateParameters:
    """How fast the estimate forgets, and how late commands act."""

    memory: float = quantity(120.0, "s", "D", "time after which a sample weighs e times less", 1.0, 1e6)
    command_delay: float = quantity(
        0.03, "s", "D", "from a command's stamp to the blades: latency, pulse frame, servo", 0.0, 0.3
    )


class RunningEstimate:
    """Both regressions, fed with the state and the applied command of every control tick.

    Args:
        parameters: memory and delay.
    """

    def __init__(self, parameters: EstimateParameters) -> None:
        forgetting = float(np.exp(-WINDOW * CONTROL_PERIOD / parameters.memory))
        self._axes = tuple(RecursiveLeastSquares(len(ESTIMATED) // 2, forgetting) for _ in range(2))
        self._delay = round(parameters.command_delay / CONTROL_PERIOD)
        self._window: deque[NDArray[np.float64]] = deque(maxlen=WINDOW + 1)
        self._commands: deque[tuple[float, float]] = deque(maxlen=self._delay + 1)
        self._since = 0

    def step(self, state: VehicleState, command: Sequence[float], excited: bool) -> None:
        """Take a control tick in; it counts only while the helicopter is excited.

        Args:
            state: of the helicopter.
            command: B_1s and A_1s in front, servo command and excitation together [rad].
            excited: whether an excitation acts: without one, nothing new can be learnt in closed loop.
        """
        self._commands.append((command[0], command[1]))
        if not excited:
            self._window.clear()
            self._since = 0
            return
        u, v, _ = state.velocity
        p, q, _ = state.rates
        self._window.append(np.array([u, v, q, p, *self._commands[0], 1.0]))
        self._since += 1
        if self._since > WINDOW:
            self._since = 1  # the last sample of a window is the first of the next one
            self._learn()

    def _learn(self) -> None:
        rows = np.array(self._window)
        ends = 0.5 * (rows[0] + rows[-1])
        means = (ends + rows[1:-1].sum(axis=0)) / WINDOW  # trapezoidal rule
        rates = (rows[-1] - rows[0]) / (WINDOW * CONTROL_PERIOD)
        pitch, roll = self._axes
        pitch.step(means[[0, 1, 2, 4, 5, 6]], float(rates[2]))
        roll.step(means[[0, 1, 3, 4, 5, 6]], float(rates[3]))

    @property
    def estimate(self) -> NDArray[np.float64]:
        """(12,) coefficients in the order of `ESTIMATED` [1/s, 1/(m s), 1/s^2, rad/s^2]."""
        return np.asarray(np.concatenate([axis.estimate for axis in self._axes]))

    @property
    def standard_error(self) -> NDArray[np.float64]:
        """(12,) of the coefficients, for white errors."""
        errors = np.concatenate([axis.standard_error for axis in self._axes])
        return np.asarray(np.minimum(errors, UNKNOWN_ERROR))
