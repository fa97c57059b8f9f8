"""Every topic of the graph in one table: name, layout, rate, who speaks and who listens (spec 6.4).

Names are relative, so a namespace moves the whole bench. Data topics make up a flight's hash; the others
(clock, acknowledgements, diagnostics) depend on the way of running.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass

from heli_common.layout import Layout
from heli_common.rig_geometry import ENCODER_NAMES
from heli_common.standard_layouts import (
    clock,
    header,
    imu,
    joint_state,
    odometry,
    pose_stamped,
    twist_stamped,
    vector3_stamped,
)
from heli_common.timing import CONTROL_PERIOD_NS, ESTIMATE_PERIOD_NS, SENSOR_PERIOD_NS
from heli_common.vehicle_state import BODY_FRAME, HEADING_FRAME, IMU_FRAME, WORLD_FRAME

BENCH_SIM = "bench_sim"
NAVIGATION = "navigation"
MOTOR_CONTROLLER = "motor_controller"
POSITION_CONTROLLER = "position_controller"
ATTITUDE_CONTROLLER = "attitude_controller"
SUPERVISOR = "supervisor"
RECORDER = "recorder"
IDENTIFICATION = "identification"

OPTIONAL_NODES = (IDENTIFICATION,)
"""Nodes that a flight can be without, and that may be lost in real time."""

SERVO_CHANNELS = ("B_1s", "A_1s", "theta_0", "theta_t")
RIG_FRAME = "rig"

IMU_AXES = ("gyro_x", "gyro_y", "gyro_z", "accelerometer_x", "accelerometer_y", "accelerometer_z")
"""Axes of the IMU; in messages FLU."""

ESTIMATED = ("M_u", "M_v", "M_q", "M_1", "M_2", "M_0", "L_u", "L_v", "L_p", "L_1", "L_2", "L_0")
"""Coefficients of the pitch and roll acceleration (source eq. 2.82), M_0 and L_0 [rad/s^2] that of trim."""

FAULT_FIELDS = (
    "encoder_stuck",
    "encoder_lost_counts",
    "imu_dropout",
    "servo_jam",
    "supply_sag",
    "link_delay",
)
"""Faults: two masks of encoders (1, 2, 4, ...), 1 or 0, mask of servos, share of the voltage, delay [s]."""

BENCH_CONDITION = (*IMU_AXES, "fan", "gust_yaw", *FAULT_FIELDS)
"""Truth beside the motion: biases of the IMU [rad/s, m/s^2], fan [m/s], the room's moment [N m], faults."""


@dataclass(frozen=True)
class Topic:
    """One stream of stamped messages of constant layout.

    Attributes:
        name: relative topic name.
        layout: of its messages.
        period_ns: distance of two stamps.
        source: node that publishes it; exactly one does.
        listeners: nodes of this project that subscribe, the recorder aside.
        hashed: whether it is a data topic, recorded and part of a flight's hash.
    """

    name: str
    layout: Layout
    period_ns: int
    source: str
    listeners: tuple[str, ...] = ()
    hashed: bool = True


def _joints(*names: str) -> Layout:
    return joint_state(RIG_FRAME, names)


