"""The navigator as a component: joining encoders and IMU, silence, gaps, what it sends."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.component import Message
from heli_common.rig_geometry import RADIAN_PER_COUNT, RigGeometry
from heli_common.timing import CONTROL_PERIOD_NS, SENSOR_PERIOD_NS
from heli_common.topics import TOPICS
from heli_common.vehicle_state import UNKNOWN_VARIANCE, imu_values, state_from_odometry
from heli_navigation.arm_kinematics import arms_from_position
from heli_navigation.navigator import IMU_PATIENCE, LONGEST_SKIP, NavigationParameters, Navigator

GEOMETRY = RigGeometry()
HEIGHT = -0.1
LEVEL = imu_values((0.0, 0.0, 0.0), (0.0, 0.0, -9.81), (1e-5, 1e-3))
SILENT = imu_values((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1e-5, 1e-3), valid=False)


def new() -> Navigator:
    return Navigator(NavigationParameters(), GEOMETRY)


def counted(indexed: bool = True) -> tuple[float, ...]:
    arms = arms_from_position((0.0, 0.0, HEIGHT), GEOMETRY)
    angles = [RADIAN_PER_COUNT * round(angle / RADIAN_PER_COUNT) for angle in arms]
    return (*angles, *(0.0,) * 9, *(float(indexed),) * 6)


def hear(navigator: Navigator, topic: str, stamp_ns: int, values: tuple[float, ...]) -> list[Message]:
    """All that a message leads to."""
    return navigator.receive(topic, stamp_ns, values) + navigator.update()


def feed(navigator: Navigator, samples: range, imu: tuple[float, ...] | None = LEVEL) -> list[Message]:
    sent = []
    for sample in samples:
        stamp = sample * SENSOR_PERIOD_NS
        sent += hear(navigator, "encoders", stamp, counted())
        if imu is not None:
            sent += hear(navigator, "imu", stamp, imu)
    return sent


def of(topic: str, sent: list[Message]) -> list[Message]:
    return [message for message in sent if message.topic == topic]


def on_the_wire(sent: list[Message]) -> list[tuple[str, bytes]]:
    return [(topic, TOPICS[topic].layout.pack(stamp, values)) for topic, stamp, values in sent]


def test_every_output_has_its_rate_and_its_length() -> None:
    navigator = new()
    sent = feed(navigator, range(41))
    sent += navigator.receive("rotor", 0, (0.0, 160.0, 0.0))
    assert set(navigator.outputs) == {message.topic for message in sent}
    for topic in navigator.outputs:
        assert TOPICS[topic].source == navigator.name
        stamps = [message.stamp_ns for message in of(topic, sent)]
        if topic != "rotor_state":
            assert stamps == list(range(0, 100_000_001, TOPICS[topic].period_ns))
    for message in sent:
        assert len(message.values) == len(TOPICS[message.topic].layout.fields)
        assert all(math.isfinite(value) for value in message.values)


def test_nothing_is_known_before_the_index_pulses() -> None:
    navigator = new()
    sent = navigator.receive("encoders", 0, counted(indexed=False))
    sent += navigator.receive("imu", 0, LEVEL)
    (odometry,) = of("odometry", sent)
    assert not state_from_odometry(odometry.values).known
    assert odometry.values[7] == UNKNOWN_VARIANCE
    assert navigator.complaints == ""


def test_a_helicopter_at_rest_is_where_it_is() -> None:
    sent = feed(new(), range(400))
    state = state_from_odometry(of("odometry", sent)[-1].values)
    assert state.known
    assert state.position == pytest.approx((0.0, 0.0, HEIGHT), abs=2e-3)
    assert state.velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-2)
    variance = of("odometry", sent)[-1].values[7]
    assert 0.0 < variance < (2e-3) ** 2


@settings(deadline=None, max_examples=20)
@given(st.lists(st.booleans(), min_size=16, max_size=16))
def test_it_does_not_matter_which_of_two_inputs_comes_first(imu_first: list[bool]) -> None:
    in_step = feed(new(), range(16))
    navigator, sent = new(), []
    for sample, first in enumerate(imu_first):
        stamp = sample * SENSOR_PERIOD_NS
        both = [("encoders", counted()), ("imu", LEVEL)]
        for topic, values in reversed(both) if first else both:
            sent += hear(navigator, topic, stamp, values)
    assert on_the_wire(sent) == on_the_wire(in_step)


def test_an_imu_that_is_ahead_or_behind_by_some_samples_changes_nothing() -> None:
    in_step = feed(new(), range(40))
    for order in ((0, 4), (4, 0)):
        navigator, sent = new(), []
        for step in range(44):
            for topic, late, values in (("encoders", order[0], counted()), ("imu", order[1], LEVEL)):
                if 0 <= step - late < 40:
                    sent += hear(navigator, topic, (step - late) * SENSOR_PERIOD_NS, values)
        assert on_the_wire(sent) == on_the_wire(in_step)


def test_the_odometry_is_there_before_what_nobody_waits_for() -> None:
    in_step, navigator, sent = feed(new(), range(9)), new(), []
    for sample in range(9):
        stamp = sample * SENSOR_PERIOD_NS
        navigator.receive("encoders", stamp, counted())
        first = navigator.receive("imu", stamp, LEVEL)
        assert {message.topic for message in first} <= {"odometry", "odometry_imu"}
        sent += first + navigator.update()
        assert navigator.update() == [], "once"
    assert on_the_wire(sent) == on_the_wire(in_step)


def test_without_being_asked_it_sends_the_rest_with_the_next_sample() -> None:
    navigator, sent = new(), []
    for sample in range(10):
        sent += navigator.receive("encoders", sample * SENSOR_PERIOD_NS, counted())
        sent += navigator.receive("imu", sample * SENSOR_PERIOD_NS, LEVEL)
    assert on_the_wire(sent + navigator.update()) == on_the_wire(feed(new(), range(10)))


def test_a_silent_imu_is_waited_for_once_and_welcomed_back() -> None:
    navigator = new()
    feed(navigator, range(100))
    waiting = feed(navigator, range(100, 100 + IMU_PATIENCE), imu=None)
    assert waiting == []
    released = feed(navigator, range(100 + IMU_PATIENCE, 101 + IMU_PATIENCE), imu=None)
    assert len(of("odometry_imu", released)) == IMU_PATIENCE + 1
    at_once = feed(navigator, range(101 + IMU_PATIENCE, 140), imu=None)
    assert len(of("odometry_imu", at_once)) == 140 - 101 - IMU_PATIENCE
    assert "no IMU" in navigator.complaints
    feed(navigator, range(140, 540))
    assert "no IMU" not in navigator.complaints


def test_samples_that_never_come_are_gone_over() -> None:
    navigator = new()
    feed(navigator, range(100))
    sent = feed(navigator, range(105, 140))
    assert navigator.gaps == 1
    assert of("odometry_imu", sent)[0].stamp_ns == 105 * SENSOR_PERIOD_NS
    assert state_from_odometry(of("odometry", sent)[-1].values).known
    later = 140 + 2 * LONGEST_SKIP
    sent = feed(navigator, range(later, later + 4))
    assert navigator.gaps == 2
    assert state_from_odometry(of("odometry_imu", sent)[-1].values).known


def test_invalid_samples_of_the_imu_are_told() -> None:
    navigator = new()
    feed(navigator, range(200))
    before = navigator.receive("encoders", 200 * SENSOR_PERIOD_NS, counted())
    before += navigator.receive("imu", 200 * SENSOR_PERIOD_NS, SILENT)
    after = feed(navigator, range(201, 280), SILENT)
    assert "no IMU" in navigator.complaints
    rates = TOPICS["odometry"].layout.fields.index("twist_covariance[21]")
    assert of("odometry_imu", after)[-1].values[rates] > of("odometry_imu", before)[-1].values[rates]


def test_rotor_speed_is_smoothed() -> None:
    navigator = new()
    for tick in range(100):
        (sent,) = navigator.receive("rotor", tick * CONTROL_PERIOD_NS, (0.0, 163.0, 0.0))
    assert sent.values[1] == pytest.approx(163.0, rel=1e-9)
    (sent,) = navigator.receive("rotor", 100 * CONTROL_PERIOD_NS, (0.0, 173.0, 0.0))
    assert 163.0 < sent.values[1] < 173.0


@pytest.mark.parametrize("topic", ["encoders", "imu", "rotor"])
def test_a_number_that_is_not_finite_is_refused_by_name(topic: str) -> None:
    values = [0.0] * len(TOPICS[topic].layout.fields)
    values[1] = math.nan
    with pytest.raises(ValueError, match=f"{topic}: .* is nan"):
        new().receive(topic, 0, values)


def test_another_topic_is_refused() -> None:
    with pytest.raises(ValueError, match="'clock' is none of"):
        new().receive("clock", 0, ())
