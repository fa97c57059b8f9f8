"""The simulated bench: commands in, 2.5 ms of motion, readings out; no ROS, no clock.

It begins at rest on the lower stop, rotor stopped, attitude zero. All values are SI, earth NED from the
flight-space centre, body FRD at the centre of gravity. Readings are copies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import helicopter, homing_hand, lower_stop, rigid_body, servos
from heli_bench_sim.actuators import ActuatorState, actual_inputs, actuator_state
from heli_bench_sim.bench_parameters import BenchParameters, bench_constants
from heli_bench_sim.delta_arm import ARMS, arm_angles
from heli_bench_sim.encoders import ENCODERS, EncoderReading, Encoders
from heli_bench_sim.helicopter import Loads, Validity
from heli_bench_sim.motion import (
    BENCH_STATE_SIZE,
    COMMAND_SIZE,
    NO_HAND,
    WORK_ROWS,
    BenchState,
    Hand,
    advance,
    later,
)
from heli_bench_sim.servos import SERVOS
from heli_bench_sim.states import INPUT_SIZE, STATE_SIZE, Input, State
from heli_common.rotations import Euler, Vector3
from heli_common.timing import SENSOR_PERIOD, SENSOR_PERIOD_NS

__all__ = ["INTEGRATION_STEPS", "ActuatorState", "Bench", "BenchParameters"]

Array = NDArray[np.float64]

INTEGRATION_STEPS = 2
"""Runge-Kutta steps per sensor period of 2.5 ms; the README gives the step-size study."""


class Bench:
    """One bench with its whole state.

    Args:
        parameters: what it is built from.
        seed: of every random number of the bench; nothing in it is random yet.
    """

    def __init__(self, parameters: BenchParameters | None = None, seed: int = 1) -> None:
        self.parameters = parameters or BenchParameters()
        self.seed = seed
        self._constants = bench_constants(self.parameters)
        self._work = np.empty((WORK_ROWS, BENCH_STATE_SIZE))
        self._wind = np.zeros(3)
        self._hand = NO_HAND
        self._homing = False
        self._stamp_ns = 0
        self._state = np.zeros(BENCH_STATE_SIZE)
        self._state[State.z] = self.parameters.geometry.rest_depth
        self._command = np.zeros(COMMAND_SIZE)
        self.set_servo_command(0.0, 0.0, 0.0, 0.0)
        self._state[BenchState.shaft : BenchState.shaft_rate] = self._command[:SERVOS]
        rest = np.zeros(ENCODERS)
        rest[:ARMS] = arm_angles(np.array([0.0, 0.0, self._state[State.z]]), self.parameters.geometry)
        self._rest_angles = rest
        self._encoders = Encoders(rest, rest)

    # Commands ------------------------------------------------------------------------------------------

    def set_servo_command(self, B_1s: float, A_1s: float, theta_0: float, theta_t: float) -> bool:
        """Latch a pulse frame: mix, limit, quantise; held until the next one.

        Args:
            B_1s: longitudinal cyclic [rad].
            A_1s: lateral cyclic [rad].
            theta_0: collective [rad].
            theta_t: tail collective [rad].

        Returns:
            Whether the command was outside what the servos reach.

        Raises:
            ValueError: a value that is not finite, by name.
        """
        command = servos.command_shafts(B_1s, A_1s, theta_0, theta_t, self.parameters.servo)
        self._command[:SERVOS] = command.shafts
        self._saturated = command.saturated
        return command.saturated

    def set_motor_voltage(self, voltage: float) -> None:
        """Latch the control voltage of the supply [V]; outside 0 .. 10 V the supply gives its end value.

        Args:
            voltage: control voltage of the supply [V].

        Raises:
            ValueError: the voltage is not finite.
        """
        if not math.isfinite(voltage):
            raise ValueError(f"motor voltage is {voltage!r}, not a finite voltage")
        self._command[SERVOS] = voltage

    def set_wind(self, wind: Sequence[float]) -> None:
        """Latch the velocity of the air, NED [m/s], everywhere the same.

        Args:
            wind: (3,) velocity of the air, NED [m/s].

        Raises:
            ValueError: not three finite numbers.
        """
        if len(wind) != 3 or not all(math.isfinite(part) for part in wind):
            raise ValueError(f"wind {wind!r} is not three finite numbers (NED, m/s)")
        self._wind[:] = wind

    def set_homing(self, active: bool) -> None:
        """Let the scripted hand begin, once per change to True, or let go.

        Args:
            active: True while the bench is to be homed; the script runs once per change to True.

        Raises:
            ValueError: the rotor turns; nobody reaches into a turning rotor.
        """
        if active and not self._homing:
            if self.rotor_speed > self._constants.helicopter.fade_speed:
                raise ValueError(f"homing while the rotor turns with {self.rotor_speed:.1f} rad/s")
            self._hand = Hand(0.0, *self.position, *self.attitude)
        elif not active:
            self._hand = NO_HAND
        self._homing = active

    # Motion --------------------------------------------------------------------------------------------

    def advance(self) -> None:
        """Go on by one sensor period, 2.5 ms, inputs held; then the encoders count.

        Should the motion become numerically meaningless (`is_finite`), the encoders stay where they were.

        Raises:
            ValueError: the platform was torn out of the arms' reach; the pose is in the text.
        """
        advance(
            self._state,
            self._command,
            self._wind,
            self._hand,
            SENSOR_PERIOD,
            INTEGRATION_STEPS,
            self._constants,
            self._work,
        )
        self._hand = later(self._hand, SENSOR_PERIOD)
        if self._hand.time > homing_hand.duration(self._constants.hand):
            self._hand = NO_HAND
        self._stamp_ns += SENSOR_PERIOD_NS
        if self.is_finite:
            self._encoders.sample(self._shaft_angles())

    def place(self, state: Array, inputs: Array) -> None:
        """Put the helicopter somewhere in flight, servos already there; the encoders power up anew.

        Args:
            state: (18,) in the order of `State`.
            inputs: (5,) in the order of `Input`; not limited, not quantised.

        Raises:
            ValueError: a shape, a value that is not finite, or a pose out of reach.
        """
        state, inputs = np.asarray(state, dtype=np.float64), np.asarray(inputs, dtype=np.float64)
        if state.shape != (STATE_SIZE,) or not np.isfinite(state).all():
            raise ValueError(f"state {state!r} is not {STATE_SIZE} finite numbers")
        if inputs.shape != (INPUT_SIZE,) or not np.isfinite(inputs).all():
            raise ValueError(f"inputs {inputs!r} are not {INPUT_SIZE} finite numbers")
        arm_angles(state[State.x : State.z + 1], self.parameters.geometry)
        self._state[:] = 0.0
        self._state[:STATE_SIZE] = state
        shafts = np.empty(SERVOS)
        servos.mix(
            float(inputs[Input.B_1s]),
            float(inputs[Input.A_1s]),
            float(inputs[Input.theta_0]),
            float(inputs[Input.theta_t]),
            self._constants.servo,
            shafts,
        )
        self._state[BenchState.shaft : BenchState.shaft_rate] = shafts
        self._command[:SERVOS] = shafts
        self._command[SERVOS] = inputs[Input.U_mot]
        self._saturated = False
        self._hand = NO_HAND
        self._encoders = Encoders(self._shaft_angles(), self._rest_angles)

    def _shaft_angles(self) -> Array:
        """(6,) true angles at the encoders [rad]: arms, yaw, pitch, roll."""
        arms = arm_angles(self._state[State.x : State.z + 1], self.parameters.geometry)
        return np.concatenate([arms, self.attitude])

    # Readings ------------------------------------------------------------------------------------------

    @property
    def stamp_ns(self) -> int:
        """Simulated time since power-up [ns]."""
        return self._stamp_ns

    @property
    def state(self) -> Array:
        """(18,) copy of the helicopter's state in the order of `State`."""
        return self._state[:STATE_SIZE].copy()

    @property
    def whole_state(self) -> Array:
        """(29,) copy of all that moves, in the order of `State` and `BenchState`."""
        return self._state.copy()

    @property
    def command(self) -> Array:
        """(5,) copy of the latched shaft commands [rad] and control voltage [V]."""
        return self._command.copy()

    @property
    def position(self) -> Vector3:
        """Centre of gravity, NED from the flight-space centre [m]."""
        return self._three(State.x, State.y, State.z)

    @property
    def attitude(self) -> Euler:
        """Yaw, pitch, roll [rad], which are the gimbal's angles."""
        return Euler(*self._three(State.psi, State.theta, State.phi))

    @property
    def velocity(self) -> Vector3:
        """u, v, w against the earth, body FRD [m/s]."""
        return self._three(State.u, State.v, State.w)

    @property
    def rates(self) -> Vector3:
        """p, q, r, body FRD [rad/s]."""
        return self._three(State.p, State.q, State.r)

    @property
    def rotor_speed(self) -> float:
        """True speed of the main rotor [rad/s]."""
        return float(self._state[State.Omega])

    @property
    def normal_force(self) -> float:
        """Force of the lower stop on the helicopter [N]; 0 in flight."""
        down = rigid_body.earth_from_body(*self.velocity, *self.attitude)[2]
        return float(lower_stop.normal_force(float(self._state[State.z]), down, self._constants.stop))

    @property
    def on_stop(self) -> bool:
        """Whether the helicopter stands on the lower stop."""
        return self.normal_force > 0.0

    @property
    def homing(self) -> bool:
        """Whether the hand is at work."""
        return self._hand.time >= 0.0

    @property
    def is_finite(self) -> bool:
        """False once the motion has become numerically meaningless."""
        return bool(np.isfinite(self._state).all())

    @property
    def loads(self) -> Loads:
        """Thrusts, torques and current now."""
        return helicopter.loads(self.state, self._inputs(), self._wind, self._constants.helicopter)

    @property
    def validity(self) -> Validity:
        """Where the model leaves the regime it was identified in."""
        return helicopter.validity(self.state, self._inputs(), self._wind, self._constants.helicopter)

    def encoder_reading(self) -> EncoderReading:
        """The encoders' latest sample."""
        return self._encoders.reading

    def actuator_state(self) -> ActuatorState:
        """What servos and motor do now."""
        return actuator_state(self._state, self._command, self._saturated, self._constants)

    def _inputs(self) -> Array:
        """(5,) actual blade angles and control voltage."""
        return actual_inputs(self._state, self._command, self._constants)

    def _three(self, first: State, second: State, third: State) -> Vector3:
        state = self._state
        return float(state[first]), float(state[second]), float(state[third])
