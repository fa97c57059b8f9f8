"""What can go wrong on the bench on request: seven kinds of fault, when they act, what is published of them.

A fault acts at every sample from its start until before its end; without an end, until the flight ends. Each
kind is visible in ground truth: `fault_values` gives one number per name of `FAULT_FIELDS`, 0 where all is
well. Several faults of one kind may act at once: counts, bias and delay add up, what is left of the supply's
voltage multiplies, masks join.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from heli_common.rig_geometry import ENCODER_NAMES
from heli_common.topics import FAULT_FIELDS, IMU_AXES

SERVO_NAMES = ("1", "2", "3", "tail")
"""The servos in the order of their shafts."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Something that goes wrong: from its start until before its end, in simulated time."""

    kind: ClassVar[str]
    start_ns: int
    """stamp of its start [ns]"""
    end_ns: int | None = None
    """stamp of its end [ns]; None for a fault that stays"""

    def acts(self, stamp_ns: int) -> bool:
        """Whether it acts on the sample of this stamp [ns]."""
        return self.start_ns <= stamp_ns and (self.end_ns is None or stamp_ns < self.end_ns)


@dataclass(frozen=True, kw_only=True)
class EncoderStuck(Fault):
    """One encoder gives the count of the fault's first sample; afterwards the true count again."""

    kind: ClassVar[str] = "encoder_stuck"
    encoder: str
    """one of `ENCODER_NAMES`"""

    @property
    def index(self) -> int:
        """Place of the encoder among the six."""
        return ENCODER_NAMES.index(self.encoder)


@dataclass(frozen=True, kw_only=True)
class EncoderLostCounts(Fault):
    """One counter jumps at the start and stays off; no index pulse sets it right, so it never ends."""

    kind: ClassVar[str] = "encoder_lost_counts"
    encoder: str
    """one of `ENCODER_NAMES`"""
    counts: int
    """added to what the encoder says, not 0"""

    @property
    def index(self) -> int:
        """Place of the encoder among the six."""
        return ENCODER_NAMES.index(self.encoder)


@dataclass(frozen=True, kw_only=True)
class ImuDropout(Fault):
    """The IMU gives its last sample again, marked invalid."""

    kind: ClassVar[str] = "imu_dropout"


@dataclass(frozen=True, kw_only=True)
class ImuBiasJump(Fault):
    """The bias of one IMU axis jumps, and back at the end."""

    kind: ClassVar[str] = "imu_bias_jump"
    axis: str
    """one of `IMU_AXES`"""
    size: float
    """of the jump, body FRD [rad/s] or [m/s^2], not 0"""

    @property
    def index(self) -> int:
        """Place of the axis among the six."""
        return IMU_AXES.index(self.axis)


@dataclass(frozen=True, kw_only=True)
class ServoJam(Fault):
    """One shaft holds the angle that was commanded when the jam began."""

    kind: ClassVar[str] = "servo_jam"
    servo: str
    """one of `SERVO_NAMES`"""

    @property
    def index(self) -> int:
        """Place of the servo among the four."""
        return SERVO_NAMES.index(self.servo)


@dataclass(frozen=True, kw_only=True)
class SupplySag(Fault):
    """The motor's supply gives only a part of the voltage asked for."""

    kind: ClassVar[str] = "supply_sag"
    fraction: float
    """of the voltage that is left, 0 or more, below 1"""


@dataclass(frozen=True, kw_only=True)
class LinkDelay(Fault):
    """Servo commands take longer through the serial link."""

    kind: ClassVar[str] = "link_delay"
    delay_ns: int
    """additional dead time [ns], whole samples, above 0"""


FAULT_KINDS: dict[str, type[Fault]] = {
    kind.kind: kind
    for kind in (EncoderStuck, EncoderLostCounts, ImuDropout, ImuBiasJump, ServoJam, SupplySag, LinkDelay)
}
"""All kinds by their names in plans and requests."""


@dataclass(frozen=True)
class FaultSchedule:
    """Faults in the order in which they were written down; it never changes."""

    faults: tuple[Fault, ...] = ()

    def acting(self, stamp_ns: int) -> tuple[Fault, ...]:
        """The faults that act on the sample of this stamp [ns], those that began first in front."""
        acting = [fault for fault in self.faults if fault.acts(stamp_ns)]
        return tuple(sorted(acting, key=lambda fault: fault.start_ns))

    def changes(self) -> tuple[int, ...]:
        """Stamps at which a fault begins or ends [ns], ascending."""
        starts = {fault.start_ns for fault in self.faults}
        ends = {fault.end_ns for fault in self.faults if fault.end_ns is not None}
        return tuple(sorted(starts | ends))

    def with_fault(self, fault: Fault) -> FaultSchedule:
        """The schedule with one more fault at its end."""
        return FaultSchedule((*self.faults, fault))


NO_FAULTS = FaultSchedule()


def fault_values(acting: Iterable[Fault]) -> tuple[float, ...]:
    """Numbers that describe the acting faults, in the order of `FAULT_FIELDS`; all 0 when nothing is wrong.

    `encoder_stuck`, `encoder_lost_counts` and `servo_jam` are sums of 2^index over encoders and servos,
    `imu_dropout` is 1, `supply_sag` the fraction of the voltage that is missing, `link_delay` in s. A bias
    jump is no number of its own: it shows in the biases of the IMU.

    Args:
        acting: what `FaultSchedule.acting` gives.
    """
    masks: dict[type[Fault], int] = {EncoderStuck: 0, EncoderLostCounts: 0, ServoJam: 0}
    values = dict.fromkeys(FAULT_FIELDS, 0.0)
    left = 1.0
    for fault in acting:
        match fault:
            case EncoderStuck() | EncoderLostCounts() | ServoJam():
                masks[type(fault)] |= 1 << fault.index
            case ImuDropout():
                values["imu_dropout"] = 1.0
            case SupplySag():
                left *= fault.fraction
            case LinkDelay():
                values["link_delay"] += fault.delay_ns / 1e9
    values |= {kind.kind: float(mask) for kind, mask in masks.items()}
    values["supply_sag"] = 1.0 - left
    return tuple(values.values())
