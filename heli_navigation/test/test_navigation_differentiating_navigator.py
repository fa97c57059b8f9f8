from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from math import atan2, cos, hypot, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.component import Message
from heli_common.rig_geometry import ARM_AZIMUTH, RADIAN_PER_COUNT, RigGeometry
from heli_common.rotations import Euler, Vector3, matrix_from_euler
from heli_common.timing import SENSOR_PERIOD_NS, is_control_tick
from heli_common.topics import TOPICS
from heli_common.vehicle_state import UNKNOWN_VARIANCE, VehicleState, state_from_odometry
from heli_navigation.arm_kinematics import arm_jacobian
from heli_navigation.differentiating_navigator import (
    DifferentiatingNavigator,
    DifferentiatorParameters,
    rates_from_euler,
)

GEOMETRY = RigGeometry()
PARAMETERS = DifferentiatorParameters()
Motion = Callable[[float], tuple[Vector3, Euler]]


def arms_of(position: Vector3) -> Vector3:
    angles = []
    height = GEOMETRY.centre_height - position[2]
    for azimuth in ARM_AZIMUTH:
        outward = position[0] * cos(azimuth) + position[1] * sin(azimuth) + GEOMETRY.platform_radius
        sideways = position[1] * cos(azimuth) - position[0] * sin(azimuth)
        reach = outward - GEOMETRY.base_radius
        span = hypot(reach, height)
        square = GEOMETRY.forearm**2 - sideways**2
        cosine = (GEOMETRY.upper_arm**2 + span**2 - square) / (2.0 * GEOMETRY.upper_arm * span)
        angles.append(atan2(height, reach) - math.acos(cosine))
    return (angles[0], angles[1], angles[2])


def encoders(position: Vector3, attitude: Euler, indexed: float = 1.0, exact: bool = False) -> list[float]:
    angles = [*arms_of(position), *attitude]
    if not exact:
        angles = [RADIAN_PER_COUNT * round(angle / RADIAN_PER_COUNT) for angle in angles]
    return [*angles, *[0.0] * 6, *[indexed] * 6]


def rotor(speed: float) -> list[float]:
    return [0.0, speed, 0.0]


def fly(
    navigator: DifferentiatingNavigator, motion: Motion, duration: float, exact: bool = True
) -> list[Message]:
    """Messages sent while the helicopter moves as told from time 0."""
    sent = []
    for stamp in range(0, round(duration * 1e9), SENSOR_PERIOD_NS):
        sent += navigator.receive("encoders", stamp, encoders(*motion(stamp * 1e-9), exact=exact))
        if is_control_tick(stamp):
            sent += navigator.receive("rotor", stamp, rotor(163.0))
    return sent


def states(messages: Sequence[Message]) -> list[VehicleState]:
    return [state_from_odometry(list(m.values)) for m in messages if m.topic == "odometry"]


def still(position: Vector3, attitude: Euler) -> Motion:
    return lambda time: (position, attitude)


def test_standing_helicopter_is_where_its_encoders_say() -> None:
    position, attitude = (0.1, -0.2, 0.3), Euler(0.5, -0.1, 0.2)
    sent = fly(DifferentiatingNavigator(PARAMETERS, GEOMETRY), still(position, attitude), 0.03)
    assert [(m.topic, m.stamp_ns) for m in sent] == [
        (topic, stamp) for stamp in (0, 10_000_000, 20_000_000) for topic in ("odometry", "rotor_state")
    ]
    assert all(len(m.values) == len(TOPICS[m.topic].layout.fields) for m in sent)
    for state in states(sent):
        assert state.known
        assert state.position == pytest.approx(position, abs=1e-12)
        assert state.attitude == pytest.approx(attitude, abs=1e-12)
        assert state.velocity == pytest.approx((0, 0, 0), abs=1e-12)
        assert state.rates == (0.0, 0.0, 0.0)
    assert list(sent[-1].values) == [0.0, 163.0, 0.0]


def test_flight_north_with_the_nose_east_is_velocity_to_the_left() -> None:
    motion: Motion = lambda time: ((0.2 * time - 0.1, 0.0, 0.0), Euler(math.pi / 2.0, 0.0, 0.0))  # noqa: E731
    state = states(fly(DifferentiatingNavigator(PARAMETERS, GEOMETRY), motion, 1.0))[-1]
    assert state.velocity == pytest.approx((0.0, -0.2, 0.0), abs=1e-9)


