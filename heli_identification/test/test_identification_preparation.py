"""Preparation: alignment, averaging, refusals that say what is missing; servo timing by hand."""

import math

import numpy as np
import pytest
from closed_loop_data import TRUTH, flown
from test_identification_structures import lag

from heli_common.errors import InputError
from heli_identification.flight_signals import Channel, FlightSignals
from heli_identification.preparation import InputSource, Segment, averaged, centred, prepare
from heli_identification.records import Record
from heli_identification.servo_timing import ServoTiming, servo_positions

TICK = 10_000_000


def signals(count: int = 400, **changes: np.ndarray) -> FlightSignals:
    """A flight of the twin with 0.1 added to theta and 0.02 to B_1s."""
    record = flown(1, count / 100.0)
    stamps = np.arange(count, dtype=np.int64) * TICK

    def named(names: tuple[str, ...], columns: np.ndarray) -> dict[str, Channel]:
        return {n: Channel(stamps, changes.get(n, columns[:, i])) for i, n in enumerate(names)}

    y, u = record.y.copy(), record.u.copy()
    y[:, 0] += 0.1
    u[:, 0] += 0.02
    return FlightSignals("flight", named(record.outputs, y), named(record.inputs, u), named(record.inputs, u))


WHOLE = Segment()


def test_segment_mean_and_alignment() -> None:
    data = signals()
    # one channel lacks the first five samples: all others are cut to what they share
    late = data.measured["q"]
    data.measured["q"] = Channel(late.stamps[5:], late.values[5:])
    record, point = prepare(data, TRUTH, Segment(0.0, 3.5))
    assert len(record) == 346 and record.inputs == ("B_1s", "A_1s") and record.r is None
    assert record.y[0, 4] + point["q"] == pytest.approx(late.values[5])
    assert point["theta"] == pytest.approx(data.measured["theta"].values[5:351].mean())
    assert abs(record.u.mean(axis=0)).max() < 1e-12


def test_operating_point_that_is_given() -> None:
    record, point = prepare(signals(), TRUTH, WHOLE, operating_point={"theta": 0.1, "B_1s": 0.02})
    assert point["theta"] == 0.1 and point["u"] == 0.0
    assert record.y[:, 0] == pytest.approx(flown(1, 4.0).y[:, 0])
    assert centred(record, {})[0].y == pytest.approx(record.y)


def test_averaging_by_hand() -> None:
    spike = np.zeros((60, 1))
    spike[30] = 1.0
    found = averaged(Record("spike", 0.01, ("u",), ("x",), spike, spike))
    # a triangle, symmetric about the spike: no phase; nine samples cut off at either end
    assert len(found) == 60 - 18
    assert found.y[21 - 9 : 21 + 10, 0] == pytest.approx(
        np.append(np.arange(1, 11), np.arange(9, 0, -1)) / 100
    )


def test_averaging_is_6_db_down_at_28_rad_s() -> None:
    time = np.arange(2000) * 0.01
    wave = np.sin(28.0 * time)[:, None]
    found = averaged(Record("wave", 0.01, ("u",), ("x",), wave, wave)).y
    assert 20.0 * math.log10(np.ptp(found) / 2.0) == pytest.approx(-6.0, abs=0.15)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (signals(theta=np.zeros(400)), "flight: output theta is constant"),
        (signals(A_1s=np.full(400, 0.01)), "flight: input A_1s is constant"),
        (
            signals(A_1s=1e-4 * np.random.default_rng(1).standard_normal(400)),
            "input A_1s is not excited: it moves by .*add an excitation",
        ),
        (signals(q=np.full(400, np.nan)), "output q is not finite"),
        (signals(150), "1.50 s of data are too short for 18 coefficients.*at least 2.0 s"),
    ],
)
def test_useless_data_are_refused(data: FlightSignals, message: str) -> None:
    with pytest.raises(InputError, match=message):
        prepare(data, TRUTH, WHOLE)


