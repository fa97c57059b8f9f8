"""The whole filter on a made-up flight: its errors are as large as it says, with and without every sensor."""

import math

import numpy as np
import pytest
from synthetic_motion import GEOMETRY, INDEXED, PERIOD, feed, fly, nees

from heli_common.rig_geometry import RADIAN_PER_COUNT
from heli_common.vehicle_state import state_from_odometry
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.inertial_navigation import InertialNavigation

STILL = FilterParameters(vibration_once=0.0, vibration_twice=0.0)
"""The made-up rotor does not shake."""


def new() -> InertialNavigation:
    return InertialNavigation(STILL, GEOMETRY)


def seconds(begin: float, end: float) -> range:
    return range(round(begin / PERIOD), round(end / PERIOD))


def errors(navigation: InertialNavigation, flight: object, k: int) -> dict[str, np.ndarray]:
    state = navigation.state
    return {
        "position": np.array(state.position) - flight.position[k],
        "attitude": np.array(state.attitude) - flight.attitude[k],
        "velocity": np.array(state.velocity) - flight.velocity[k],
        "rates": np.array(state.rates) - flight.rates[k],
        "gyro bias": np.array(navigation.gyro_bias) - flight.gyro_bias[k],
        "force bias": np.array(navigation.accelerometer_bias) - flight.force_bias,
    }


def judged(navigation: InertialNavigation, flight: object, k: int) -> dict[str, float]:
    """Normalised squares of the errors of one sample."""
    error, (pose, twist) = errors(navigation, flight, k), navigation.covariances
    covariance = navigation.covariance
    return {
        "position": nees(error["position"], pose[:3, :3]),
        "attitude": nees(error["attitude"], covariance[6:9, 6:9]),
        "velocity": nees(error["velocity"], twist[:3, :3]),
        "rates": nees(error["rates"], twist[3:, 3:]),
        "gyro bias": nees(error["gyro bias"], covariance[9:12, 9:12]),
    }


def worst(navigation: InertialNavigation, flight: object, samples: range) -> dict[str, float]:
    """Largest errors over some samples, while they are fed."""
    found: dict[str, float] = {}
    for k in samples:
        feed(navigation, flight, range(k, k + 1))
        for name, error in errors(navigation, flight, k).items():
            found[name] = max(found.get(name, 0.0), float(np.abs(error).max()))
    return found


def test_errors_are_as_large_as_it_says() -> None:
    # over seeds and time, as the bench's own flights are judged: 0.6 .. 1.6 a degree of freedom
    means: dict[str, list[float]] = {}
    for seed in range(10):
        flight, navigation = fly(seed, 8.0), new()
        feed(navigation, flight, seconds(0.0, 3.0))
        for k in seconds(3.0, 8.0)[::40]:
            feed(navigation, flight, range(k, k + 40))
            for name, value in judged(navigation, flight, k + 39).items():
                means.setdefault(name, []).append(value)
        assert navigation.health.sound
        assert sum(navigation.health.refused) == 0
    for name, values in means.items():
        assert 0.6 < np.mean(values) < 1.6, name


def test_it_is_exact_without_noise() -> None:
    flight, navigation = fly(1, 6.0, noise=1e-3), new()
    feed(navigation, flight, seconds(0.0, 5.0))
    found = worst(navigation, flight, seconds(5.0, 6.0))
    assert found["position"] < 5e-4
    assert found["velocity"] < 2e-3
    assert math.degrees(found["attitude"]) < 0.02
    assert math.degrees(found["gyro bias"]) < 0.01


def test_nothing_is_known_before_the_index() -> None:
    navigation, flight = new(), fly(1, 0.1)
    angles = flight.angles[0].tolist()
    navigation.step(angles[:3], angles[3:], (1.0,) * 5 + (0.0,), (0.0,) * 3, (0.0,) * 3)
    assert not navigation.known
    assert not navigation.state.known
    assert not navigation.covariances[0].any()
    feed(navigation, flight, range(3))
    assert navigation.known
    # an encoder that has lost its index: all is forgotten
    navigation.step(angles[:3], angles[3:], (0.0,) * 6, (0.0,) * 3, (0.0,) * 3)
    assert not navigation.known


