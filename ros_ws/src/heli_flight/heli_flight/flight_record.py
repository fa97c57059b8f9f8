"""A recorded flight as arrays in SI units, earth NED and body FRD: the way back from ROS conventions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from heli_common.errors import InputError
from heli_common.flight_state import FlightState, flight_state_from_code
from heli_common.topics import SERVO_CHANNELS, TOPICS
from heli_common.vehicle_state import UNKNOWN_VARIANCE
from heli_flight.bag_reader import Bag, read_bag
from heli_flight.flight_hash import canonical_messages
from heli_flight.packed import read_layout

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]


def seconds(stamps: Stamps) -> Array:
    """Simulated time [s] of stamps [ns]."""
    return np.asarray(stamps * 1e-9, dtype=np.float64)


def swap_earth(vectors: Array) -> Array:
    """ENU to NED or NED to ENU, shape (n, 3)."""
    return np.column_stack((vectors[:, 1], vectors[:, 0], -vectors[:, 2]))


def swap_body(vectors: Array) -> Array:
    """FLU to FRD or FRD to FLU, shape (n, 3)."""
    return np.column_stack((vectors[:, 0], -vectors[:, 1], -vectors[:, 2]))


def attitude_ned(quaternions: Array) -> Array:
    """Yaw, pitch, roll [rad], shape (n, 3), of quaternions (x, y, z, w) FLU to ENU, shape (n, 4).

    A quaternion that is no rotation gives NaN.
    """
    length = np.linalg.norm(quaternions, axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y, z, w = (quaternions / np.where(length > 1e-9, length, np.nan)).T
    # vehicle_state.attitude_ned's product of three quaternions, written out
    half = np.sqrt(0.5)
    x, y, z, w = -half * (x + y), half * (y - x), half * (z - w), -half * (w + z)
    sin_theta = np.clip(2.0 * (w * y - z * x), -1.0, 1.0)
    upright = np.abs(sin_theta) > 1.0 - 1e-12
    psi = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    phi = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    psi = np.where(upright, np.arctan2(-2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z)), psi)
    return np.column_stack((psi, np.arcsin(sin_theta), np.where(upright, 0.0, phi)))


@dataclass(frozen=True)
class Series:
    """One topic over time.

    Attributes:
        stamps: [ns], shape (n,), ascending.
        values: as on the wire, shape (n, number of fields).
        fields: name of every column.
    """

    stamps: Stamps
    values: Array
    fields: tuple[str, ...]

    @property
    def time(self) -> Array:
        """Simulated time [s], shape (n,)."""
        return seconds(self.stamps)

    def column(self, field: str) -> Array:
        """One number over time, shape (n,).

        Raises:
            ValueError: no such field.
        """
        return self.values[:, self.fields.index(field)]

    def columns(self, fields: tuple[str, ...]) -> Array:
        """Several numbers over time, shape (n, len(fields))."""
        return self.values[:, [self.fields.index(field) for field in fields]]


@dataclass(frozen=True)
class Motion:
    """Where the helicopter is and how it moves; arrays of n rows.

    Attributes:
        stamps: [ns].
        position: earth NED [m].
        attitude: yaw, pitch, roll [rad].
        velocity: against the earth in body FRD [m/s].
        rates: p, q, r in body FRD [rad/s].
        known: whether the pose is absolute.
    """

    stamps: Stamps
    position: Array
    attitude: Array
    velocity: Array
    rates: Array
    known: NDArray[np.bool_]

    @property
    def time(self) -> Array:
        """Simulated time [s], shape (n,)."""
        return seconds(self.stamps)


@dataclass(frozen=True)
class Stage:
    """An uninterrupted stretch of one flight state, from its first to the next one's first stamp [ns]."""

    state: FlightState
    start_ns: int
    end_ns: int

    @property
    def duration(self) -> float:
        """Seconds."""
        return (self.end_ns - self.start_ns) * 1e-9