def test_turning_helicopter_has_the_rates_of_the_kinematic_relation() -> None:
    motion: Motion = lambda time: ((0, 0, 0), Euler(0.8 * time, 0.2 + 0.1 * time, -0.1 + 0.3 * time))  # noqa: E731
    state = states(fly(DifferentiatingNavigator(PARAMETERS, GEOMETRY), motion, 0.6))[-1]
    assert state.rates == pytest.approx(rates_from_euler(state.attitude, 0.8, 0.1, 0.3), abs=1e-6)


angle = st.floats(-1.0, 1.0)


@settings(deadline=None, max_examples=40)
@given(angle, angle, angle, angle, angle, angle)
def test_rates_agree_with_the_derivative_of_the_rotation_matrix(
    psi: float, theta: float, phi: float, yaw: float, pitch: float, roll: float
) -> None:
    step = 1e-6
    c = np.array(matrix_from_euler(Euler(psi, theta, phi)))
    ahead = np.array(matrix_from_euler(Euler(psi + yaw * step, theta + pitch * step, phi + roll * step)))
    behind = np.array(matrix_from_euler(Euler(psi - yaw * step, theta - pitch * step, phi - roll * step)))
    skew = c.T @ (ahead - behind) / (2.0 * step)  # C' dC/dt is the cross-product matrix of the rates
    p, q, r = rates_from_euler(Euler(psi, theta, phi), yaw, pitch, roll)
    np.testing.assert_allclose([skew[2, 1], skew[0, 2], skew[1, 0]], [p, q, r], atol=1e-8)


@pytest.mark.parametrize("missing", range(6))
def test_nothing_is_known_until_every_encoder_is_indexed(missing: int) -> None:
    navigator = DifferentiatingNavigator(PARAMETERS, GEOMETRY)
    values = encoders((0.1, 0.2, 0.3), Euler(0.5, 0.1, 0.1))
    values[12 + missing] = 0.0
    navigator.receive("rotor", 0, rotor(0.0))
    message = navigator.receive("encoders", 0, values)[0]
    state = state_from_odometry(list(message.values))
    assert state == VehicleState((0, 0, 0), Euler(0, 0, 0), (0, 0, 0), (0, 0, 0), known=False)
    assert message.values[7] == UNKNOWN_VARIANCE
    assert all(math.isfinite(value) for value in message.values)


def test_first_known_sample_starts_without_a_jump() -> None:
    navigator = DifferentiatingNavigator(PARAMETERS, GEOMETRY)
    for stamp in range(0, 50_000_000, SENSOR_PERIOD_NS):
        # before the index pulse the counts are those from power-up
        navigator.receive("encoders", stamp, encoders((0.0, 0.0, 0.4), Euler(0.0, 0.0, 0.0), indexed=0.0))
    navigator.receive("rotor", 50_000_000, rotor(0.0))
    sent = navigator.receive("encoders", 50_000_000, encoders((0.1, 0.0, 0.4), Euler(0.3, 0.0, 0.0)))
    state = states(sent)[0]
    assert state.known
    assert state.velocity == (0.0, 0.0, 0.0)
    assert state.rates == (0.0, 0.0, 0.0)


def test_impossible_arms_keep_the_last_pose_and_are_counted() -> None:
    navigator = DifferentiatingNavigator(PARAMETERS, GEOMETRY)
    motion: Motion = lambda time: ((0.2 * time, 0.0, 0.0), Euler(0.1, 0.0, 0.0))  # noqa: E731
    before = states(fly(navigator, motion, 0.5))[-1]
    wrong = encoders((0.1, 0.0, 0.0), Euler(0.1, 0.0, 0.0))
    wrong[0:3] = [0.0, 0.0, 0.0]
    for stamp in range(500_000_000, 510_000_001, SENSOR_PERIOD_NS):
        sent = navigator.receive("encoders", stamp, wrong)
    sent = navigator.receive("rotor", 510_000_000, rotor(163.0))
    state = states(sent)[0]
    assert navigator.rejected == 5
    assert not state.known
    assert state.position == pytest.approx(before.position, abs=0.002)
    after = []
    for stamp in range(512_500_000, 530_000_001, SENSOR_PERIOD_NS):
        if is_control_tick(stamp):
            navigator.receive("rotor", stamp, rotor(163.0))
        after += navigator.receive("encoders", stamp, encoders(*motion(stamp * 1e-9), exact=True))
    assert navigator.gaps == 1
    for state in states(after):
        assert state.known
        assert state.velocity == pytest.approx(before.velocity, abs=0.003)