def test_biases_are_learnt_on_the_stop() -> None:
    flight, navigation = fly(3, 6.0, still=4.0), new()
    feed(navigation, flight, seconds(0.0, 4.0))
    assert navigation.health.standing
    k = round(4.0 / PERIOD) - 1
    error, deviations = errors(navigation, flight, k), navigation.bias_deviations
    assert np.abs(np.degrees(error["gyro bias"])).max() < 0.05
    assert np.abs(error["gyro bias"]).max() < 4.0 * max(deviations[:3])
    # a tilt of half a count cannot be told from a bias of 0.015 m/s^2, but down is down
    assert np.abs(error["force bias"]).max() < 4.0 * max(deviations[3:])
    assert abs(error["force bias"][2]) < 0.01
    found = worst(navigation, flight, seconds(4.0, 5.0))  # it leaves before a count changes
    assert not navigation.health.standing
    assert found["velocity"] < 0.05
    assert found["position"] < 8e-3
    found = worst(navigation, flight, seconds(5.0, 6.0))
    assert found["velocity"] < 0.015
    assert math.degrees(found["attitude"]) < 0.1


def test_a_gyros_jump_on_the_stop_is_found_as_well() -> None:
    flight, navigation = fly(3, 8.0, still=8.0), new()
    flight.gyro[seconds(3.0, 8.0), 1] += math.radians(1.0)
    feed(navigation, flight, seconds(0.0, 8.0))
    found = errors(navigation, flight, round(8.0 / PERIOD) - 1)["gyro bias"]
    assert math.degrees(found[1]) == pytest.approx(1.0, abs=0.1)
    assert navigation.health.gyro_jumps == 1


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_gyros_jump_in_flight_is_tracked_and_reported(axis: int) -> None:
    flight, navigation = fly(axis, 9.0), new()
    flight.gyro[seconds(5.0, 9.0), axis] += math.radians(1.0)
    feed(navigation, flight, seconds(0.0, 5.0))
    assert navigation.health.gyro_jumps == 0
    feed(navigation, flight, seconds(5.0, 9.0))
    found = np.degrees(errors(navigation, flight, len(flight) - 1)["gyro bias"])
    expected = np.eye(3)[axis]
    assert found == pytest.approx(expected, abs=0.06)
    assert navigation.health.gyro_jumps >= 1
    assert navigation.health.lost == ()


def test_an_accelerometers_jump_is_not_blamed_on_an_arm() -> None:
    flight, navigation = fly(5, 8.0), new()
    flight.force[seconds(4.0, 8.0), 1] += 0.3
    feed(navigation, flight, seconds(0.0, 7.0))
    found = worst(navigation, flight, seconds(7.0, 8.0))
    assert navigation.health.force_jumps >= 1
    assert navigation.health.lost == ()
    assert found["velocity"] < 0.015


def test_without_imu_it_goes_on_and_comes_back() -> None:
    flight, navigation = fly(6, 10.0), new()
    feed(navigation, flight, seconds(0.0, 4.0))
    flight.gyro[seconds(4.0, 7.0)], flight.force[seconds(4.0, 7.0)] = 99.0, -99.0  # must not matter
    values: dict[str, list[float]] = {}
    for k in seconds(4.0, 7.0):
        feed(navigation, flight, range(k, k + 1), imu_valid=False)
        for name, value in judged(navigation, flight, k).items():
            values.setdefault(name, []).append(value)
        assert np.abs(errors(navigation, flight, k)["position"]).max() < 0.01
        assert np.abs(errors(navigation, flight, k)["velocity"]).max() < 0.1
    assert navigation.health.without_imu
    for name in ("position", "attitude", "velocity", "rates"):
        assert np.mean(values[name]) < 1.6, name
    feed(navigation, flight, seconds(7.0, 9.0))
    found = worst(navigation, flight, seconds(9.0, 10.0))
    assert not navigation.health.without_imu
    assert navigation.health.lost == ()
    assert found["velocity"] < 0.015
    assert math.degrees(found["gyro bias"]) < 0.06


@pytest.mark.parametrize("encoder", [0, 1, 2, 3, 4, 5])
def test_lost_counts_are_found_and_the_rest_goes_on(encoder: int) -> None:
    flight, navigation = fly(7, 8.0), new()
    flight.angles[seconds(4.0, 8.0), encoder] += 12 * RADIAN_PER_COUNT
    feed(navigation, flight, seconds(0.0, 4.0))
    found = worst(navigation, flight, seconds(4.0, 8.0))
    assert navigation.health.lost == (("arm_1", "arm_2", "arm_3", "yaw", "pitch", "roll")[encoder],)
    assert not navigation.health.sound
    assert found["position"] < 0.03
    assert math.degrees(found["attitude"]) < 0.3
    values = judged(navigation, flight, len(flight) - 1)
    assert max(values["position"], values["attitude"], values["velocity"]) < 10.0