def test_one_sine_does_not_excite_eight_states() -> None:
    wave = 0.02 * np.sin(np.arange(400) * 0.03)
    with pytest.raises(InputError, match="excite 2 of 36 directions only"):
        prepare(signals(B_1s=wave, A_1s=wave * 0.5), TRUTH, WHOLE)


def test_missing_empty_and_wrong_rate() -> None:
    data = signals()
    with pytest.raises(InputError, match=r"segment 90-95 holds no data.*0.00-3.99 s"):
        prepare(data, TRUTH, Segment(90.0, 95.0))
    slow = {n: Channel(c.stamps * 2, c.values) for n, c in data.measured.items()}
    slow_inputs = {n: Channel(c.stamps * 2, c.values) for n, c in data.actuators.items()}
    with pytest.raises(InputError, match=r"samples come every 20 ms.*every 10 ms"):
        prepare(FlightSignals("slow", slow, slow_inputs, slow_inputs), TRUTH, WHOLE)
    holed = {n: Channel(np.delete(c.stamps, 100), np.delete(c.values, 100)) for n, c in data.measured.items()}
    with pytest.raises(InputError, match=r"a gap of 20 ms at 0\.99 s"):
        prepare(FlightSignals("holed", holed, data.actuators, {}), TRUTH, WHOLE)
    with pytest.raises(InputError, match="no command signal B_1s"):
        prepare(FlightSignals("x", data.measured, {}, {}), TRUTH, WHOLE, source=InputSource.COMMAND)
    with pytest.raises(InputError, match="share no stamp"):
        apart = {n: Channel(c.stamps + 1, c.values) for n, c in data.actuators.items()}
        prepare(FlightSignals("x", data.measured, apart, {}), TRUTH, WHOLE)
    with pytest.raises(InputError, match="no actuator signal u"):
        prepare(data, lag(), WHOLE)


def test_servo_latches_every_second_command() -> None:
    stamps = np.arange(12, dtype=np.int64) * TICK
    commands, size = np.zeros((12, 1)), 0.01
    commands[3] = size  # 30 ms: no frame begins with it
    assert np.all(servo_positions(stamps, commands, ("theta_0",)) == 0.0)
    commands[4:] = size  # 40 ms: latched at 45 ms
    found = servo_positions(stamps, commands, ("theta_0",))[:, 0]
    assert np.all(found[:5] == 0.0)
    # second order, 5 ms after the latch, by its closed formula
    w, z, t = 50.0 * math.pi, 0.7, 0.005
    damped = w * math.sqrt(1.0 - z * z)
    step = 1.0 - math.exp(-z * w * t) * (math.cos(damped * t) + z * w / damped * math.sin(damped * t))
    assert found[5] == pytest.approx(size * step, rel=1e-9)
    assert found[-1] == pytest.approx(size, rel=0.01)


def test_servo_is_no_faster_than_its_rate() -> None:
    """A large step of B_1s: the servo at the nose moves six times as far, at 500 deg/s."""
    stamps = np.arange(12, dtype=np.int64) * TICK
    commands = np.zeros((12, 2))
    commands[4:, 0] = 0.1
    found = servo_positions(stamps, commands, ("B_1s", "A_1s"), ServoTiming(bandwidth=900.0))
    slope = np.diff(found[5:7, 0])[0] / 0.01
    # the other two shafts go half as far: free, they are ahead, so the plate lies between both rates
    assert math.radians(500.0) / 6.0 <= slope <= 2.0 * math.radians(500.0) / 6.0
    assert found[:, 1] == pytest.approx(np.zeros(12), abs=1e-12)


def test_servo_stands_at_the_first_command() -> None:
    stamps, commands = np.arange(10, dtype=np.int64) * TICK, np.full((10, 2), 0.3)
    names = ("theta_0", "theta_t")
    assert servo_positions(stamps, commands, names, ServoTiming(damping=0.5)) == pytest.approx(commands)
    with pytest.raises(ValueError, match="'U_mot' is none of"):
        servo_positions(stamps, commands[:, :1], ("U_mot",))