_TABLE = (
    Topic("encoders", _joints(*ENCODER_NAMES), SENSOR_PERIOD_NS, BENCH_SIM, (NAVIGATION,)),
    Topic("imu", imu(IMU_FRAME), SENSOR_PERIOD_NS, BENCH_SIM, (NAVIGATION,)),
    Topic("rotor", _joints("rotor"), CONTROL_PERIOD_NS, BENCH_SIM, (NAVIGATION,)),
    Topic("actuator_state", _joints(*SERVO_CHANNELS, "motor"), CONTROL_PERIOD_NS, BENCH_SIM),
    Topic("ground_truth", odometry(WORLD_FRAME, BODY_FRAME), CONTROL_PERIOD_NS, BENCH_SIM),
    Topic("wind", vector3_stamped(WORLD_FRAME), CONTROL_PERIOD_NS, BENCH_SIM),
    Topic(
        "bench_condition",
        _joints(*BENCH_CONDITION),
        CONTROL_PERIOD_NS,
        BENCH_SIM,
    ),
    Topic("clock", clock(), CONTROL_PERIOD_NS, BENCH_SIM, hashed=False),
    Topic(
        "odometry",
        odometry(WORLD_FRAME, BODY_FRAME),
        CONTROL_PERIOD_NS,
        NAVIGATION,
        (SUPERVISOR, POSITION_CONTROLLER, ATTITUDE_CONTROLLER, IDENTIFICATION),
    ),
    Topic("odometry_imu", odometry(WORLD_FRAME, BODY_FRAME), SENSOR_PERIOD_NS, NAVIGATION),
    Topic("imu_attitude", imu(IMU_FRAME), CONTROL_PERIOD_NS, NAVIGATION),
    Topic("imu_bias", _joints(*IMU_AXES), CONTROL_PERIOD_NS, NAVIGATION),
    Topic("rotor_state", _joints("rotor"), CONTROL_PERIOD_NS, NAVIGATION, (SUPERVISOR, MOTOR_CONTROLLER)),
    Topic(
        "flight_state",
        _joints("flight_state", "rotor", "fan", "controller"),
        CONTROL_PERIOD_NS,
        SUPERVISOR,
        (BENCH_SIM, MOTOR_CONTROLLER, POSITION_CONTROLLER, ATTITUDE_CONTROLLER, IDENTIFICATION),
    ),
    Topic(
        "reference",
        pose_stamped(WORLD_FRAME),
        CONTROL_PERIOD_NS,
        SUPERVISOR,
        (POSITION_CONTROLLER, IDENTIFICATION),
    ),
    Topic(
        "velocity_reference",
        twist_stamped(HEADING_FRAME),
        CONTROL_PERIOD_NS,
        POSITION_CONTROLLER,
        (ATTITUDE_CONTROLLER,),
    ),
    Topic(
        "servo_command",
        _joints(*SERVO_CHANNELS),
        CONTROL_PERIOD_NS,
        ATTITUDE_CONTROLLER,
        (BENCH_SIM, IDENTIFICATION),
    ),
    Topic("motor_command", _joints("motor"), CONTROL_PERIOD_NS, MOTOR_CONTROLLER, (BENCH_SIM,)),
    Topic("excitation", _joints(*SERVO_CHANNELS), CONTROL_PERIOD_NS, IDENTIFICATION, (BENCH_SIM,)),
    Topic(
        "reference_excitation",
        twist_stamped(HEADING_FRAME),
        CONTROL_PERIOD_NS,
        IDENTIFICATION,
        (POSITION_CONTROLLER,),
    ),
    Topic("motor_excitation", _joints("motor"), CONTROL_PERIOD_NS, IDENTIFICATION, (BENCH_SIM,)),
    Topic("estimate", _joints(*ESTIMATED), ESTIMATE_PERIOD_NS, IDENTIFICATION),
    Topic(
        "recorder_ack",
        header(RIG_FRAME),
        CONTROL_PERIOD_NS,
        RECORDER,
        (BENCH_SIM,),
        hashed=False,
    ),
)

TOPICS: dict[str, Topic] = {topic.name: topic for topic in _TABLE}
DATA_TOPICS: tuple[str, ...] = tuple(topic.name for topic in _TABLE if topic.hashed)


def data_topics(running: Container[str] = ()) -> tuple[str, ...]:
    """The data topics of a flight: all, but those of optional nodes only where these run."""
    sources = {name: TOPICS[name].source for name in DATA_TOPICS}
    return tuple(name for name, by in sources.items() if by not in OPTIONAL_NODES or by in running)


def listeners(topic: str, running: tuple[str, ...]) -> tuple[str, ...]:
    """The nodes among those running that subscribe to a topic, the recorder included.

    Raises:
        KeyError: no such topic.
    """
    entry = TOPICS[topic]
    consumers = entry.listeners + ((RECORDER,) if entry.hashed else ())
    return tuple(name for name in consumers if name in running)
