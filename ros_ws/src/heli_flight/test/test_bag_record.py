"""A bag as arrays: the vectorised way back to NED/FRD is the scalar one, and odd flights are no trouble."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest
import synthetic_flight as synthetic
from hypothesis import given
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.rotations import Euler, Quaternion
from heli_common.topics import TOPICS
from heli_common.vehicle_state import (
    UNKNOWN_VARIANCE,
    VehicleState,
    odometry_values,
    pose_from_values,
    state_from_odometry,
    twist_from_values,
)
from heli_common.vehicle_state import attitude_ned as scalar_attitude
from heli_flight.bag_reader import Bag
from heli_flight.flight_record import FlightRecord, attitude_ned, swap_body, swap_earth

part = st.floats(-1.0, 1.0)


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> FlightRecord:
    folder = tmp_path_factory.mktemp("record") / "flight"
    synthetic.write_flight(folder)
    return FlightRecord.load(folder)


def record_of(messages: dict[str, list[bytes]]) -> FlightRecord:
    return FlightRecord(Bag(Path("memory"), {}, {}, messages, {}, ()))


@given(st.lists(st.tuples(part, part, part, part), min_size=1, max_size=20))
def test_attitude_agrees_with_the_scalar_function(rows: list[tuple[float, float, float, float]]) -> None:
    rows = [row for row in rows if np.linalg.norm(row) > 0.1] or [(0.0, 0.0, 0.0, 1.0)]
    found = attitude_ned(np.array(rows))
    for row, angles in zip(rows, found, strict=True):
        wanted = np.array(scalar_attitude(Quaternion(*row)))
        if abs(wanted[1]) < pi / 2 - 1e-6:
            error = (angles - wanted + pi) % (2.0 * pi) - pi
            assert np.abs(error).max() < 1e-9


@pytest.mark.parametrize("theta", [pi / 2, -pi / 2])
def test_nose_straight_up_and_down_agree_with_the_scalar_function(theta: float) -> None:
    from heli_common.vehicle_state import quaternion_enu

    quaternion = quaternion_enu(Euler(0.7, theta, 0.0))
    assert attitude_ned(np.array([quaternion]))[0] == pytest.approx(scalar_attitude(quaternion), abs=1e-6)


def test_no_rotation_gives_nan() -> None:
    assert np.isnan(attitude_ned(np.zeros((2, 4)))).all()


def test_swaps_are_their_own_inverse() -> None:
    vectors = np.arange(12.0).reshape(4, 3)
    assert np.array_equal(swap_earth(swap_earth(vectors)), vectors)
    assert np.array_equal(swap_body(swap_body(vectors)), vectors)


def test_motion_agrees_with_the_scalar_function(record: FlightRecord) -> None:
    values = record.series["odometry"].values
    for index in range(0, len(values), 97):
        wanted = state_from_odometry(values[index].tolist())
        seen = record.estimate
        assert np.array_equal(seen.position[index], wanted.position)
        assert seen.attitude[index] == pytest.approx(wanted.attitude, abs=1e-12)
        assert np.array_equal(seen.velocity[index], wanted.velocity)
        assert np.array_equal(seen.rates[index], wanted.rates)
        assert seen.known[index] == wanted.known


def test_references_agree_with_the_scalar_functions(record: FlightRecord) -> None:
    stamps, pose = record.reference
    _, velocity = record.velocity_reference
    for index in range(0, len(stamps), 89):
        position, attitude = pose_from_values(record.series["reference"].values[index].tolist())
        assert pose[index, :3] == pytest.approx(position, abs=0)
        assert pose[index, 3] == pytest.approx(attitude.psi, abs=1e-12)
        row = record.series["velocity_reference"].values[index].tolist()
        linear, angular = twist_from_values(row)
        assert velocity[index] == pytest.approx((*linear, angular[2]), abs=0)


def test_other_series(record: FlightRecord) -> None:
    assert record.servo_command[1].shape == record.actuator_state[1].shape
    assert record.servo_command[1].shape[1] == 4
    assert record.rotor_speed[1].max() == pytest.approx(163.363, rel=0.02)
    assert record.rotor_reference[1].max() == 163.363
    assert record.motor_voltage[1].min() >= 0.0 and record.motor_voltage[1].max() < 10.0
    series = record.series["rotor"]
    assert np.array_equal(series.column("velocity.rotor"), record.rotor_speed[1])
    assert series.time[1] == pytest.approx(0.01)


def test_stages(record: FlightRecord) -> None:
    words = [stage.state for stage in record.stages]
    assert words == [
        FlightState.HOMING,
        FlightState.RUN_UP,
        FlightState.FLYING,
        FlightState.LANDING,
        FlightState.RUN_DOWN,
        FlightState.STOPPED,
    ]
    assert record.stages[0].duration == pytest.approx(8.0)
    assert all(a.end_ns == b.start_ns for a, b in zip(record.stages, record.stages[1:], strict=False))
    assert record.span[0] == 0.0 and record.span[1] == pytest.approx(
        record.stages[-1].end_ns * 1e-9, abs=0.02
    )


def test_unknown_pose_is_marked() -> None:
    state = VehicleState((0.0, 0.0, 0.0), Euler(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    layout = TOPICS["odometry"].layout
    values = [odometry_values(state, [v] * 6, [0.0] * 6) for v in (UNKNOWN_VARIANCE, 1e-4)]
    record = record_of({"odometry": [layout.pack(k, value) for k, value in enumerate(values)]})
    assert record.estimate.known.tolist() == [False, True]


def test_an_empty_bag_gives_empty_series() -> None:
    record = record_of({})
    assert record.stages == () and record.span == (0.0, 0.0)
    assert record.truth.position.shape == (0, 3) and record.reference[1].shape == (0, 4)
    assert record.rotor_speed[1].shape == (0,)


def test_messages_out_of_order_are_sorted() -> None:
    layout = TOPICS["rotor"].layout
    record = record_of({"rotor": [layout.pack(k, [0.0, float(k), 0.0]) for k in (3, 1, 2)]})
    assert record.rotor_speed[1].tolist() == [1.0, 2.0, 3.0]


def test_another_layout_and_another_state_are_refused() -> None:
    with pytest.raises(InputError, match="memory: rotor"):
        record_of({"rotor": [b"\0" * 10]})
    layout = TOPICS["flight_state"].layout
    with pytest.raises(InputError, match=r"memory: flight_state: .*99"):
        _ = record_of({"flight_state": [layout.pack(0, flight_state_values(99.0))]}).stages
