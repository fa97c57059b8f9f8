"""Motor controller: PI on rotor speed with anti-windup from the saturation (source sec. 3.1.1, spec 3.1).

The drive as the controller sees it, control voltage U to rotor speed Omega (spec 1.3), with the gear ratio n:

    I = (k_U U - K n Omega) / R_a,   0 <= I <= I_max,      I_R Omega' = n K I - load

About hover, where the load's torque grows with twice itself over Omega, this is 133 / (s + 5) (rad/s)/V. A PI
controller with T_i = 1 / (5 1/s) cancels the pole and leaves K_p 133 / s: K_p = 0.1 V s/rad gives 13 rad/s.
The lags of torque (13 ms), measurement (6 ms) and command (10 ms) leave a phase margin of 68 deg.

The supply cannot brake and holds its current limit, so the voltage acts only within

    K n Omega / k_U <= U <= (K n Omega + R_a I_max) / k_U

At hover that is 4.9 .. 5.6 V around 5.5 V. The integral is fed back from this saturation:

    integral' = K_p / T_i e + K_AW (saturated(U) - U)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp
from typing import NamedTuple

from heli_common import topics
from heli_common.component import Message, StampJoin
from heli_common.finite import require_finite
from heli_common.flight_state import FlightState
from heli_common.linear_model import StateSpace
from heli_common.quantities import quantity
from heli_common.timing import CONTROL_PERIOD
from heli_control.received import flight_state

_ROTOR_SPEED = topics.TOPICS["rotor_state"].layout.fields.index("velocity.rotor")


@dataclass(frozen=True)
class MotorParameters:
    """PI controller, and the drive's data that say where it saturates.

    The source's own K_p 0.0016, T_i 0.0315 s and K_AW 400 belong to its units and its identified drive.
    """

    gain: float = quantity(0.1, "V s/rad", "D", "gain K_p, for 13 rad/s", 0.0, 10.0)
    integral_time: float = quantity(0.2, "s", "D", "integral time T_i, cancels the drive's pole", 0.01, 100.0)
    antiwindup: float = quantity(20.0, "1/s", "D", "feedback K_AW from the saturation", 0.0, 100.0)
    voltage_limit: float = quantity(10.0, "V", "T", "largest control voltage", 0.1, 10.0)
    supply_gain: float = quantity(4.0, "V/V", "T", "supply voltage per control voltage", 0.1, 100.0)
    current_limit: float = quantity(60.0, "A", "T", "current limit of the supply", 0.0, 1000.0)
    resistance: float = quantity(0.0467, "ohm", "R", "armature resistance", 0.0, 10.0)
    torque_constant: float = quantity(
        0.0150, "N m/A", "R", "torque constant, also of the back-EMF", 0.0, 10.0
    )
    gear_ratio: float = quantity(8.0, "-", "R", "motor turns per rotor turn", 0.1, 100.0)


class GovernorConstants(NamedTuple):
    """What the controller needs at every sample."""

    gain: float
    """K_p [V s/rad]"""
    integral_gain: float
    """K_p / T_i [V/rad]"""
    antiwindup: float
    """K_AW [1/s]"""
    limit: float
    """largest control voltage [V]"""
    back_emf: float
    """control voltage per rotor speed without current [V s/rad]"""
    current_room: float
    """control voltage that the largest current takes [V]"""


def govern(integral: float, reference: float, speed: float, c: GovernorConstants) -> tuple[float, float]:
    """Control voltage [V], 0 .. limit, and the integral for the next sample; compiled code may call it.

    Args:
        integral: integral part of the voltage [V].
        reference: rotor speed wanted [rad/s].
        speed: rotor speed measured [rad/s].
        c: constants of the controller.
    """
    error = reference - speed
    asked = c.gain * error + integral
    without_current = c.back_emf * speed
    lowest = min(max(without_current, 0.0), c.limit)
    highest = min(max(without_current + c.current_room, 0.0), c.limit)
    saturated = min(max(asked, lowest), highest)
    integral += CONTROL_PERIOD * (c.integral_gain * error + c.antiwindup * (saturated - asked))
    return min(max(asked, 0.0), c.limit), integral


class SpeedGovernor:
    """The PI controller.

    Args:
        parameters: gains and drive data.

    Attributes:
        integral: integral part of the voltage [V].
        constants: of the controller.
    """

    def __init__(self, parameters: MotorParameters) -> None:
        p = parameters
        self.integral = 0.0
        self.constants = GovernorConstants(
            gain=p.gain,
            integral_gain=p.gain / p.integral_time,
            antiwindup=p.antiwindup,
            limit=p.voltage_limit,
            back_emf=p.torque_constant * p.gear_ratio / p.supply_gain,
            current_room=p.resistance * p.current_limit / p.supply_gain,
        )

    def step(self, reference: float, speed: float) -> float:
        """Control voltage of this sample [V], 0 .. limit; the integral goes on to the next.

        Args:
            reference: rotor speed wanted [rad/s].
            speed: rotor speed measured [rad/s].
        """
        voltage, self.integral = govern(self.integral, reference, speed, self.constants)
        return voltage

    def reset(self) -> None:
        """Forget the integral."""
        self.integral = 0.0


def governor_law(parameters: MotorParameters, bandwidth: float, speed: str) -> StateSpace:
    """The governor within its limits at 100 Hz, behind the low-pass of the navigation.

        f = f- + (1 - exp(-omega T)) (Omega - f-),  U = I - K_p f,  I+ = I - K_p T / T_i f

    Args:
        parameters: gains.
        bandwidth: omega of the low-pass [rad/s].
        speed: name of the rotor speed that goes in.

    Returns:
        rotor speed to control voltage, `U_mot`, both as deviations.
    """
    kept = exp(-bandwidth * CONTROL_PERIOD)
    gain, rate = parameters.gain, parameters.gain * CONTROL_PERIOD / parameters.integral_time
    return StateSpace(
        ("speed_filtered", "integral_speed"),
        (speed,),
        ("U_mot",),
        [[kept, 0.0], [-rate * kept, 1.0]],  # type: ignore[arg-type]
        [[1.0 - kept], [-rate * (1.0 - kept)]],  # type: ignore[arg-type]
        [[-gain * kept, 1.0]],  # type: ignore[arg-type]
        [[-gain * (1.0 - kept)]],  # type: ignore[arg-type]
    )


class MotorController:
    """Component: rotor state and flight state in, motor command out.

    Without a reference, when idle and when the flight has ended the voltage is exactly zero.

    Args:
        parameters: gains and drive data.
    """

    name = topics.MOTOR_CONTROLLER
    inputs: tuple[str, ...] = ("rotor_state", "flight_state")
    waking: tuple[str, ...] = ("flight_state",)
    outputs: tuple[str, ...] = ("motor_command",)

    def __init__(self, parameters: MotorParameters) -> None:
        self._governor = SpeedGovernor(parameters)
        self._join = StampJoin(self.inputs)

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Take in one message; when both inputs of a stamp are there, the motor command.

        Raises:
            ValueError: another topic, a number that is not finite, or no such flight state.
        """
        require_finite(topic, values)
        ready = self._join.add(topic, stamp_ns, values)
        if ready is None:
            return []
        stage, reference = flight_state(ready["flight_state"])
        if reference <= 0.0 or stage is FlightState.IDLE or stage.ended:
            self._governor.reset()
            voltage = 0.0
        else:
            voltage = self._governor.step(reference, ready["rotor_state"][_ROTOR_SPEED])
        message = (0.0, 0.0, voltage)
        require_finite("motor_command", message)
        return [Message("motor_command", stamp_ns, message)]
