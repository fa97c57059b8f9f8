"""Attitude from the IMU alone: extended Kalman filter of Euler angles and gyro biases (source section 4.2).

The gyros turn the angles on at 400 Hz (source eq. 2.2, 2.3, A.11), with s = q sin phi + r cos phi:

    psi' = s / cos theta,   theta' = q cos phi - r sin phi,   phi' = p + s tan theta,   (p q r) = gyro - bias.

The accelerometers see the specific force at their own place. Less the terms of the lever arm,
w x (w x d) + w' x d, it is that of the centre of gravity; the acceleration in it is taken as noise, and

    f = (g sin theta, -g cos theta sin phi, -g cos theta cos phi) + bias.

That corrects pitch and roll; of yaw it says nothing, so the yaw's variance grows. Tilt and accelerometer bias
cannot be told apart at rest, unless the tilt is known: the angles to start from tell the biases of the
accelerometers, which are states of the filter too. Without them pitch and roll would be wrong by bias / g.

Beside the textbook:

- Velocity is summed up from what the filter cannot explain of the specific force, and forgotten in about a
  second. The more it exceeds that of calm flight, the less the accelerometers are believed, to a quarter.
- No helicopter on the bench accelerates for long: if that lasts, the bias of a gyro must have jumped, and the
  biases are set free to be found anew.
- If for half a second gyros and horizontal accelerometers spread no more than their own noise does, the
  helicopter stands with its rotor at rest: the gyros then read their biases, that of yaw included.

Source section 4.2 names such a filter and its purpose; equations of measurement and numbers are chosen (D).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled import compiled, equation
from heli_common.records import boxed, packed
from heli_common.rotations import Euler, Vector3
from heli_common.topics import TOPICS
from heli_common.vehicle_state import UNKNOWN_VARIANCE
from heli_navigation.imu_attitude_equations import ROWS, AttitudeMemory, cell, correct, predict, read_attitude
from heli_navigation.imu_attitude_parameters import (
    ImuAttitudeConstants,
    ImuAttitudeParameters,
    imu_attitude_constants,
)
from heli_navigation.imu_standstill import forget_window, wait

Array = NDArray[np.float64]

STEEPEST = math.radians(80.0)
"""Largest pitch up or down; towards 90 deg yaw and roll become one and the same."""

_IMU = len(TOPICS["imu_attitude"].layout.fields)

LARGEST = 1000.0
"""Sum of the sizes of all readings that is taken, far beyond any range [rad/s], [m/s^2]."""


@compiled
def forget_angles(memory: Array) -> None:
    """Angles zero, without any doubt and without any link to the biases.

    Args:
        memory: of the filter, overwritten.
    """
    for row in range(3):
        memory[AttitudeMemory.psi + row] = 0.0
        for column in range(ROWS):
            memory[cell(row, column)] = 0.0
            memory[cell(column, row)] = 0.0
    memory[AttitudeMemory.known] = 0.0


@equation
def turned(angle: float) -> float:
    """An angle less than one turn beyond -pi .. pi, brought back [rad].

    Args:
        angle: [rad].
    """
    if angle > math.pi:
        return angle - 2.0 * math.pi
    return angle + 2.0 * math.pi if angle < -math.pi else angle


@compiled
def attitude_step(
    memory: Array,
    gx: float,
    gy: float,
    gz: float,
    fx: float,
    fy: float,
    fz: float,
    valid: bool,
    box: Sequence[ImuAttitudeConstants],
) -> bool:
    """Go on by one sample of 2.5 ms; False, and nothing changed, if a valid reading is none.

    Args:
        memory: of the filter, in the parts of `AttitudeMemory`, overwritten.
        gx: gyro x, body FRD [rad/s].
        gy: gyro y.
        gz: gyro z.
        fx: accelerometer x [m/s^2].
        fy: accelerometer y.
        fz: accelerometer z.
        valid: whether they were measured at this sample; if not they are not looked at.
        box: constants of the filter, boxed.
    """
    # so written that NaN fails it
    if valid and not abs(gx) + abs(gy) + abs(gz) + abs(fx) + abs(fy) + abs(fz) <= LARGEST:
        return False
    c, at = box[0], AttitudeMemory.gyro
    known, fresh = memory[AttitudeMemory.known] > 0.5, memory[AttitudeMemory.fresh] > 0.5
    b_p, b_q, b_r = (
        memory[AttitudeMemory.gyro_bias],
        memory[AttitudeMemory.gyro_bias + 1],
        memory[AttitudeMemory.gyro_bias + 2],
    )
    p_rate, q_rate, r_rate = 0.0, 0.0, 0.0
    if valid:
        before_x, before_y, before_z = gx, gy, gz
        if fresh:
            before_x, before_y, before_z = memory[at], memory[at + 1], memory[at + 2]
            p_rate, q_rate, r_rate = (
                (gx - before_x) / c.period,
                (gy - before_y) / c.period,
                (gz - before_z) / c.period,
            )
        if known:
            p, q, r = 0.5 * (gx + before_x) - b_p, 0.5 * (gy + before_y) - b_q, 0.5 * (gz + before_z) - b_r
            predict(memory, p, q, r, 1.0, c)
        memory[at], memory[at + 1], memory[at + 2] = gx, gy, gz
        memory[AttitudeMemory.fresh] = 1.0
    else:
        if known:
            predict(memory, 0.0, 0.0, 0.0, 0.0, c)
        memory[AttitudeMemory.fresh] = 0.0
    for axis in range(3, 6):
        memory[cell(axis, axis)] += c.walk_variance
    if valid:
        if known:
            p, q, r = gx - b_p, gy - b_q, gz - b_r
            along, square = p * c.x + q * c.y + r * c.z, p * p + q * q + r * r
            correct(
                memory,
                fx - (p * along - c.x * square) - (q_rate * c.z - r_rate * c.y),
                fy - (q * along - c.y * square) - (r_rate * c.x - p_rate * c.z),
                fz - (r * along - c.z * square) - (p_rate * c.y - q_rate * c.x),
                c,
            )
        wait(memory, (gx, gy, gz), fx, fy, c)
    else:
        forget_window(memory)
    if known:
        memory[AttitudeMemory.psi] = turned(memory[AttitudeMemory.psi])
        memory[AttitudeMemory.phi] = turned(memory[AttitudeMemory.phi])
        if not abs(memory[AttitudeMemory.theta]) < STEEPEST:
            forget_angles(memory)
    return True


class ImuAttitude:
    """The filter; it knows no attitude before `align`, but its gyro biases if it stands still before.

    Should the pitch leave +-80 deg, the attitude is unknown until `align`, and that is counted.

    Args:
        parameters: of IMU, motion and standstill.

    Attributes:
        parameters: the same.
        lost: times at which the pitch left its range.
        skipped: samples without a valid reading.
    """

    def __init__(self, parameters: ImuAttitudeParameters | None = None) -> None:
        self.parameters = parameters or ImuAttitudeParameters()
        constants = imu_attitude_constants(self.parameters)
        self._box = boxed(packed(constants))
        self._alignment = constants.alignment
        self.lost = 0
        self.skipped = 0
        self._known = False
        self._memory = np.zeros(AttitudeMemory.end)
        for axis in range(3):
            self._memory[cell(3 + axis, 3 + axis)] = constants.gyro_bias
            self._memory[cell(6 + axis, 6 + axis)] = constants.accelerometer_bias

    def align(self, psi: float, theta: float, phi: float) -> None:
        """Begin anew from angles of somebody else, at the latest sample; what is known of biases stays.

        Args:
            psi: yaw [rad].
            theta: pitch [rad], within +-80 deg.
            phi: roll [rad].

        Raises:
            ValueError: an angle that is not finite, or too steep a pitch.
        """
        if not math.isfinite(psi + theta + phi):
            raise ValueError(f"attitude {(psi, theta, phi)!r} is not three finite angles (rad)")
        if not abs(theta) < STEEPEST:
            raise ValueError(f"pitch {theta!r} rad is too steep (allowed: |theta| < {STEEPEST:.4f} rad)")
        memory = self._memory
        forget_angles(memory)
        memory[AttitudeMemory.psi : AttitudeMemory.gyro_bias] = (
            math.remainder(psi, math.tau),
            theta,
            math.remainder(phi, math.tau),
        )
        for row in range(3):
            memory[cell(row, row)] = self._alignment
        memory[AttitudeMemory.velocity : AttitudeMemory.still_count] = 0.0
        memory[AttitudeMemory.known] = 1.0
        self._known = True

    def step(self, gyro: Sequence[float], accelerometer: Sequence[float], valid: bool = True) -> None:
        """Go on by one sample of 2.5 ms; call it once for every sample, lost ones included.

        Args:
            gyro: (3,) readings, body FRD [rad/s].
            accelerometer: (3,) readings, body FRD [m/s^2]; level at rest (0, 0, -g).
            valid: False if they were not measured at this sample; they are then not looked at.

        Raises:
            ValueError: a valid reading that is not finite or far beyond any range; the filter is as it was.
        """
        known = self._known
        (p, q, r), (x, y, z) = gyro, accelerometer
        if not attitude_step(self._memory, p, q, r, x, y, z, valid, self._box):
            told = f"gyro {tuple(gyro)!r}, accelerometer {tuple(accelerometer)!r}"
            raise ValueError(f"{told} (allowed: finite, together up to {LARGEST:g})")
        self.skipped += not valid
        self._known = bool(self._memory[AttitudeMemory.known])
        self.lost += known and not self._known

    @property
    def known(self) -> bool:
        """Whether there is an attitude."""
        return self._known

    @property
    def message(self) -> Array:
        """(37,) attitude, rates and variances as the numbers of an Imu in ENU/FLU."""
        values = np.empty(_IMU)
        read_attitude(self._memory, values)
        return values

    @property
    def attitude(self) -> Euler:
        """Yaw and roll in -pi .. pi, pitch [rad]; zeros while unknown."""
        return Euler(*self._three(AttitudeMemory.psi))

    @property
    def bias(self) -> Vector3:
        """Of gyros x, y, z, body FRD [rad/s]."""
        return self._three(AttitudeMemory.gyro_bias)

    @property
    def accelerometer_bias(self) -> Vector3:
        """Of accelerometers x, y, z, body FRD [m/s^2]; as good as the angles given to start from."""
        return self._three(AttitudeMemory.force_bias)

    @property
    def sigma(self) -> tuple[float, ...]:
        """(6,) predicted standard deviations of psi, theta, phi [rad] and of the gyros' biases [rad/s].

        Those of unknown angles are the root of UNKNOWN_VARIANCE.
        """
        first = AttitudeMemory.covariance
        variances = self._memory[first : first + 6 * (ROWS + 1) : ROWS + 1].tolist()
        if not self.known:
            variances[:3] = (UNKNOWN_VARIANCE,) * 3
        return tuple(math.sqrt(variance) for variance in variances)

    @property
    def covariance(self) -> Array:
        """(9, 9) of psi, theta, phi, gyro biases and accelerometer biases; angles are zero while unknown."""
        return self._memory[AttitudeMemory.covariance : AttitudeMemory.end].reshape(ROWS, ROWS).copy()

    @property
    def standstills(self) -> int:
        """Windows of 0.5 s in which the helicopter stood, so far."""
        return int(self._memory[AttitudeMemory.standstills])

    @property
    def memory(self) -> Array:
        """All that the filter remembers, in the parts of `AttitudeMemory`."""
        return self._memory.copy()

    def _three(self, first: int) -> Vector3:
        x, y, z = self._memory[first : first + 3].tolist()
        return x, y, z
