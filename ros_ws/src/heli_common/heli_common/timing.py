"""Simulated time: integer nanoseconds from 0; the grid on which everything happens (spec 6.4)."""

from __future__ import annotations

SENSOR_PERIOD_NS = 2_500_000
"""Encoders are sampled at 400 Hz."""

CONTROL_PERIOD_NS = 10_000_000
"""Navigation for control, controllers and supervisor act at 100 Hz."""

ESTIMATE_PERIOD_NS = 100_000_000
"""The running estimate is published at 10 Hz."""

COMMAND_LATENCY_NS = 5_000_000
"""A command stamped t_k acts at t_k + 5 ms."""

PWM_PERIOD_NS = 20_000_000
"""Servo pulse frames latch the newest command at n * 20 ms + 5 ms."""

SENSOR_PERIOD = SENSOR_PERIOD_NS * 1e-9
CONTROL_PERIOD = CONTROL_PERIOD_NS * 1e-9


def is_control_tick(stamp_ns: int) -> bool:
    """Whether controllers act on the sample of this stamp."""
    return stamp_ns % CONTROL_PERIOD_NS == 0


def is_command_tick(stamp_ns: int) -> bool:
    """Whether a command of the control grid takes effect at this stamp."""
    return stamp_ns % CONTROL_PERIOD_NS == COMMAND_LATENCY_NS


def is_pwm_tick(stamp_ns: int) -> bool:
    """Whether the servo pulse frame is latched at this stamp."""
    return stamp_ns % PWM_PERIOD_NS == COMMAND_LATENCY_NS
