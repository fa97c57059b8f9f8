"""What the acting faults do to counts, IMU, shafts, supply and serial link, sample by sample.

The bench hands over what it would give or do without faults and goes on with what comes back. Stamps never
go back; whatever a fault holds is taken at the fault's first sample, so while a fault acts the bench asks at
every sample of 2.5 ms. While `quiet`, it may skip all of this.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.faults import (
    NO_FAULTS,
    EncoderLostCounts,
    EncoderStuck,
    Fault,
    FaultSchedule,
    ImuBiasJump,
    ImuDropout,
    LinkDelay,
    ServoJam,
    SupplySag,
    fault_values,
)
from heli_common.rig_geometry import ENCODER_NAMES
from heli_common.topics import IMU_AXES

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

SUPPLY_RANGE = 10.0
"""Control voltage beyond which the supply gives no more [V] (T)."""


class FaultEffects:
    """The faults of one bench and what they hold.

    Args:
        schedule: known from the beginning; more may be added while flying.
    """

    def __init__(self, schedule: FaultSchedule = NO_FAULTS) -> None:
        self._schedule = schedule
        self._until_ns: float = -math.inf
        self._held_counts: dict[Fault, int] = {}
        self._held_indexed: dict[Fault, bool] = {}
        self._held_shafts: dict[Fault, float] = {}
        self._renew(-1)

    # Which faults --------------------------------------------------------------------------------------

    @property
    def schedule(self) -> FaultSchedule:
        """All faults so far, those added while flying included."""
        return self._schedule

    @property
    def any(self) -> bool:
        """Whether there is any fault at all, past or coming."""
        return bool(self._schedule.faults)

    def add(self, fault: Fault) -> None:
        """One more fault; it acts from its start on, or at once if that is past.

        Args:
            fault: of any kind.
        """
        self._schedule = self._schedule.with_fault(fault)
        self._until_ns = -math.inf

    def acting(self, stamp_ns: int) -> tuple[Fault, ...]:
        """The faults that act on the sample of this stamp [ns], those that began first in front."""
        if stamp_ns >= self._until_ns:
            self._renew(stamp_ns)
        return self._acting

    def quiet(self, stamp_ns: int) -> bool:
        """Whether nothing is wrong at this stamp [ns]."""
        return not self.acting(stamp_ns)

    def values(self, stamp_ns: int) -> tuple[float, ...]:
        """(6,) numbers for ground truth at this stamp [ns], in the order of `FAULT_FIELDS`."""
        self.acting(stamp_ns)
        return self._values

    def _renew(self, stamp_ns: int) -> None:
        """Sum up what acts from this stamp until the next change."""
        coming = (change for change in self._schedule.changes() if change > stamp_ns)
        self._until_ns = next(coming, math.inf)
        acting = self._schedule.acting(stamp_ns)
        self._acting, self._values = acting, fault_values(acting)
        self._stuck = [fault for fault in acting if isinstance(fault, EncoderStuck)]
        self._jams = [fault for fault in acting if isinstance(fault, ServoJam)]
        self._valid = not any(isinstance(fault, ImuDropout) for fault in acting)
        self._offset = np.zeros(len(ENCODER_NAMES), dtype=np.int64)
        self._bias = np.zeros(len(IMU_AXES))
        self._fraction, self._delay_ns = 1.0, 0
        for fault in acting:
            match fault:
                case EncoderLostCounts():
                    self._offset[fault.index] += fault.counts
                case ImuBiasJump():
                    self._bias[fault.index] += fault.size
                case SupplySag():
                    self._fraction *= fault.fraction
                case LinkDelay():
                    self._delay_ns += fault.delay_ns
        self._bias.setflags(write=False)

    # What they do --------------------------------------------------------------------------------------

    def counts(self, stamp_ns: int, counts: Counts) -> Counts:
        """What the encoders say: lost counts are missing, a stuck encoder says what it said at first.

        Args:
            stamp_ns: of the sample [ns].
            counts: (6,) true counts, in the order of `ENCODER_NAMES`; left as they are.

        Returns:
            (6,) counts with the faults in them; the very argument if none acts.
        """
        if self.quiet(stamp_ns):
            return counts
        said = counts + self._offset
        for fault in self._stuck:
            said[fault.index] = self._held_counts.setdefault(fault, int(said[fault.index]))
        return said

    def indexed(self, stamp_ns: int, indexed: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether each encoder says that its index has passed: a stuck one sees no index pulse.

        Args:
            stamp_ns: of the sample [ns].
            indexed: (6,) true flags; left as they are.

        Returns:
            (6,) flags with the faults in them; the very argument if no encoder is stuck.
        """
        if self.quiet(stamp_ns) or not self._stuck:
            return indexed
        said = indexed.copy()
        for fault in self._stuck:
            said[fault.index] = self._held_indexed.setdefault(fault, bool(said[fault.index]))
        return said

    def bias_jump(self, stamp_ns: int) -> Array:
        """(6,) additional bias of the IMU, gyros [rad/s] then accelerometers [m/s^2], body FRD; read only."""
        self.acting(stamp_ns)
        return self._bias

    def imu_valid(self, stamp_ns: int) -> bool:
        """Whether the IMU gives a new sample at this stamp [ns]; if not, the last one again, invalid."""
        self.acting(stamp_ns)
        return self._valid

    def shafts(self, stamp_ns: int, commanded: Array) -> Array:
        """Where the servos are really going: a jammed one holds what was commanded when the jam began.

        Args:
            stamp_ns: of the sample [ns].
            commanded: (4,) shaft angles latched now [rad], in the order of `SERVO_NAMES`; left as they are.

        Returns:
            (4,) shaft angles [rad]; the very argument if no servo is jammed.
        """
        if self.quiet(stamp_ns) or not self._jams:
            return commanded
        real = commanded.copy()
        for fault in self._jams:
            real[fault.index] = self._held_shafts.setdefault(fault, float(real[fault.index]))
        return real

    def voltage(self, stamp_ns: int, voltage: float) -> float:
        """Control voltage that takes effect [V]: during a sag the part that is left of what the supply gives.

        Args:
            stamp_ns: of the sample [ns].
            voltage: control voltage asked for [V]; a sagging supply first limits it to 0 .. 10 V.
        """
        if self.quiet(stamp_ns) or self._fraction == 1.0:
            return voltage
        return min(max(voltage, 0.0), SUPPLY_RANGE) * self._fraction

    def link_delay_ns(self, stamp_ns: int) -> int:
        """Additional dead time of servo commands at this stamp [ns]."""
        self.acting(stamp_ns)
        return self._delay_ns
