"""The simulated bench: commands in, 2.5 ms of motion, readings out; no ROS, no clock.

It begins at rest on the lower stop, rotor stopped, attitude zero. All values are SI, earth NED from the
flight-space centre, body FRD at the centre of gravity. Readings are copies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim import encoders, hall_sensor, servos
from heli_bench_sim.actuators import command_servos
from heli_bench_sim.bench_memory import READING_SIZE, Memory, Noise, Reading
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.bench_view import BenchView
from heli_bench_sim.delta_arm import ARMS, arm_angles
from heli_bench_sim.encoders import ENCODERS
from heli_bench_sim.fault_effects import FaultEffects
from heli_bench_sim.faults import NO_FAULTS, Fault, FaultSchedule
from heli_bench_sim.imu import IMU_NORMALS, Imu, ImuTruth, imu_truth
from heli_bench_sim.imu_parameters import initial_bias
from heli_bench_sim.motion import BENCH_STATE_SIZE, NO_HAND, WORK_ROWS, BenchState, Hand
from heli_bench_sim.random_streams import generator
from heli_bench_sim.room_air import ROOM_NORMALS
from heli_bench_sim.sampling import WORK_SIZE, refresh, run, sense
from heli_bench_sim.servos import SERVOS
from heli_bench_sim.states import INPUT_SIZE, STATE_SIZE, State
from heli_bench_sim.wind_generator import WIND_NORMALS, check_wind_command
from heli_common.timing import SENSOR_PERIOD, SENSOR_PERIOD_NS

Array = NDArray[np.float64]

NOISE_BLOCK = 400
"""Samples for which random numbers are drawn at once."""

REFINEMENT = 1
"""Factor on the number of integration steps; the README gives the step-size study."""


class Bench(BenchView):
    """One bench with its whole state.

    Args:
        parameters: what it is built from.
        seed: of every random number of the bench; each component has a stream of its own.
        imu: somebody's own IMU in place of the built-in one.
        faults: what goes wrong, and when.
    """

    def __init__(
        self,
        parameters: BenchParameters | None = None,
        seed: int = 1,
        *,
        imu: Imu | None = None,
        faults: FaultSchedule = NO_FAULTS,
    ) -> None:
        super().__init__(parameters or BenchParameters())
        self.seed = seed
        self.faults = FaultEffects(faults)
        self._own_imu = imu
        self._work, self._scratch = np.empty((WORK_ROWS, BENCH_STATE_SIZE)), np.empty(WORK_SIZE)
        streams = {"imu": IMU_NORMALS, "wind_generator": WIND_NORMALS, "room_air": ROOM_NORMALS}
        self._noise = [(generator(seed, name), width) for name, width in streams.items()]
        self._normal_block: Array = np.empty((0, Noise.end))
        self._drawn = 0
        bias = initial_bias(self.parameters.imu, generator(seed, "imu_bias"))
        self._memory[Memory.imu_bias : Memory.end] = bias
        self._jump: Array = np.zeros(len(bias))
        self._previous: Array = np.zeros(len(bias))
        self._commanded = np.zeros(SERVOS + 1)
        self._homing = False
        self._state[State.z] = self.parameters.geometry.rest_depth
        self.set_servo_command(0.0, 0.0, 0.0, 0.0)
        self._state[BenchState.shaft : BenchState.shaft_rate] = self._commanded[:SERVOS]
        self._rest_angles = self._shaft_angles()
        self._power_up()

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
        servos.require_finite_command((B_1s, A_1s, theta_0, theta_t))
        shafts = self._commanded[:SERVOS]
        self._saturated = bool(command_servos(B_1s, A_1s, theta_0, theta_t, self._box, shafts))
        self._latch()
        return self._saturated

    def set_motor_voltage(self, voltage: float) -> None:
        """Latch the control voltage of the supply [V]; outside 0 .. 10 V the supply gives its end value.

        Args:
            voltage: control voltage of the supply [V].

        Raises:
            ValueError: the voltage is not finite.
        """
        if not math.isfinite(voltage):
            raise ValueError(f"motor voltage is {voltage!r}, not a finite voltage")
        self._commanded[SERVOS] = voltage
        self._latch()

    def set_fan(self, speed: float) -> None:
        """Command the wind generator; the jet follows with its lag.

        Args:
            speed: of the air on its axis [m/s].

        Raises:
            ValueError: the speed is no number or out of range.
        """
        self._memory[Memory.fan_command] = check_wind_command(speed, self.parameters.wind)

    def set_wind(self, wind: Sequence[float]) -> None:
        """Latch a velocity of the air that is the same everywhere and adds to jet and room, NED [m/s].

        Args:
            wind: (3,) velocity of the air, NED [m/s].

        Raises:
            ValueError: not three finite numbers.
        """
        if len(wind) != 3 or not all(math.isfinite(part) for part in wind):
            raise ValueError(f"wind {wind!r} is not three finite numbers (NED, m/s)")
        self._memory[Memory.steady_wind : Memory.fan_command] = wind
        self._refresh()

    def set_homing(self, active: bool) -> None:
        """Let the scripted hand begin, once per change to True, or let go.

        Args:
            active: True while the bench is to be homed; the script runs once per change to True.

        Raises:
            ValueError: the rotor turns; nobody reaches into a turning rotor.
        """
        if active != self._homing:
            if active and self.rotor_speed > self._constants.helicopter.fade_speed:
                raise ValueError(f"homing while the rotor turns with {self.rotor_speed:.1f} rad/s")
            hand = Hand(0.0, *self.position, *self.attitude) if active else NO_HAND
            self._memory[Memory.hand : Memory.azimuth] = hand
            self._refresh()
        self._homing = active

    def add_fault(self, fault: Fault) -> None:
        """Let something go wrong from its start on, or from now on if that is past.

        Args:
            fault: of any kind.
        """
        self.faults.add(fault)

    def _latch(self) -> None:
        """What servos and supply make of the command now."""
        if self.faults.quiet(self._stamp_ns):
            self._command[:] = self._commanded
        else:
            self._command[:SERVOS] = self.faults.shafts(self._stamp_ns, self._commanded[:SERVOS])
            self._command[SERVOS] = self.faults.voltage(self._stamp_ns, float(self._commanded[SERVOS]))

    # Motion --------------------------------------------------------------------------------------------

    def advance(self) -> None:
        """Go on by one sensor period, 2.5 ms, commands held; then the sensors read.

        Should the motion become numerically meaningless (`is_finite`), the encoders stay where they were.

        Raises:
            ValueError: the platform was torn out of the arms' reach; the pose is in the text.
        """
        self.run(1)

    def run(self, samples: int) -> Array:
        """Go on by some sensor periods with the commands held: much faster than one at a time.

        Args:
            samples: how many periods of 2.5 ms.

        Returns:
            (n, 19) what the sensors said, in the columns of `Reading`; fewer rows if `is_finite` has failed.

        Raises:
            ValueError: the platform was torn out of the arms' reach; the pose is in the text.
        """
        if self._own_imu is None and not self.faults.any:
            return self._go(samples)
        rows = []
        for _ in range(samples):
            self._latch()
            row = self._go(1)
            if len(row):
                self._exchange(row[0])
            rows.append(row)
        return np.concatenate(rows)

    def _go(self, samples: int) -> Array:
        readings: Array = np.empty((samples, READING_SIZE))
        normals = self._normals(samples)
        done = run(
            self._memory,
            self._counters,
            normals,
            REFINEMENT,
            self._box,
            self._work,
            self._scratch,
            readings,
        )
        self._stamp_ns += samples * SENSOR_PERIOD_NS
        if done < samples:
            readings = readings[:done]
            if self.is_finite:
                self._shaft_angles()
        if done:
            self._reading = readings[-1]
        return readings

    def _normals(self, samples: int) -> Array:
        """(n, 16) the next standard normal numbers of every component, in the columns of `Noise`."""
        first, last = self._drawn, self._drawn + samples
        if last > len(self._normal_block):
            rest = self._normal_block[first:]
            rows = max(NOISE_BLOCK, samples - len(rest))
            fresh = np.hstack([stream.standard_normal((rows, width)) for stream, width in self._noise])
            self._normal_block = np.concatenate([rest, fresh])
            first, last = 0, samples
        self._drawn = last
        return self._normal_block[first:last]

    def _exchange(self, reading: Array) -> None:
        """Put a user's IMU and the faults' effects into a reading, in place."""
        stamp, self._imu_valid = self._stamp_ns, True
        if self._own_imu is not None:
            truth, slope = np.empty(len(self._jump)), self._memory[Memory.slope : Memory.command]
            imu_truth(self._state, slope, self._constants.imu, truth)
            p, q, r, forward, right, down = truth.tolist()
            azimuth = float(self._memory[Memory.azimuth])
            said = self._own_imu.sample(
                ImuTruth((p, q, r), (forward, right, down), azimuth, self.rotor_speed, stamp)
            )
            self._imu_valid = said.valid
            reading[Reading.gyro : Reading.rotor_speed] = (*said.gyro, *said.accelerometer)
            reading[Reading.gyro : Reading.rotor_speed] += self.faults.bias_jump(stamp)
        faults = self.faults
        counts = reading[Reading.count : Reading.count + ENCODERS].astype(np.int64)
        reading[Reading.count : Reading.count + ENCODERS] = faults.counts(stamp, counts)
        indexed = reading[Reading.indexed : Reading.gyro] != 0.0
        reading[Reading.indexed : Reading.gyro] = faults.indexed(stamp, indexed)
        if not faults.imu_valid(stamp):
            self._imu_valid = False
            reading[Reading.gyro : Reading.rotor_speed] = self._previous
        self._previous = reading[Reading.gyro : Reading.rotor_speed].copy()
        jump = faults.bias_jump(stamp + SENSOR_PERIOD_NS)
        self._memory[Memory.imu_bias : Memory.end] += jump - self._jump
        self._jump = jump

    def place(self, state: Array, inputs: Array) -> None:
        """Put the helicopter somewhere in flight, servos already there; the sensors power up anew.

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
        b_1s, a_1s, theta_0, theta_t, voltage = inputs.tolist()
        servos.mix(b_1s, a_1s, theta_0, theta_t, self._constants.servo, shafts)
        self._state[BenchState.shaft : BenchState.shaft_rate] = shafts
        self._commanded[:] = (*shafts, voltage)
        self._saturated = False
        self._memory[Memory.hand : Memory.azimuth] = NO_HAND
        self._power_up()

    def _power_up(self) -> None:
        """Switch the sensors on where the bench now is, and read them for the first time."""
        self._latch()
        self._counters = encoders.power_up(self._shaft_angles(), self._rest_angles)
        azimuth = float(self._memory[Memory.azimuth])
        before = azimuth - self.rotor_speed * SENSOR_PERIOD  # the sample that now comes is the next one
        settled = hall_sensor.hall_settled(self.rotor_speed, before, self._constants.hall)
        self._memory[Memory.hall : Memory.imu_bias] = settled
        self._refresh()
        reading = np.empty(READING_SIZE)
        sense(self._memory, self._counters, self._normals(1)[0], self._constants, self._scratch, reading)
        self._previous = reading[Reading.gyro : Reading.rotor_speed].copy()
        if self._own_imu is not None or self.faults.any:
            self._exchange(reading)
        self._reading = reading

    def _refresh(self) -> None:
        refresh(self._memory, self._box, self._scratch)

    def _shaft_angles(self) -> Array:
        """(6,) true angles at the encoders [rad]: arms, yaw, pitch, roll."""
        arms = arm_angles(self._state[State.x : State.z + 1], self.parameters.geometry)
        angles = np.empty(ENCODERS)
        angles[:ARMS], angles[ARMS:] = arms, self.attitude
        return angles