def test_output_does_not_depend_on_how_the_inputs_interleave() -> None:
    motion: Motion = lambda time: ((0.1 * sin(3 * time), 0.05, 0.1), Euler(0.2 * time, 0.0, 0.1))  # noqa: E731
    stamps = range(0, 200_000_000, SENSOR_PERIOD_NS)
    in_step = fly(DifferentiatingNavigator(PARAMETERS, GEOMETRY), motion, 0.2, exact=False)
    rotor_late, rotor_early = (
        DifferentiatingNavigator(PARAMETERS, GEOMETRY),
        DifferentiatingNavigator(PARAMETERS, GEOMETRY),
    )
    late, early = [], []
    for stamp in stamps:
        late += rotor_late.receive("encoders", stamp, encoders(*motion(stamp * 1e-9)))
    for stamp in filter(is_control_tick, stamps):
        late += rotor_late.receive("rotor", stamp, rotor(163.0))
        early += rotor_early.receive("rotor", stamp, rotor(163.0))
    for stamp in stamps:
        early += rotor_early.receive("encoders", stamp, encoders(*motion(stamp * 1e-9)))
    assert late == in_step
    assert early == in_step


def test_error_over_sigma_is_about_one_or_less() -> None:
    """Hover of a few centimetres, quantised encoders, against the same filters on exact angles."""
    rng = np.random.default_rng(1)
    amplitude, phase = rng.uniform(0.005, 0.03, (6, 4)), rng.uniform(0, 2 * math.pi, (6, 4))
    omega = np.array([0.7, 1.9, 3.1, 5.3])

    def motion(time: float) -> tuple[Vector3, Euler]:
        wave = [float(amplitude[i] @ np.sin(omega * time + phase[i])) for i in range(6)]
        return (wave[0], wave[1], wave[2]), Euler(wave[3], wave[4], wave[5])

    quantised = fly(DifferentiatingNavigator(PARAMETERS, GEOMETRY), motion, 8.0, exact=False)
    exact = fly(DifferentiatingNavigator(PARAMETERS, GEOMETRY), motion, 8.0, exact=True)
    sigma = [np.sqrt(np.abs(np.array(m.values))) for m in quantised if m.topic == "odometry"][200:]
    pairs = list(zip(states(quantised)[200:], states(exact)[200:], strict=True))
    north = [(a.position[0] - b.position[0]) / s[7 + 7] for (a, b), s in zip(pairs, sigma, strict=True)]
    up = [(a.position[2] - b.position[2]) / s[7 + 14] for (a, b), s in zip(pairs, sigma, strict=True)]
    yaw = [(a.attitude.psi - b.attitude.psi) / s[7 + 35] for (a, b), s in zip(pairs, sigma, strict=True)]
    for ratio in (north, up, yaw):
        assert 0.8 < np.sqrt(np.mean(np.square(ratio))) < 1.2
    for axis in range(3):
        velocity = [
            (a.velocity[axis] - b.velocity[axis]) / s[49 + 7 * axis]
            for (a, b), s in zip(pairs, sigma, strict=True)
        ]
        rate = [
            (a.rates[axis] - b.rates[axis]) / s[49 + 21 + 7 * axis]
            for (a, b), s in zip(pairs, sigma, strict=True)
        ]
        assert 0.2 < np.sqrt(np.mean(np.square(velocity))) < 1.1  # sigma is that of the worst motion
        assert 0.2 < np.sqrt(np.mean(np.square(rate))) < 1.1


def test_position_variance_is_in_enu_order() -> None:
    position = (0.4, 0.0, 0.1)
    message = fly(DifferentiatingNavigator(PARAMETERS, GEOMETRY), still(position, Euler(0, 0, 0)), 0.01)[0]
    east, north, up = (message.values[7 + 7 * axis] for axis in range(3))
    jacobian = np.array(arm_jacobian(arms_of(position), position, GEOMETRY))
    variance = RADIAN_PER_COUNT**2 / 12.0 * np.diag(jacobian @ jacobian.T)
    assert [north, east, up] == pytest.approx(list(variance))
    assert north != pytest.approx(east, rel=0.01)


@pytest.mark.parametrize(
    ("topic", "index", "field"),
    [("encoders", 3, "position.yaw"), ("encoders", 12, "effort.arm_1"), ("rotor", 1, "velocity.rotor")],
)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_is_refused(topic: str, index: int, field: str, value: float) -> None:
    values = encoders((0, 0, 0), Euler(0, 0, 0)) if topic == "encoders" else rotor(1.0)
    values[index] = value
    with pytest.raises(ValueError, match=f"{topic}: {field} is {value}"):
        DifferentiatingNavigator(PARAMETERS, GEOMETRY).receive(topic, 0, values)


def test_another_topic_is_refused() -> None:
    with pytest.raises(ValueError, match="'odometry' is none of"):
        DifferentiatingNavigator(PARAMETERS, GEOMETRY).receive("odometry", 0, [0.0])