@pytest.mark.parametrize("encoder", [0, 1, 2, 3, 4, 5])
def test_a_stuck_encoder_is_found_and_comes_back(encoder: int) -> None:
    flight, navigation = fly(8, 9.0), new()
    stuck = seconds(4.0, 6.0)
    flight.angles[stuck, encoder] = flight.angles[stuck[0], encoder]
    feed(navigation, flight, seconds(0.0, 4.0))
    found = worst(navigation, flight, stuck)
    assert found["position"] < 0.02
    assert math.degrees(found["attitude"]) < 1.0
    feed(navigation, flight, seconds(6.0, 8.0))
    after = worst(navigation, flight, seconds(8.0, 9.0))
    assert navigation.health.lost == ()
    assert navigation.health.restarts == 0
    assert after["position"] < 2e-3
    assert after["velocity"] < 0.015
    assert math.degrees(after["attitude"]) < 0.1


@pytest.mark.parametrize("encoder", [1, 4])
def test_one_wrong_reading_is_refused_and_forgotten(encoder: int) -> None:
    flight, navigation = fly(9, 5.0), new()
    k = round(4.0 / PERIOD)
    flight.angles[k, encoder] += 2 * RADIAN_PER_COUNT
    feed(navigation, flight, range(k))
    before = errors(navigation, flight, k - 1)
    feed(navigation, flight, range(k, k + 1))
    assert navigation.health.refused[encoder] == 1
    assert np.abs(errors(navigation, flight, k)["position"] - before["position"]).max() < 1e-3
    feed(navigation, flight, range(k + 1, len(flight)))
    assert navigation.health.sound
    assert sum(navigation.health.refused) <= 2
    last = judged(navigation, flight, len(flight) - 1)
    assert max(last["position"], last["attitude"], last["velocity"]) < 6.0


def test_readings_that_never_came() -> None:
    flight, navigation = fly(10, 6.0), new()
    lacking = flight.angles.copy()
    flight.angles[seconds(4.0, 5.0), 2] = math.nan  # one encoder says nothing
    feed(navigation, flight, seconds(0.0, 4.5))
    navigation.skip(20)  # and then nobody does
    feed(navigation, flight, seconds(4.55, 6.0))
    assert lacking.shape == flight.angles.shape
    assert navigation.health.sound
    last = errors(navigation, flight, len(flight) - 1)
    assert np.abs(last["position"]).max() < 2e-3
    assert np.abs(last["velocity"]).max() < 0.02


def test_numbers_that_are_none_are_refused() -> None:
    flight, navigation = fly(11, 1.0), new()
    feed(navigation, flight, range(100))
    angles = flight.angles[100].tolist()
    with pytest.raises(ValueError, match="imu"):
        navigation.step(angles[:3], angles[3:], INDEXED, (math.nan, 0.0, 0.0), (0.0, 0.0, -9.81))
    feed(navigation, flight, range(100, 300))
    assert navigation.known
    assert navigation.health.restarts == 1


def test_it_gives_the_same_numbers_twice() -> None:
    flight = fly(12, 1.0)
    first, second = new(), new()
    feed(first, flight, range(400))
    feed(second, flight, range(400))
    assert np.array_equal(first.covariance, second.covariance)
    assert first.state == second.state
    covariance = first.covariance
    assert np.array_equal(covariance, covariance.T)
    covariance[:] = 0.0  # a copy
    assert first.covariance.any()


def test_several_samples_at_once_are_the_same_as_one_after_the_other() -> None:
    """Bit for bit: before it begins, while an encoder is not indexed, and after the estimate was lost."""
    flight = fly(4, 3.0, still=1.0)
    counts = np.rint(flight.angles / RADIAN_PER_COUNT)
    samples = np.hstack([counts, np.ones_like(counts), flight.gyro, flight.force, np.zeros((len(counts), 1))])
    samples[:160, 8] = 0.0
    samples[800:803, 9] = 0.0
    one, many = new(), new()
    for first in range(0, len(samples), 4):
        if first == 1000:  # both lose their estimate
            one._memory[3] = many._memory[3] = np.inf
        for row in samples[first : first + 4].tolist():
            angles = [count * RADIAN_PER_COUNT for count in row[:6]]
            one.step(angles[:3], angles[3:], row[6:12], row[12:15], row[15:18])
        many.run(samples[first : first + 4])
        np.testing.assert_array_equal(one._memory, many._memory)
        assert one.health == many.health
    assert one.known and one.health.restarts == 1


def test_a_supervisor_sees_what_an_odometry_tells() -> None:
    """Bit for bit, though the way back from a quaternion moves the angles by a bit."""
    flight = fly(5, 2.0, still=1.0)
    navigation, seen = new(), np.zeros(15)
    feed(navigation, flight, range(len(flight)))
    assert navigation.see(seen)
    values = navigation.odometry.tolist()
    known = state_from_odometry(values)
    assert seen[:12].tolist() == [*known.position, *known.attitude, *known.velocity, *known.rates]
    assert seen[12:].tolist() == [values[14], values[7], values[21]]