class FlightRecord:
    """A flight read from its bag.

    Args:
        bag: as read.

    Raises:
        InputError: a message is not of its topic's layout.
    """

    def __init__(self, bag: Bag) -> None:
        self.bag = bag
        self.series: dict[str, Series] = {}
        for name, topic in TOPICS.items():
            messages = bag.messages.get(name, [])
            layout = topic.layout
            try:
                stamps, values = read_layout(layout, canonical_messages(layout, messages) if messages else [])
            except ValueError as error:
                raise InputError(str(error), file=bag.folder, key=name) from None
            if (np.diff(stamps) < 0).any():
                order = np.argsort(stamps, kind="stable")
                stamps, values = stamps[order], values[order]
            self.series[name] = Series(stamps, values, layout.fields)

    @classmethod
    def load(cls, folder: Path) -> FlightRecord:
        """Read a bag's folder.

        Raises:
            InputError: no bag, or a message is not of its topic's layout.
        """
        return cls(read_bag(folder))

    @property
    def custom_data(self) -> dict[str, str]:
        """The recorder's remarks, see `bag_metadata`."""
        return self.bag.custom_data

    @cached_property
    def truth(self) -> Motion:
        """The motion as it was (`ground_truth`)."""
        return motion_of(self.series["ground_truth"])

    @cached_property
    def estimate(self) -> Motion:
        """The motion as navigation saw it (`odometry`)."""
        return motion_of(self.series["odometry"])

    @cached_property
    def reference(self) -> tuple[Stamps, Array]:
        """Stamps [ns] and pose reference: north, east, down [m] and yaw [rad], shape (n, 4)."""
        series = self.series["reference"]
        position = swap_earth(series.values[:, 0:3])
        return series.stamps, np.column_stack((position, attitude_ned(series.values[:, 3:7])[:, 0]))

    @cached_property
    def velocity_reference(self) -> tuple[Stamps, Array]:
        """Stamps [ns] and reference of u, v, w [m/s] in heading axes and of the yaw rate [rad/s], (n, 4)."""
        series = self.series["velocity_reference"]
        linear, angular = swap_body(series.values[:, 0:3]), swap_body(series.values[:, 3:6])
        return series.stamps, np.column_stack((linear, angular[:, 2]))

    @cached_property
    def servo_command(self) -> tuple[Stamps, Array]:
        """Stamps [ns] and commanded B_1s, A_1s, theta_0, theta_t [rad], shape (n, 4)."""
        return self._positions("servo_command")

    @cached_property
    def actuator_state(self) -> tuple[Stamps, Array]:
        """Stamps [ns] and true B_1s, A_1s, theta_0, theta_t [rad], shape (n, 4)."""
        return self._positions("actuator_state")

    @cached_property
    def rotor_speed(self) -> tuple[Stamps, Array]:
        """Stamps [ns] and measured rotor speed [rad/s], shape (n,)."""
        series = self.series["rotor"]
        return series.stamps, series.column("velocity.rotor")

    @cached_property
    def rotor_reference(self) -> tuple[Stamps, Array]:
        """Stamps [ns] and the supervisor's rotor speed reference [rad/s], shape (n,)."""
        series = self.series["flight_state"]
        return series.stamps, series.column("velocity.rotor")

    @cached_property
    def motor_voltage(self) -> tuple[Stamps, Array]:
        """Stamps [ns] and control voltage of the motor [V], shape (n,)."""
        series = self.series["motor_command"]
        return series.stamps, series.column("effort.motor")

    @cached_property
    def stages(self) -> tuple[Stage, ...]:
        """The flight's stages one after the other; the last ends one period after the last stamp.

        Raises:
            InputError: a state's code is none of those agreed.
        """
        series = self.series["flight_state"]
        codes = series.column("position.flight_state")
        try:
            return stages_of(series.stamps, codes)
        except ValueError as error:
            raise InputError(str(error), file=self.bag.folder, key="flight_state") from None

    @property
    def span(self) -> tuple[float, float]:
        """First and last stamp of anything recorded [s]; (0, 0) of an empty bag."""
        known = [series.stamps for series in self.series.values() if len(series.stamps)]
        if not known:
            return 0.0, 0.0
        return min(s[0] for s in known) * 1e-9, max(s[-1] for s in known) * 1e-9

    def _positions(self, topic: str) -> tuple[Stamps, Array]:
        series = self.series[topic]
        return series.stamps, series.columns(tuple(f"position.{name}" for name in SERVO_CHANNELS))


class Flown(Protocol):
    """What figures of merit need of a flight, recorded or not."""

    @property
    def truth(self) -> Motion:
        """The motion as it was."""

    @property
    def reference(self) -> tuple[Stamps, Array]:
        """Stamps [ns] and pose reference: north, east, down [m] and yaw [rad], shape (n, 4)."""

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The flight's stages one after the other."""


def stages_of(stamps: Stamps, codes: Array) -> tuple[Stage, ...]:
    """The stages of a flight; the last ends one period after the last stamp.

    Args:
        stamps: [ns], shape (n,).
        codes: of the state at each, shape (n,).

    Raises:
        ValueError: a state's code is none of those agreed.
    """
    if not len(codes):
        return ()
    starts = np.flatnonzero(np.concatenate(([True], codes[1:] != codes[:-1])))
    ends = [*stamps[starts[1:]].tolist(), int(stamps[-1]) + TOPICS["flight_state"].period_ns]
    states = [flight_state_from_code(codes[index]) for index in starts.tolist()]
    begins = stamps[starts].tolist()
    return tuple(Stage(*stage) for stage in zip(states, begins, ends, strict=True))


def motion_of(series: Series) -> Motion:
    """The motion in the messages of an odometry topic."""
    values = series.values
    return Motion(
        series.stamps,
        swap_earth(values[:, 0:3]),
        attitude_ned(values[:, 3:7]),
        swap_body(values[:, 43:46]),
        swap_body(values[:, 46:49]),
        values[:, 7] < 0.5 * UNKNOWN_VARIANCE,
    )
