"""Looking at a bench: everything that can be read of it, as copies. SI, earth NED, body FRD."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import helicopter, lower_stop, rigid_body
from heli_bench_sim.actuators import ActuatorState, actual_inputs, actuator_state
from heli_bench_sim.bench_memory import Memory, Reading, blank_memory
from heli_bench_sim.bench_messages import write_sensors, write_truth
from heli_bench_sim.bench_parameters import BenchParameters, bench_constants
from heli_bench_sim.encoders import ENCODERS, EncoderReading
from heli_bench_sim.helicopter import Loads
from heli_bench_sim.imu import ImuReading
from heli_bench_sim.imu_parameters import imu_variances
from heli_bench_sim.room_air import RoomState
from heli_bench_sim.states import STATE_SIZE, State
from heli_bench_sim.validity import Violation, violations
from heli_bench_sim.wind_generator import WindState
from heli_common.records import boxed
from heli_common.rotations import Euler, Vector3

Array = NDArray[np.float64]


class BenchView:
    """What can be read of a bench.

    Args:
        parameters: what it is built from.
    """

    def __init__(self, parameters: BenchParameters) -> None:
        self.parameters = parameters
        self._constants = bench_constants(parameters)
        self._box = boxed(self._constants)
        # a record within a record is slow to reach
        self._stop, self._helicopter = self._constants.stop, self._constants.helicopter
        self._memory = blank_memory()
        self._state = self._memory[Memory.state : Memory.slope]
        self._command = self._memory[Memory.command : Memory.air]
        self._air = self._memory[Memory.air : Memory.steady_wind]
        self._reading = np.zeros(Reading.end)
        self._imu_valid = True
        self._imu_variances = imu_variances(self._constants.imu)
        self._motor_gear = parameters.helicopter.motor_gear
        self._saturated = False
        self._stamp_ns = 0

    # The motion ----------------------------------------------------------------------------------------

    @property
    def stamp_ns(self) -> int:
        """Simulated time since power-up [ns]."""
        return self._stamp_ns

    @property
    def state(self) -> Array:
        """(18,) of the helicopter, in the order of `State`."""
        return self._state[:STATE_SIZE].copy()

    @property
    def whole_state(self) -> Array:
        """(29,) of all that moves, in the order of `State` and `BenchState`."""
        return self._state.copy()

    @property
    def memory(self) -> Array:
        """All that the bench remembers, in the parts of `Memory`."""
        return self._memory.copy()

    @property
    def command(self) -> Array:
        """(5,) latched shaft commands [rad] and control voltage [V]."""
        return self._command.copy()

    @property
    def pose(self) -> Array:
        """(6,) north, east, down [m], yaw, pitch, roll [rad]."""
        return self._state[State.x : State.phi + 1].copy()

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
        return float(lower_stop.normal_force(float(self._state[State.z]), down, self._stop))

    @property
    def on_stop(self) -> bool:
        """Whether the helicopter stands on the lower stop."""
        return self.normal_force > 0.0

    @property
    def homing(self) -> bool:
        """Whether the hand is at work."""
        return bool(self._memory[Memory.hand] >= 0.0)

    @property
    def is_finite(self) -> bool:
        """False once the motion has become numerically meaningless."""
        return bool(np.isfinite(self._state).all())

    # The air -------------------------------------------------------------------------------------------

    @property
    def wind(self) -> Vector3:
        """Velocity of the air at the helicopter, NED [m/s]."""
        return float(self._air[0]), float(self._air[1]), float(self._air[2])

    @property
    def gust_yaw(self) -> float:
        """Moment of the room's air about the vertical axis, nose to the right [N m]."""
        return float(self._air[RoomState.yaw])

    @property
    def fan_speed(self) -> float:
        """Mean speed on the axis of the wind generator's jet [m/s]."""
        return float(self._memory[Memory.jet + WindState.speed])

    # Loads and validity --------------------------------------------------------------------------------

    @property
    def loads(self) -> Loads:
        """Thrusts, torques and current now."""
        return helicopter.loads(self._state, self._inputs(), self._air, self._helicopter)

    @property
    def violations(self) -> tuple[Violation, ...]:
        """Where the model leaves the regime it was identified in."""
        return violations(self._state, self._inputs(), self._air, self._helicopter)

    # Readings ------------------------------------------------------------------------------------------

    @property
    def reading(self) -> Array:
        """(19,) what the sensors said at the latest sample, in the columns of `Reading`."""
        return self._reading.copy()

    def encoder_reading(self) -> EncoderReading:
        """The encoders' latest sample."""
        counts = self._reading[Reading.count : Reading.count + ENCODERS].astype(np.int64)
        return EncoderReading(counts, self._reading[Reading.indexed : Reading.gyro] != 0.0)

    def imu_reading(self) -> ImuReading:
        """The IMU's latest sample."""
        x, y, z, forward, right, down = self._reading[Reading.gyro : Reading.rotor_speed].tolist()
        return ImuReading((x, y, z), (forward, right, down), self._imu_valid)

    @property
    def imu_bias(self) -> Array:
        """(6,) biases of the IMU's next sample [rad/s, m/s^2], FRD."""
        return self._memory[Memory.imu_bias : Memory.end].copy()

    def rotor_reading(self) -> float:
        """Rotor speed by the Hall sensor [rad/s], latest sample."""
        return float(self._reading[Reading.rotor_speed])

    def write_sensors(self, encoders: Array, imu: Array) -> None:
        """The numbers of the messages `encoders` (18,) and `imu` (37,) of the latest sample, into zeros."""
        write_sensors(self._reading, self._imu_valid, *self._imu_variances, encoders, imu)

    def write_truth(self, actuators: Array, odometry: Array, wind: Array) -> None:
        """Those of `actuator_state` (15,), `ground_truth` (85,) and `wind` (3,) now, into zeros."""
        write_truth(self._memory, self._saturated, self._motor_gear, self._box, actuators, odometry, wind)

    def actuator_state(self) -> ActuatorState:
        """What servos and motor do now."""
        return actuator_state(self._state, self._command, self._saturated, self._motor_gear, self._box)

    def _inputs(self) -> Array:
        """(5,) actual blade angles and control voltage."""
        return actual_inputs(self._state, self._command, self._box)

    def _three(self, first: State, second: State, third: State) -> Vector3:
        state = self._state
        return float(state[first]), float(state[second]), float(state[third])
