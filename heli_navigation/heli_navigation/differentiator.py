"""Velocity from sampled position: second-order low-pass with the derivative as its state.

    y'' + 2 zeta omega y' + omega^2 y = omega^2 x,   estimate of x' = y'

Between two samples x is taken as a straight line (first-order hold), for which the solution is closed: the
deviation from the line decays with the free motion of the filter. Hence a constant velocity is reproduced
exactly, and under a constant acceleration the estimate is late by the delay 2 zeta / omega.
"""

from __future__ import annotations

from math import cos, exp, sin, sqrt

DAMPING = sqrt(0.5)
"""Butterworth: the flattest pass band of second order."""


class Differentiator:
    """Low-pass differentiator of one signal.

    Args:
        bandwidth: omega [rad/s].
        period: distance of the samples [s].

    Raises:
        ValueError: bandwidth or period is not positive.
    """

    def __init__(self, bandwidth: float, period: float) -> None:
        if not (bandwidth > 0.0 and period > 0.0):
            raise ValueError(f"bandwidth {bandwidth} rad/s and period {period} s must be positive")
        self._period = period
        self._bandwidth = bandwidth
        decay = DAMPING * bandwidth
        ringing = bandwidth * sqrt(1.0 - DAMPING**2)
        envelope = exp(-decay * period)
        cosine, sine = envelope * cos(ringing * period), envelope * sin(ringing * period) / ringing
        self._free = (
            (cosine + decay * sine, sine),
            (-bandwidth * bandwidth * sine, cosine - decay * sine),
        )
        self._started = False
        self._input = 0.0
        self._value = 0.0
        self._rate = 0.0

    @property
    def delay(self) -> float:
        """Group delay at low frequency: 2 zeta / omega [s]."""
        return 2.0 * DAMPING / self._bandwidth

    @property
    def quantisation_gain(self) -> float:
        """Standard deviation of the rate per step of a quantised input, in the worst slow motion [1/s].

        A slow motion crosses a step of size d every d/v seconds and each gives a pulse of area d, of which
        the filter makes a variance of at most v d omega / (4 zeta) - v^2; it is largest at
        v = d omega / (8 zeta), where the standard deviation equals v.
        """
        return self._bandwidth / (8.0 * DAMPING)

    @property
    def rate(self) -> float:
        """The estimate after the last sample [unit of the input / s]."""
        return self._rate

    def step(self, value: float) -> float:
        """Take in the next sample and give the estimated rate; the first sample starts at rest.

        Args:
            value: the sample.

        Returns:
            its rate [unit of the sample / s].
        """
        if not self._started:
            self._started = True
            self._value, self._rate = value, 0.0
        else:
            slope = (value - self._input) / self._period
            lag = slope * self.delay
            behind = self._value - (self._input - lag)
            slower = self._rate - slope
            (a, b), (c, d) = self._free
            self._value = value - lag + a * behind + b * slower
            self._rate = slope + c * behind + d * slower
        self._input = value
        return self._rate

    def resume(self, value: float) -> None:
        """Go on after lost samples: the rate is kept, the jump of the input is not differentiated."""
        if self._started:
            self._value += value - self._input
            self._input = value
        else:
            self.step(value)

    def reset(self) -> None:
        """Forget everything: the next sample is a first one."""
        self._started = False
        self._value = self._rate = self._input = 0.0


class LowPass:
    """First-order low-pass of one sampled signal, y+ = y + (1 - exp(-omega T)) (x - y).

    Args:
        bandwidth: omega [rad/s].
        period: distance of the samples [s].

    Raises:
        ValueError: bandwidth or period is not positive.
    """

    def __init__(self, bandwidth: float, period: float) -> None:
        if not (bandwidth > 0.0 and period > 0.0):
            raise ValueError(f"bandwidth {bandwidth} rad/s and period {period} s must be positive")
        self._kept = exp(-bandwidth * period)
        self._period = period
        self._value: float | None = None

    @property
    def delay(self) -> float:
        """Lag behind a ramp [s]."""
        return self._period * self._kept / (1.0 - self._kept)

    def step(self, value: float) -> float:
        """Take in the next sample and give the filtered value; the first sample passes unchanged."""
        if self._value is None:
            self._value = value
        else:
            self._value = value + self._kept * (self._value - value)
        return self._value
