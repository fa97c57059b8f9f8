"""A made-up flight of any plan, written as a bag: for tests of what reads bags, no physics claimed.

The true pose follows the reference like a second-order system, plus a slow wander; everything else is
derived from it just well enough to look like a flight.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heli_common.compiled_messages import write_imu_attitude
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.rotations import Euler
from heli_common.timing import CONTROL_PERIOD_NS, SENSOR_PERIOD_NS
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_common.vehicle_state import (
    VehicleState,
    imu_values,
    odometry_values,
    pose_values,
    twist_values,
)
from heli_flight.bag import BagWriter
from heli_flight.plan import Home, Land, Plan, RunDown, RunUp, Step, TakeOff, load_plan

REST = 0.45
SPEED = 163.363
PERIOD = 0.01
TRIM = np.radians([-1.5, -0.8, 6.5, 12.4])
Array = NDArray[np.float64]


def schedule(plan: Plan) -> tuple[list[FlightState], Array, Array]:
    """State, reference (n, 4) NED and yaw, and rotor reference (n,) at every control tick."""
    states: list[FlightState] = []
    rows: list[tuple[float, float, float, float]] = []
    rotor: list[float] = []
    place = [0.0, 0.0, REST, 0.0]

    def hold(state: FlightState, duration: float, speed: float) -> None:
        count = round(duration / PERIOD)
        states.extend([state] * count)
        rows.extend([(place[0], place[1], place[2], place[3])] * count)
        rotor.extend([speed] * count)

    def climb(state: FlightState, depth: float, speed: float) -> None:
        start = place[2]
        for tick in range(1, round(abs(depth - start) / speed / PERIOD) + 1):
            place[2] = start + math.copysign(speed * PERIOD * tick, depth - start)
            hold(state, PERIOD, SPEED)
        place[2] = depth

    for phase in plan.phases:
        if isinstance(phase, Home):
            hold(FlightState.HOMING, phase.duration, 0.0)
        elif isinstance(phase, RunUp):
            hold(FlightState.RUN_UP, phase.duration, SPEED)
        elif isinstance(phase, TakeOff):
            hold(FlightState.FLYING, 2.5, SPEED)
            climb(FlightState.FLYING, -phase.height, phase.speed)
        elif isinstance(phase, Land):
            climb(FlightState.LANDING, REST, phase.speed)
        elif isinstance(phase, RunDown):
            hold(FlightState.RUN_DOWN, phase.duration, 0.0)
        else:
            if isinstance(phase, Step):
                place[["x", "y", "z", "psi"].index(phase.axis)] += phase.amplitude
            hold(FlightState.FLYING, phase.duration, SPEED)
    hold(FlightState.STOPPED, PERIOD, 0.0)
    return states, np.array(rows), np.array(rotor)


def follow(reference: Array, frequency: float = 2.2, damping: float = 0.6) -> tuple[Array, Array, Array]:
    """Second-order response (position, velocity, acceleration) of every column to the reference."""
    y, v = reference[0].copy(), np.zeros(reference.shape[1])
    found = [np.zeros_like(reference) for _ in range(3)]
    for tick, wanted in enumerate(reference):
        a = frequency**2 * (wanted - y) - 2.0 * damping * frequency * v
        for array, value in zip(found, (y, v, a), strict=True):
            array[tick] = value
        v = v + PERIOD * a
        y = y + PERIOD * v
    return found[0], found[1], found[2]


def messages(plan: Plan, wander: float = 0.012, seed: int = 0) -> Iterator[tuple[str, int, bytes]]:
    """Topic, stamp and serialized message of the whole flight, in the order of the stamps."""
    rng = np.random.default_rng(seed)
    states, reference, rotor_reference = schedule(plan)
    flying = np.array([state.controlled for state in states], dtype=float)
    pose, velocity, acceleration = follow(reference)
    noise = rng.normal(size=pose.shape)
    drift = np.zeros_like(pose)
    for tick in range(1, len(noise)):
        drift[tick] = 0.99 * drift[tick - 1] + math.sqrt(1.0 - 0.99**2) * noise[tick]
    pose = pose + drift * (wander * np.array([1.0, 1.2, 1.8, 3.0])) * flying[:, None]
    smooth = np.cumsum(np.ones(len(states))) * 0.0
    speed = 0.0
    for tick, wanted in enumerate(rotor_reference):
        speed += PERIOD * 1.2 * (wanted - speed)
        smooth[tick] = speed
    for tick, state in enumerate(states):
        stamp = tick * CONTROL_PERIOD_NS
        ax, ay = acceleration[tick, :2]
        theta, phi = -ax / 9.81 + 0.002 * noise[tick, 0], ay / 9.81 - 0.02 + 0.002 * noise[tick, 1]
        attitude = Euler(float(pose[tick, 3]), float(theta), float(phi))
        here = tuple(pose[tick, :3].tolist())
        u, v, w, r = velocity[tick].tolist()
        truth = VehicleState(here, attitude, (u, v, w), (0.0, 0.0, r))
        seen = tuple((pose[tick, :3] + 0.001 * rng.normal(size=3)).tolist())
        estimate = VehicleState(seen, attitude, (u, v, w), (0.0, 0.0, r))
        command = (TRIM + np.array([theta, phi, -0.3 * w, 0.1 * r])) * flying[tick]
        omega = smooth[tick] * (1.0 + 0.002 * noise[tick, 3] * flying[tick])
        voltage = 9.0 * smooth[tick] / SPEED * (0.75 + 0.01 * noise[tick, 2])
        by_imu = np.empty(len(TOPICS["imu_attitude"].layout.fields))
        write_imu_attitude(attitude, (1e-6, 1e-6, 1e-4), (0.0, 0.0, r), 1e-6, by_imu)
        values = {
            "rotor": (0.0, omega, 0.0),
            "actuator_state": (*command.tolist(), 0.0, *(0.0,) * 9, voltage),
            "ground_truth": odometry_values(truth, [0.0] * 6, [0.0] * 6),
            "wind": (0.0, 0.0, 0.0),
            "imu_attitude": by_imu,
            "imu_bias": (0.0,) * 12 + (1e-3,) * 6,
            "bench_condition": (0.0,) * len(TOPICS["bench_condition"].layout.fields),
            "odometry": odometry_values(estimate, [1e-6] * 6, [1e-4] * 6),
            "rotor_state": (0.0, omega, 0.0),
            "flight_state": flight_state_values(state, float(rotor_reference[tick])),
            "reference": pose_values(
                tuple(reference[tick, :3].tolist()), Euler(reference[tick, 3], 0.0, 0.0)
            ),
            "velocity_reference": twist_values(
                tuple((2.0 * (reference - pose)[tick, :3]).tolist()), (0.0, 0.0, 0.0)
            ),
            "servo_command": (*command.tolist(), *(0.0,) * 8),
            "motor_command": (0.0, 0.0, voltage),
        }
        for part in range(CONTROL_PERIOD_NS // SENSOR_PERIOD_NS):
            sample = stamp + part * SENSOR_PERIOD_NS
            counts = (0.0,) * 12 + (1.0,) * 6
            yield "encoders", sample, TOPICS["encoders"].layout.pack(sample, counts)
            felt = imu_values((0.0, 0.0, r), (float(ax), float(ay), -9.81), (1e-6, 1e-4))
            yield "imu", sample, TOPICS["imu"].layout.pack(sample, felt)
            yield "odometry_imu", sample, TOPICS["odometry_imu"].layout.pack(sample, values["odometry"])
        for topic, numbers in values.items():
            yield topic, stamp, TOPICS[topic].layout.pack(stamp, numbers)


def write_flight(
    folder: Path,
    plan: Plan | None = None,
    *,
    until: float = math.inf,
    without: tuple[str, ...] = (),
    wander: float = 0.012,
    seed: int = 0,
    controller: str = "lq",
    close: bool = True,
) -> BagWriter:
    """Write a bag; `until` cuts the flight, `without` leaves topics empty, `close` finishes the bag."""
    flown = plan or load_plan("short_hover")
    writer = BagWriter(
        folder,
        {
            "plan": flown.to_yaml(),
            "seed": str(flown.seed),
            "mode": "lockstep",
            "controller": controller,
            "controller_file": "format: heli_controller/2\nname: lq\n",
            "parameters": '{"heli_bench_sim": {"gust_xy": 0.35}}',
            "versions": '{"python": "3.11.7", "heli_flight": "0.1.0", "numpy": "2.2.6"}',
        },
    )
    for topic in DATA_TOPICS:
        writer.add_topic(topic, TOPICS[topic].layout.ros_type)
    writer.add_topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", depth=10)
    for topic, stamp, data in messages(flown, wander, seed):
        if stamp * 1e-9 > until:
            break
        if topic not in without:
            writer.write(topic, stamp, data)
    if close:
        writer.close({"late_servo_command": "0", "late_motor_command": "0"})
    return writer
