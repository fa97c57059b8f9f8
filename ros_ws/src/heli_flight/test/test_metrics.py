"""Figures of merit against responses whose figures are known in closed form."""

from __future__ import annotations

import json
from math import exp, log, pi, radians, sqrt
from pathlib import Path

import numpy as np
import pytest
import synthetic_flight as synthetic
from numpy.typing import NDArray

from heli_common.flight_state import FlightState, flight_state_values
from heli_common.rotations import Euler
from heli_common.topics import TOPICS
from heli_common.vehicle_state import VehicleState, odometry_values, pose_values
from heli_flight.bag_reader import Bag
from heli_flight.flight_record import FlightRecord
from heli_flight.metrics import flight_metrics, reference_legs, step_metrics

Array = NDArray[np.float64]
PERIOD, STILL = 0.01, (0.0, 0.0, 0.0)


def record_of(
    reference: Array, truth: Array, state: FlightState = FlightState.FLYING, without: tuple[str, ...] = ()
) -> FlightRecord:
    """A record whose reference and true pose (north, east, down, yaw) are given at 100 Hz."""
    messages: dict[str, list[bytes]] = {}

    def send(topic: str, stamp: int, values: tuple[float, ...]) -> None:
        if topic not in without:
            messages.setdefault(topic, []).append(TOPICS[topic].layout.pack(stamp, values))

    for tick, (wanted, is_) in enumerate(zip(reference.tolist(), truth.tolist(), strict=True)):
        stamp = tick * 10_000_000
        here = VehicleState((is_[0], is_[1], is_[2]), Euler(is_[3], 0.01, -0.02), STILL, STILL)
        send("reference", stamp, pose_values((wanted[0], wanted[1], wanted[2]), Euler(wanted[3], 0.0, 0.0)))
        send("ground_truth", stamp, odometry_values(here, [0.0] * 6, [0.0] * 6))
        send("odometry", stamp, odometry_values(here, [1e-6] * 6, [0.0] * 6))
        send("flight_state", stamp, flight_state_values(state, 160.0))
        send("rotor", stamp, (0.0, 160.0 + (3.2 if tick == 50 else 0.0), 0.0))
    return FlightRecord(Bag(Path("memory"), {}, {}, messages, {}, ()))


def step(axis: int, amplitude: float, response: Array, before: float = 3.0) -> FlightRecord:
    """A hover, then a step along one axis whose response from 0 to 1 is given."""
    start = round(before / PERIOD)
    reference = np.zeros((start + len(response), 4))
    reference[start:, axis] = amplitude
    truth = np.zeros_like(reference)
    truth[start:, axis] = amplitude * response
    return record_of(reference, truth)


def times(duration: float) -> Array:
    return np.arange(round(duration / PERIOD)) * PERIOD


@pytest.mark.parametrize(("axis", "amplitude"), [(0, 0.3), (1, -0.3), (2, 0.25), (3, radians(30.0))])
def test_first_order_response(axis: int, amplitude: float) -> None:
    constant = 0.5
    record = step(axis, amplitude, 1.0 - np.exp(-times(6.0) / constant))
    (found,) = flight_metrics(record)["steps"]
    unit, band = ("rad", radians(2.0)) if axis == 3 else ("m", 0.02)
    assert found["axis"] == ("x", "y", "z", "psi")[axis]
    assert found[f"amplitude_{unit}"] == pytest.approx(amplitude)
    assert found["rise_time_s"] == pytest.approx(constant * log(9.0), abs=1e-3)
    assert found["overshoot_percent"] == 0.0
    assert found["settling_time_s"] == pytest.approx(constant * log(abs(amplitude) / band), abs=0.011)
    assert found[f"final_error_{unit}"] == pytest.approx(0.0, abs=1e-4)
    assert found["start_s"] == pytest.approx(3.0) and found["duration_s"] == pytest.approx(6.0)
    assert found["theta_range_rad"] == pytest.approx(0.0, abs=1e-12)
    others = [found[key] for key in found if key.startswith("cross_")]
    assert len(others) == 3 and max(others) < 1e-9


def test_second_order_response() -> None:
    damping, frequency, t = 0.4, 3.0, times(6.0)
    damped = frequency * sqrt(1.0 - damping**2)
    envelope = np.exp(-damping * frequency * t)
    response = 1.0 - envelope * (np.cos(damped * t) + damping * frequency / damped * np.sin(damped * t))
    (found,) = flight_metrics(step(0, 0.3, response))["steps"]
    assert found["overshoot_percent"] == pytest.approx(
        100.0 * exp(-pi * damping / sqrt(1 - damping**2)), abs=0.02
    )
    outside = t[np.abs(response - 1.0) * 0.3 > 0.02]
    assert found["settling_time_s"] == pytest.approx(outside[-1] + PERIOD, abs=1e-6)


def test_a_response_that_never_arrives() -> None:
    (found,) = flight_metrics(step(0, 0.3, 0.5 * (1.0 - np.exp(-times(6.0)))))["steps"]
    assert found["rise_time_s"] is None and found["settling_time_s"] is None
    assert found["final_error_m"] == pytest.approx(-0.15, abs=1e-3)


def test_error_six_seconds_after_a_step_that_lasts_longer() -> None:
    t = times(8.0)
    (found,) = flight_metrics(step(1, 0.3, 1.0 - np.exp(-t)))["steps"]
    assert found["error_at_6s_m"] == pytest.approx(-0.3 * exp(-6.0), abs=1e-6)
    (short,) = flight_metrics(step(1, 0.3, 1.0 - np.exp(-times(4.0))))["steps"]
    assert short["error_at_6s_m"] is None


