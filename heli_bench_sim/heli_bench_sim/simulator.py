"""The bench as a component: samples out, commands in, on the time grid of spec 6.4.

A command stamped t_k acts at t_k + 5 ms; servo pulse frames latch at n * 20 ms + 5 ms. Who drives the
bench decides what happens when a command is missing at that instant: lockstep waits for `missing()` to be
empty, real time goes on with the newest command there is and counts it as late.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heli_bench_sim.bench import Bench
from heli_bench_sim.fault_request import fault_from_text
from heli_bench_sim.superposition import STALE_NS, Superposition
from heli_bench_sim.validity import Violation
from heli_common.component import Message
from heli_common.errors import SafetyStop
from heli_common.finite import require_finite
from heli_common.flight_state import FlightState, flight_state_from_code
from heli_common.timing import (
    COMMAND_LATENCY_NS,
    CONTROL_PERIOD_NS,
    SENSOR_PERIOD_NS,
    is_command_tick,
    is_control_tick,
    is_pwm_tick,
)
from heli_common.topics import BENCH_CONDITION, BENCH_SIM, TOPICS
from heli_common.vehicle_state import swap_body

Array = NDArray[np.float64]

_SIZES = {topic: len(entry.layout.fields) for topic, entry in TOPICS.items()}
_FAN = TOPICS["flight_state"].layout.fields.index("velocity.fan")

REGIME_PERIOD_NS = 100_000_000
"""How often it is looked whether the model still holds."""


class BenchSimulator:
    """A bench that takes commands and gives a sample every 2.5 ms.

    Args:
        bench: to be driven.
        excited: whether an identification adds its excitation to the servo commands; it is waited for, too.

    Attributes:
        stamp_ns: stamp of the last sample, negative before the first one.
        late: late commands so far, per input topic.
        newest: stamp of the newest command so far, per input topic.
        ended_at: stamp of the first flight state that ends the flight, or None.
        left_regime: the first violation of each kind so far, with its stamp [ns].
    """

    name = BENCH_SIM
    inputs: tuple[str, ...] = ("servo_command", "motor_command", "flight_state")
    outputs: tuple[str, ...] = (
        "rotor",
        "encoders",
        "imu",
        "actuator_state",
        "ground_truth",
        "wind",
        "bench_condition",
        "clock",
    )

    def __init__(self, bench: Bench, excited: bool = False) -> None:
        self.bench = bench
        if excited:
            self.inputs = (*self.inputs, "excitation", "motor_excitation")
        self.stamp_ns = -SENSOR_PERIOD_NS
        self.late = dict.fromkeys(self.inputs, 0)
        self.ended_at: int | None = None
        self._commands: dict[str, list[tuple[int, Sequence[float]]]] = {topic: [] for topic in self.inputs}
        self.newest = dict.fromkeys(self.inputs, -1)
        self.left_regime: dict[str, tuple[int, Violation]] = {}
        self._link = Superposition(excited)
        self._motor_added = 0.0

    def receive(self, topic: str, stamp_ns: int, values: Sequence[float]) -> list[Message]:
        """Keep a command until it acts.

        Raises:
            SafetyStop: a number in the command is not finite.
        """
        try:
            require_finite(topic, values)
        except ValueError as error:
            raise SafetyStop(f"{error} at {stamp_ns * 1e-9:.2f} s; motor switched off") from None
        if topic == "servo_command":
            self._link.send_command(stamp_ns, values)
        elif topic == "excitation":
            self._link.send_excitation(stamp_ns, values)
        else:
            self._commands[topic].append((stamp_ns, values))
        self.newest[topic] = max(self.newest[topic], stamp_ns)
        if topic == "flight_state" and self.ended_at is None and flight_state_from_code(values[0]).ended:
            self.ended_at = stamp_ns
        return []

    def missing(self) -> tuple[str, ...]:
        """Topics whose command for the coming instant is not here yet; empty if the bench may go on."""
        due = self.stamp_ns - COMMAND_LATENCY_NS
        if not is_command_tick(self.stamp_ns) or min(self.newest.values()) >= due:
            return ()
        return tuple(topic for topic in self.inputs if self.newest[topic] < due)

    def tick(self) -> list[Message]:
        """Go on by 2.5 ms with the newest commands and take a sample; the first call samples at time 0."""
        if self.stamp_ns >= 0:
            if is_command_tick(self.stamp_ns):
                self._apply(self.stamp_ns - COMMAND_LATENCY_NS)
            if not len(self.bench.run(1)):
                raise SafetyStop(f"the motion is no longer finite at {self.stamp_ns * 1e-9:.2f} s")
        self.stamp_ns += SENSOR_PERIOD_NS
        return self._sample()

    def run(self, samples: int) -> Array:
        """The same by some periods at once, up to the next instant at which commands act, without messages.

        Args:
            samples: how many periods; none but the first may begin at a command's instant.

        Returns:
            (n, 19) what the sensors said, in the columns of `Reading`.

        Raises:
            SafetyStop: the motion is no longer finite. ValueError: it was torn out of the arms' reach.
        """
        if self.stamp_ns < 0:
            raise ValueError("the first sample is taken by tick()")
        if is_command_tick(self.stamp_ns):
            self._apply(self.stamp_ns - COMMAND_LATENCY_NS)
        readings = self.bench.run(samples)
        if len(readings) < samples:
            stamp_ns = self.stamp_ns + len(readings) * SENSOR_PERIOD_NS
            raise SafetyStop(f"the motion is no longer finite at {stamp_ns * 1e-9:.2f} s")
        self.stamp_ns += samples * SENSOR_PERIOD_NS
        if self.stamp_ns % REGIME_PERIOD_NS == 0:
            self._watch_regime()
        return readings

    def _apply(self, due_ns: int) -> None:
        for topic in self.inputs:
            if self.newest[topic] < due_ns:
                self.late[topic] += 1
        self._set_motor(due_ns)
        if (stage := self._take("flight_state", due_ns)) is not None:
            state = flight_state_from_code(stage[0])
            self.bench.set_homing(state is FlightState.HOMING)
            self.bench.set_fan(stage[_FAN])
        if is_pwm_tick(self.stamp_ns):
            delay = self.bench.faults.link_delay_ns(self.stamp_ns)
            dead_time = self.bench.parameters.link.dead_time_ns + delay
            if (servo := self._link.take(due_ns, dead_time)) is not None:
                self.bench.set_servo_command(*servo)

    def _set_motor(self, due_ns: int) -> None:
        """Control voltage and its excitation, each the newest there is; a stale excitation counts as zero."""
        if (added := self._take("motor_excitation", due_ns)) is not None:
            self._motor_added = added[2]
        elif due_ns - self.newest.get("motor_excitation", due_ns) > STALE_NS:
            self._motor_added = 0.0
        if (motor := self._take("motor_command", due_ns)) is not None:
            self.bench.set_motor_voltage(motor[2] + self._motor_added)

    def _take(self, topic: str, due_ns: int) -> Sequence[float] | None:
        """The newest command stamped not later than `due_ns`; older ones are superseded."""
        commands = self._commands.get(topic, [])
        taken = None
        while commands and commands[0][0] <= due_ns:
            taken = commands.pop(0)[1]
        return taken

    def switch_off(self) -> None:
        """Motor voltage zero, whatever was commanded."""
        self._commands["motor_command"].clear()
        self.bench.set_motor_voltage(0.0)

    def request_fault(self, text: str) -> int:
        """Let something go wrong from the next control tick on.

        Args:
            text: for example `encoder_stuck encoder=arm_1 for_s=2`.

        Returns:
            stamp of that tick [ns].

        Raises:
            InputError: names the key, the value and what is allowed.
        """
        begin_ns = (self.stamp_ns // CONTROL_PERIOD_NS + 1) * CONTROL_PERIOD_NS
        self.bench.add_fault(fault_from_text(text, now_ns=begin_ns))
        return begin_ns

    def remarks(self) -> dict[str, str]:
        """What a flight's record says of the bench: late commands, and where the model did not hold."""
        said = {f"late_{topic}": str(count) for topic, count in self.late.items()}
        for name, (stamp_ns, violation) in self.left_regime.items():
            said[f"regime_{name}"] = f"{violation}, first at {stamp_ns * 1e-9:.2f} s"
        return said

    def _watch_regime(self) -> None:
        if not (self.bench.on_stop or self.bench.homing):  # with a slow rotor, but not in flight
            for violation in self.bench.violations:
                self.left_regime.setdefault(violation.name, (self.stamp_ns, violation))

    def _sample(self) -> list[Message]:
        stamp, bench = self.stamp_ns, self.bench
        messages = []
        if is_control_tick(stamp):  # before the others: the last of a burst wakes its listener
            messages.append(Message("rotor", stamp, (0.0, bench.rotor_reading(), 0.0)))
        encoders, imu = _blank("encoders"), _blank("imu")
        bench.write_sensors(encoders, imu)
        messages += [Message("encoders", stamp, encoders), Message("imu", stamp, imu)]
        if is_control_tick(stamp):
            messages += self._truth(stamp)
        if stamp % REGIME_PERIOD_NS == 0:
            self._watch_regime()
        return messages

    def _truth(self, stamp: int) -> list[Message]:
        bench = self.bench
        actuators, odometry, wind = _blank("actuator_state"), _blank("ground_truth"), _blank("wind")
        bench.write_truth(actuators, odometry, wind)
        x, y, z, forward, right, down = bench.imu_bias.tolist()
        condition = (
            *swap_body((x, y, z)),
            *swap_body((forward, right, down)),
            bench.fan_speed,
            bench.gust_yaw,
            *bench.faults.values(stamp),
            *(0.0,) * (2 * len(BENCH_CONDITION)),
        )
        return [
            Message("actuator_state", stamp, actuators),
            Message("ground_truth", stamp, odometry),
            Message("wind", stamp, wind),
            Message("bench_condition", stamp, condition),
            Message("clock", stamp, ()),
        ]


def _blank(topic: str) -> Array:
    """(n,) zeros for the numbers of a topic's message."""
    return np.zeros(_SIZES[topic])
