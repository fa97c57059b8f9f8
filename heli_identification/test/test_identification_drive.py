"""The drive: lag of the speed's converter, coefficients from voltage and speed, torque known or not."""

import numpy as np
import pytest

from heli_common.errors import InputError
from heli_identification.flight_signals import Channel, FlightSignals
from heli_identification.helicopter_structures import DRIVE, DRIVE_TORQUE
from heli_identification.parametrisation import Noise
from heli_identification.prediction_error import Estimate, prediction_error
from heli_identification.preparation import Segment, prepare
from heli_identification.published_coefficients import APPENDIX_MOTOR_TIME, published
from heli_identification.sampling import Hold, sample
from heli_identification.servo_timing import CONVERTER_LAG, after_converter, as_late_as_speed
from heli_identification.structures import Structure

PERIOD, FINE = 0.01, 0.0005
SECONDS = 20.0


def flown(load: float = -1.0, amplitude: float = 0.03) -> FlightSignals:
    """A chirp on the drive: voltage 5 ms late, speed through the converter's lag, on a grid of 0.5 ms."""
    truth = DRIVE_TORQUE.with_values({"D_Omega": load})
    model = sample(truth, truth.values, FINE)
    rng, count = np.random.default_rng(1), round(SECONDS / PERIOD)
    time = np.arange(count) * PERIOD
    voltage = amplitude * np.sin(2.0 * time + (100.0 - 2.0) * time**2 / (2.0 * SECONDS))
    x, converter, kept = np.zeros(2), 0.0, np.exp(-FINE / CONVERTER_LAG)
    speed, torque = np.zeros(count), np.zeros(count)
    steps = round(PERIOD / FINE)
    for tick in range(count):
        speed[tick], torque[tick] = converter, x[1]
        for step in range(steps):
            acting = voltage[tick] if step >= steps // 2 else voltage[max(tick - 1, 0)]
            before = x[0]
            x = model.A @ x + model.B[:, 0] * acting
            converter = kept * converter + (1.0 - kept) * 0.5 * (before + x[0])
    stamps = np.arange(count, dtype=np.int64) * 10_000_000
    speed = speed + 0.003 * rng.standard_normal(count)
    measured = {"Omega": Channel(stamps, 163.0 + speed), "M_A": Channel(stamps, 0.8 + torque)}
    moved = {"U_mot": Channel(stamps, 5.5 + voltage)}
    return FlightSignals("chirp", measured, moved, moved, {"U_mot": Channel(stamps, voltage)})


def estimated(structure: Structure, signals: FlightSignals) -> Estimate:
    record, _ = prepare(signals, structure, Segment())
    return prediction_error(structure, [record], noise=Noise.OUTPUT_ERROR, hold=Hold.LATE)


def test_the_converter_by_hand() -> None:
    """A step: what is missing until it is through is the lag; a ramp comes later by the lag."""
    step = np.ones((40, 1))
    step[0] = 0.0
    missing = np.sum(1.0 - after_converter(step, PERIOD)[1:]) * PERIOD
    assert missing == pytest.approx(CONVERTER_LAG, rel=1e-9)
    ramp = np.arange(40) * PERIOD
    assert as_late_as_speed(ramp, PERIOD)[-1] == pytest.approx(ramp[-1] - CONVERTER_LAG, rel=1e-9)


def test_coefficients_with_the_torque() -> None:
    found = estimated(DRIVE_TORQUE, flown())
    true = dict(zip(DRIVE_TORQUE.names, DRIVE_TORQUE.values.tolist(), strict=True)) | {"D_Omega": -1.0}
    value = dict(zip(found.names, found.values.tolist(), strict=True))
    for name in ("T_a", "k_U", "k_Omega", "k_a"):
        assert value[name] == pytest.approx(true[name], rel=0.015)
    assert value["D_Omega"] == pytest.approx(-1.0, abs=0.05)


def test_without_the_torque_the_load_hides_in_k_omega() -> None:
    """With M_A' fast, D_Omega Omega acts as -D_Omega / k_a more k_Omega; without load nothing hides."""
    value = dict(zip(DRIVE.free_names, estimated(DRIVE, flown(0.0)).values.tolist(), strict=True))
    assert value["T_a"] == pytest.approx(0.0134, rel=0.02) and value["k_U"] == pytest.approx(1.285, rel=0.01)
    assert value["k_Omega"] == pytest.approx(0.03854, rel=0.02)
    loaded = dict(zip(DRIVE.free_names, estimated(DRIVE, flown(-1.0)).values.tolist(), strict=True))
    assert loaded["k_Omega"] == pytest.approx(0.03854 + 1.0 / 103.46, rel=0.03)


def test_a_voltage_at_rest_is_refused() -> None:
    with pytest.raises(InputError, match="input U_mot is not excited"):
        prepare(flown(amplitude=0.005), DRIVE, Segment())


def test_the_source_contradicts_itself() -> None:
    assert published("drive")["Table 2.2"]["T_a"] == 0.0134 and APPENDIX_MOTOR_TIME == 0.043
    assert published("vertical") == {}
    # per degree in the scan: 2.65 is the model's 152 1/(s^2 rad)
    assert published("servo_rotor")["linearised"]["M_1"] == pytest.approx(151.83, abs=0.01)