def test_consecutive_steps_and_the_error_at_six_seconds() -> None:
    t = times(6.0)
    reference = np.zeros((1500, 4))
    reference[300:900, 0] = 0.3
    truth = np.zeros_like(reference)
    truth[300:900, 0] = 0.3 * (1.0 - np.exp(-t))
    truth[900:, 0] = 0.3 * (1.0 - exp(-6.0)) * np.exp(-t)
    first, second = flight_metrics(record_of(reference, truth))["steps"]
    assert first["error_at_6s_m"] == pytest.approx(-0.3 * exp(-6.0), abs=1e-6)
    assert (first["amplitude_m"], second["amplitude_m"]) == (pytest.approx(0.3), pytest.approx(-0.3))


def test_motion_across_the_step() -> None:
    record = step(0, 0.3, np.ones(600))
    t = times(6.0)
    reference = np.zeros((900, 4))
    reference[300:, 0] = 0.3
    truth = reference.copy()
    truth[300:, 1] = 0.05 * np.sin(t)
    truth[300:, 3] = -0.1 * np.sin(t)
    (found,) = flight_metrics(record_of(reference, truth))["steps"]
    assert found["cross_y_max_m"] == pytest.approx(0.05, abs=1e-4)
    assert found["cross_psi_max_rad"] == pytest.approx(0.1, abs=1e-4)
    assert found["cross_z_max_m"] == 0.0
    (ideal,) = flight_metrics(record)["steps"]
    assert ideal["rise_time_s"] == 0.0 and ideal["settling_time_s"] == 0.0


def test_hover() -> None:
    t = times(12.0)
    truth = np.zeros((1200, 4))
    truth[:, 0] = 0.03 * np.sin(2.0 * pi * t)
    truth[:, 1] = 0.01
    truth[:200, 2] = 5.0  # before the hover is judged
    truth[:, 3] = radians(4.0) * np.cos(2.0 * pi * t)
    metrics = flight_metrics(record_of(np.zeros((1200, 4)), truth))
    (found,) = metrics["hover"]
    assert found["start_s"] == pytest.approx(2.0) and found["duration_s"] == pytest.approx(10.0)
    assert found["sigma_x_m"] == pytest.approx(0.03 / sqrt(2.0), rel=1e-3)
    assert found["rms_x_m"] == pytest.approx(found["sigma_x_m"], rel=1e-3)
    assert found["max_x_m"] == pytest.approx(0.03, rel=1e-3)
    assert (found["sigma_y_m"], found["rms_y_m"]) == (pytest.approx(0.0, abs=1e-12), pytest.approx(0.01))
    assert found["mean_y_m"] == pytest.approx(0.01)
    assert found["max_z_m"] == 0.0
    assert found["max_xy_m"] == pytest.approx(sqrt(0.03**2 + 0.01**2), rel=1e-3)
    assert found["sigma_psi_rad"] == pytest.approx(radians(4.0) / sqrt(2.0), rel=1e-3)
    assert found["mean_theta_rad"] == pytest.approx(0.01) and found["sigma_phi_rad"] < 1e-9


def test_ramps_and_the_stop_are_no_legs() -> None:
    down = np.concatenate((np.full(300, 0.45), np.linspace(0.45, 0.0, 300), np.zeros(400)))
    reference = np.zeros((1000, 4))
    reference[:, 2] = down
    (leg,) = reference_legs(record_of(reference, reference))
    assert leg.start_ns == 5_990_000_000 and leg.jump is None
    assert leg.duration == pytest.approx(4.01)
    with pytest.raises(ValueError, match="step"):
        step_metrics(record_of(reference, reference), leg)


def test_a_heading_step_across_the_back() -> None:
    reference = np.zeros((800, 4))
    reference[:300, 3] = radians(175.0)
    reference[300:, 3] = radians(-175.0)
    (found,) = flight_metrics(record_of(reference, reference))["steps"]
    assert found["amplitude_rad"] == pytest.approx(radians(10.0))
    assert found["overshoot_percent"] == pytest.approx(0.0, abs=1e-6)


def test_rotor_speed_and_navigation() -> None:
    still = np.zeros((300, 4))
    metrics = flight_metrics(record_of(still, still))
    assert metrics["rotor"]["max_deviation_percent"] == pytest.approx(2.0)
    assert metrics["rotor"]["reference_rad_s"] == 160.0
    assert metrics["estimation"][0]["quantity"] == "x" and metrics["estimation"][0]["rms_m"] == 0.0


def test_a_flight_that_never_flew() -> None:
    still = np.zeros((300, 4))
    metrics = flight_metrics(record_of(still, still, FlightState.HOMING))
    assert metrics["hover"] == [] and metrics["steps"] == [] and metrics["rotor"] == {}
    assert "the helicopter was never flying" in metrics["missing"]
    assert "the flight did not end in stopped but in homing" in metrics["missing"]


@pytest.mark.parametrize("topic", ["ground_truth", "reference", "flight_state", "rotor", "odometry"])
def test_a_missing_topic_is_named(topic: str) -> None:
    still = np.zeros((300, 4))
    metrics = flight_metrics(record_of(still, still, without=(topic,)))
    assert f"topic {topic} is empty" in metrics["missing"]
    json.dumps(metrics, allow_nan=False)


def test_a_whole_flight(tmp_path: Path) -> None:
    synthetic.write_flight(tmp_path / "flight")
    metrics = flight_metrics(FlightRecord.load(tmp_path / "flight"))
    assert metrics["missing"] == []
    assert metrics["flight"]["ended"] == "stopped" and metrics["flight"]["complete"]
    (hover,), (one,) = metrics["hover"], metrics["steps"]
    assert one["axis"] == "x" and one["amplitude_m"] == pytest.approx(0.1)
    assert 0.003 < hover["sigma_x_m"] < 0.05
    json.dumps(metrics, allow_nan=False)
