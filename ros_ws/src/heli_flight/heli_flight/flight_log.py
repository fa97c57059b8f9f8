"""What a campaign keeps of a flight: a row per control tick, and one hash of it that bags have, too."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heli_common.flight_state import flight_state_from_code
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import TOPICS
from heli_flight.flight_record import FlightRecord, Motion, Stage, Stamps, attitude_ned, swap_earth

Array = NDArray[np.float64]

LOGGED = ("ground_truth", "reference", "servo_command", "motor_command", "flight_state", "rotor_state")
"""Topics a log can be made of."""


@dataclass(eq=False)
class FlightLog:
    """One flight.

    Attributes:
        truth: (n, 6) north, east, down [m], yaw, pitch, roll [rad] as they were.
        reference: (n, 4) north, east, down [m], yaw [rad] asked for.
        command: (n, 5) servo command [rad] and control voltage [V].
        state: (n,) codes of the stages.
        rotor: (n, 2) reference and measured rotor speed [rad/s].
        reason: why the flight ended early, or an empty string.
        remarks: of the bench: where the model did not hold.
    """

    truth: Array
    reference: Array
    command: Array
    state: NDArray[np.int64]
    rotor: Array
    reason: str = ""
    remarks: dict[str, str] = field(default_factory=dict)

    @classmethod
    def blank(cls, rows: int) -> FlightLog:
        """Room for so many ticks."""
        return cls(
            np.zeros((rows, 6)),
            np.zeros((rows, 4)),
            np.zeros((rows, 5)),
            np.zeros(rows, dtype=np.int64),
            np.zeros((rows, 2)),
        )

    def resized(self, rows: int) -> FlightLog:
        """The same with room for so many ticks; fewer than before cut it."""
        other = FlightLog.blank(rows)
        kept = min(rows, len(self.state))
        for name in ("truth", "reference", "command", "state", "rotor"):
            getattr(other, name)[:kept] = getattr(self, name)[:kept]
        other.reason, other.remarks = self.reason, self.remarks
        return other

    @property
    def trace(self) -> str:
        """SHA-256 of the true positions, the commands and the stages: every bit of them, 64 hex digits."""
        digest = hashlib.sha256()
        for part in (self.truth[:, :3], self.command, self.state):
            # 0.0 + x: a zero is a zero, whatever sign its way through a message gave it
            digest.update(np.ascontiguousarray(0.0 + part).tobytes())
        return digest.hexdigest()

    # As `FlightRecord` gives them, for `metrics` ----------------------------------------------------------

    @cached_property
    def stamps(self) -> Stamps:
        """(n,) of the control ticks [ns]."""
        return np.arange(len(self.state), dtype=np.int64) * CONTROL_PERIOD_NS

    @property
    def motion(self) -> Motion:
        """Pose alone; velocities are not kept."""
        none = np.zeros((len(self.state), 3))
        known = np.ones(len(self.state), dtype=np.bool_)
        return Motion(self.stamps, self.truth[:, :3], self.truth[:, 3:], none, none, known)

    @cached_property
    def stages(self) -> tuple[Stage, ...]:
        """The flight's stages one after the other."""
        if not len(self.state):
            return ()
        starts = [0, *(np.flatnonzero(np.diff(self.state)) + 1).tolist()]
        ends = [*starts[1:], len(self.state)]
        return tuple(
            Stage(flight_state_from_code(self.state[a]), a * CONTROL_PERIOD_NS, b * CONTROL_PERIOD_NS)
            for a, b in zip(starts, ends, strict=True)
        )


def log_of_values(values: Mapping[str, Array]) -> FlightLog:
    """The log of what was sent on the topics of `LOGGED`.

    Args:
        values: (n, fields) of each topic, in the order of sending; a tick that is not complete is left out.
    """
    rows = min(len(values[name]) for name in LOGGED)
    sent = {name: values[name][:rows] for name in LOGGED}
    truth, wanted = sent["ground_truth"], sent["reference"]
    fields = TOPICS["flight_state"].layout.fields
    speed = fields.index("velocity.rotor")
    return FlightLog(
        np.column_stack((swap_earth(truth[:, :3]), attitude_ned(truth[:, 3:7]))),
        np.column_stack((swap_earth(wanted[:, :3]), attitude_ned(wanted[:, 3:7])[:, 0])),
        np.column_stack((sent["servo_command"][:, :4], sent["motor_command"][:, 2])),
        sent["flight_state"][:, fields.index("position.flight_state")].astype(np.int64),
        np.column_stack((sent["flight_state"][:, speed], sent["rotor_state"][:, 1])),
    )


def log_of_bag(record: FlightRecord) -> FlightLog:
    """The log of a recorded flight."""
    log = log_of_values({name: record.series[name].values for name in LOGGED})
    log.reason = record.custom_data.get("result", "")
    return log
