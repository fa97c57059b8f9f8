"""What a flight recorded, as plain columns: the form in which data enter this package."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Channel:
    """One quantity over time.

    Attributes:
        stamps: [ns], shape (N,), ascending.
        values: SI, shape (N,).
    """

    stamps: Stamps
    values: Array


@dataclass(frozen=True, eq=False)
class FlightSignals:
    """The signals of one flight, NED and FRD.

    Attributes:
        name: of the flight, for messages.
        measured: by name: theta phi u v w q p r [rad, m/s, rad/s], Omega [rad/s].
        actuators: what the actuators did, by input name: B_1s A_1s theta_0 theta_t [rad], U_mot [V].
        commands: what they were told, external signal included, same names.
        excitation: the external signal on the commands, same names; may be empty.
    """

    name: str
    measured: Mapping[str, Channel]
    actuators: Mapping[str, Channel]
    commands: Mapping[str, Channel]
    excitation: Mapping[str, Channel] = field(default_factory=dict)
