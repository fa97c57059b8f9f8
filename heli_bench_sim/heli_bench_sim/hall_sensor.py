"""Rotor speed from a Hall sensor and a frequency-to-voltage converter (spec 2.4, source eq. 4.1).

Two magnets on the motor's pinion give two pulses per turn of the motor, 416 Hz at nominal speed. The
converter turns 0..800 Hz into 0..10 V; with two pulses per turn, Omega_motor = U * 80 * 0.5 * 60 rpm.

How the converter measures is lost and chosen here (D): it times whole pulse distances, each sample of 2.5 ms
those that ended within it, and holds the frequency until the next pulse; if that does not come in time, the
frequency falls as one over the waiting time and below the lowest frequency it is zero. A lag smooths the
voltage, a converter of 12 bits reads it. The magnets stand exactly opposite each other, so at constant speed
there is no ripple. The sensor does not feel which way the motor turns. A magnet counts again only after its
neighbour has passed, so a rotor that rocks to and fro over one magnet at rest gives no speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled, equation
from heli_common.quantities import quantity
from heli_common.timing import SENSOR_PERIOD

Array = NDArray[np.float64]

TURN = 2.0 * math.pi


class HallState(IntEnum):
    """What sensor and converter remember; all zeros is power-up with the rotor at rest at azimuth 0."""

    azimuth = 0
    """of the rotor at the latest sample [rad]"""
    way = 1
    """turned since the latest pulse, in distances of pulses, -1 .. 1"""
    waiting = 2
    """time since the latest pulse [s]"""
    timed = 3
    """1 once there has been a pulse to measure from"""
    frequency = 4
    """measured last [Hz]"""
    voltage = 5
    """of the converter, after its lag [V]"""


HALL_STATE_SIZE = len(HallState)


@dataclass(frozen=True)
class HallParameters:
    """Sensor, frequency-to-voltage converter and the analog input that reads it."""

    magnets: float = quantity(2.0, "-", "T", "pulses per turn of the motor", 1.0, 100.0)
    top_frequency: float = quantity(800.0, "Hz", "T", "frequency of the highest voltage", 1.0, 1e5)
    top_voltage: float = quantity(10.0, "V", "T", "highest voltage", 0.1, 100.0)
    lowest_frequency: float = quantity(5.0, "Hz", "D", "below it the converter gives 0 V", 0.1, 100.0)
    lag: float = quantity(0.005, "s", "D", "time constant of the converter's output", 0.0, 1.0)
    bits: float = quantity(12.0, "bit", "D", "resolution of the analog input", 1.0, 24.0)


class HallConstants(NamedTuple):
    """What the compiled sensor needs; every field a float."""

    pulses_per_radian: float
    """of the rotor [1/rad]"""
    period: float
    """of the samples [s]"""
    top_frequency: float
    lowest_frequency: float
    volts_per_hertz: float
    follow: float
    """share of the way to its new voltage that the lag goes in one sample"""
    volt_step: float
    """of the analog input [V]"""
    top_code: float
    speed_per_volt: float
    """source eq. 4.1, for the rotor [rad/s/V]"""


def hall_constants(parameters: HallParameters, motor_gear: float) -> HallConstants:
    """Constants of the compiled sensor, sampled at 400 Hz.

    Args:
        parameters: of sensor and converter.
        motor_gear: motor turns per rotor turn.

    Raises:
        ValueError: magnets or bits that are no whole number, a gear that is not positive, a lowest frequency
            that is not below the top one.
    """
    for name, number in (("magnets", parameters.magnets), ("bits", parameters.bits)):
        if not number.is_integer():
            raise ValueError(f"{name} {number!r} is no whole number")
    if not 0.0 < motor_gear < math.inf:
        raise ValueError(f"motor_gear {motor_gear!r} must be positive and finite")
    lowest, top = parameters.lowest_frequency, parameters.top_frequency
    if lowest >= top:
        raise ValueError(f"lowest_frequency {lowest!r} Hz is not below top_frequency {top!r} Hz")
    codes = 2.0**parameters.bits
    pulses = parameters.magnets * motor_gear / TURN
    volts_per_hertz = parameters.top_voltage / top
    return HallConstants(
        pulses_per_radian=pulses,
        period=SENSOR_PERIOD,
        top_frequency=top,
        lowest_frequency=lowest,
        volts_per_hertz=volts_per_hertz,
        follow=-math.expm1(-SENSOR_PERIOD / parameters.lag) if parameters.lag > 0.0 else 1.0,
        volt_step=parameters.top_voltage / codes,
        top_code=codes - 1.0,
        speed_per_volt=1.0 / (volts_per_hertz * pulses),
    )


def hall_settled(omega: float, azimuth: float, c: HallConstants) -> Array:
    """(6,) state in the order of `HallState` after a long time at one speed; at 0 it is that of power-up.

    The next sample then comes one period after this state.

    Args:
        omega: rotor speed [rad/s].
        azimuth: of the rotor now [rad].
        c: constants of the sensor.
    """
    state = np.zeros(HALL_STATE_SIZE)
    frequency = abs(omega) * c.pulses_per_radian
    passed = azimuth * c.pulses_per_radian % 1.0
    way = passed if omega >= 0.0 else passed - 1.0
    state[HallState.azimuth], state[HallState.way] = azimuth, way
    if frequency >= c.lowest_frequency:
        state[HallState.timed] = 1.0
        state[HallState.waiting] = abs(way) / frequency
        state[HallState.frequency] = min(frequency, c.top_frequency)
        state[HallState.voltage] = c.volts_per_hertz * state[HallState.frequency]
    return state


@equation
def since_pulse(beyond: float, way: float, speed: float, period: float) -> float:
    """Time from the latest pulse of a sample to its end [s], the speed changing linearly in between.

    Args:
        beyond: way since that pulse, 0 .. way.
        way: of the whole sample, positive.
        speed: way per time at its end.
        period: of the sample [s].
    """
    bend = (speed - way / period) / period
    slowest = speed + math.sqrt(max(speed * speed - 4.0 * bend * beyond, 0.0))
    return min(2.0 * beyond / slowest, period) if slowest > 0.0 else 0.0


@compiled
def hall_sample(omega: float, azimuth: float, state: Array, c: HallConstants) -> float:
    """Measured rotor speed [rad/s], 0 or more, one sample of 2.5 ms after the latest one.

    Args:
        omega: true rotor speed now [rad/s].
        azimuth: of the rotor now [rad], wrapped or not; less than half a turn from that of the latest sample.
        state: (6,) in the order of `HallState`, overwritten.
        c: constants of the sensor.
    """
    turned = azimuth - state[HallState.azimuth]
    turned -= TURN * math.floor(turned / TURN + 0.5)
    step = turned * c.pulses_per_radian
    way = state[HallState.way] + step
    pulses = math.floor(abs(way))
    beyond = abs(way) - pulses
    waiting = state[HallState.waiting] + c.period
    frequency = state[HallState.frequency]
    if pulses > 0:
        speed = abs(omega) * c.pulses_per_radian
        after = since_pulse(beyond, abs(step), speed, c.period)
        # the first pulse ever only starts the clock
        frequency = pulses / (waiting - after) if state[HallState.timed] > 0.0 else 0.0
        state[HallState.timed], waiting = 1.0, after
    elif frequency * waiting > 1.0:
        frequency = 1.0 / waiting
    frequency = min(frequency, c.top_frequency)
    if frequency < c.lowest_frequency:
        frequency = 0.0
    state[HallState.azimuth] = azimuth
    state[HallState.way] = math.copysign(beyond, way)
    state[HallState.waiting] = waiting
    state[HallState.frequency] = frequency
    state[HallState.voltage] += c.follow * (c.volts_per_hertz * frequency - state[HallState.voltage])
    code = math.floor(state[HallState.voltage] / c.volt_step + 0.5)
    return float(min(code, c.top_code) * c.volt_step * c.speed_per_volt)
