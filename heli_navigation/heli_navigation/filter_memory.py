"""All that the inertial filter remembers, in one array; errors of its estimates in one order.

The filter estimates the motion of the IMU's place, because accelerometers feel that: position and velocity in
earth NED, the gimbal's angles, and the biases of gyros and accelerometers in body FRD. An error is the true
value less the estimate, angle by angle: tilt is limited to 25 deg, so Euler angles serve, and an encoder of
the gimbal measures one of them directly.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from heli_common.rig_geometry import ENCODER_NAMES

Array = NDArray[np.float64]

ARMS = 3
ENCODERS = len(ENCODER_NAMES)


class Estimate(IntEnum):
    """What is estimated, and where each part begins among the 15; the same order holds for its errors."""

    position = 0
    """of the IMU, earth NED from the flight-space centre [m]"""
    velocity = 3
    """of the IMU, earth NED [m/s]"""
    angle = 6
    """yaw, pitch, roll [rad]"""
    gyro_bias = 9
    """body FRD [rad/s]; while there is no IMU, the body's rates with the sign turned"""
    force_bias = 12
    """of the accelerometers, body FRD [m/s^2]"""
    end = 15


SIZE = int(Estimate.end)


class Memory(IntEnum):
    """Where each part begins; a part reaches to the beginning of the next."""

    estimate = 0
    """in the order of `Estimate`"""
    covariance = SIZE
    """of its errors, row by row"""
    gyro = covariance + SIZE * SIZE
    """latest reading used [rad/s]"""
    force = gyro + 3
    """latest reading of the accelerometers used [m/s^2]"""
    line = force + 3
    """count of each encoder"""
    age = line + ENCODERS
    """samples since that count was read"""
    doubt = age + ENCODERS
    """time for which each encoder has disagreed [s]"""
    lost = doubt + ENCODERS
    """1 for each encoder that is not believed any more"""
    agreed = lost + ENCODERS
    """lines in a row at which a lost encoder was right again"""
    refused = agreed + ENCODERS
    """readings of each encoder outside their gate, so far"""
    innovation = refused + ENCODERS
    """of the latest line of each encoder, in its deviations"""
    unchanged = innovation + ENCODERS
    """time since any count has changed [s]"""
    standing = unchanged + 1
    """1 while the helicopter is taken to stand"""
    coasting = standing + 1
    """1 while there is no IMU"""
    coasted = coasting + 1
    """time without IMU so far [s]"""
    kept_bias = coasted + 1
    """the gyros' biases from before that [rad/s]"""
    kept_variance = kept_bias + 3
    """and their variances [rad^2/s^2]"""
    jumps = kept_variance + 3
    """jumps of a gyro's bias found so far, by the gimbal's axis that showed it: yaw, pitch, roll"""
    silent = jumps + 3
    """time for which it has been undecided who is right, each encoder or the IMU, 0 if it is not [s]"""
    force_jumps = silent + ENCODERS
    """jumps of the accelerometers' biases found so far"""
    follow = force_jumps + 1
    """how many of them have followed each other closely"""
    calm = follow + 1
    """time since the latest of them [s]"""
    drift = calm + 1
    """smoothed rates of the gyros, biases taken off, while the helicopter stands [rad/s]"""
    lines = drift + 3
    """lines believed so far"""
    end = lines + 1


class Work(IntEnum):
    """Scratch numbers of the compiled filter; nothing in it outlives a sample."""

    body = 0
    """(9) C_nb, body to earth, row by row"""
    rates = body + 9
    """(9) body rates to the rates of yaw, pitch, roll"""
    bend = rates + 9
    """(9) derivative of those by the angles [1/s]"""
    lean = bend + 9
    """(9) derivative of the specific force in NED by the angles [m/s^2]"""
    rate = lean + 9
    """(3) rates of the body, bias taken off [rad/s]"""
    push = rate + 3
    """(3) specific force of the body, bias taken off [m/s^2]"""
    column = push + 3
    """(15) covariance of a measured quantity with the errors"""
    correction = column + SIZE
    """(15) sum of all corrections at this sample"""
    slope = correction + SIZE
    """(3) derivative of an arm's angle by the platform's position [rad/m]"""
    angle = slope + 3
    """(6) readings of the encoders [rad]"""
    place = angle + ENCODERS
    """(3) platform, NED [m]"""
    speed = place + 3
    """(3) its velocity, NED [m/s]"""
    turning = speed + 3
    """(3) rates of yaw, pitch, roll [rad/s]"""
    end = turning + 3


def blank_memory() -> Array:
    """Zeros: nothing known yet."""
    return np.zeros(Memory.end)
