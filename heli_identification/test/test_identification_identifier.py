"""The identification as a component: when it excites, what it sends, when it stops, what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.component import Message
from heli_common.errors import InputError
from heli_common.flight_state import FlightState, flight_state_values
from heli_common.rotations import Euler
from heli_common.timing import CONTROL_PERIOD_NS
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_common.vehicle_state import (
    UNKNOWN_VARIANCE,
    VehicleState,
    odometry_values,
    pose_values,
    twist_from_values,
)
from heli_identification.excitation import CHANNELS, samples
from heli_identification.excitation_words import excitation_from_text
from heli_identification.identifier import Identifier

BOTH = "{signal: noise, channels: [B_1s, A_1s], amplitude_deg: 1, band_rad_s: [1, 15], duration: 5, fade: 0}"
REFERENCE = "{signal: doublets, channel: r, amplitude_deg_s: 10, hold: 0.5, duration: 4, fade: 0}"
PLAN = (excitation_from_text(BOTH), excitation_from_text(REFERENCE))
SERVO = (0.01, 0.02, 0.1, 0.2, *(0.0,) * 8)


class Flight:
    """Feeds an identifier tick by tick."""

    def __init__(self, identifier: Identifier) -> None:
        self.identifier = identifier
        self.tick = 0

    def step(
        self,
        number: int = 0,
        stage: FlightState = FlightState.FLYING,
        position: tuple[float, float, float] = (0.0, 0.0, 0.0),
        phi: float = 0.0,
        known: bool = True,
        order: tuple[int, ...] = (0, 1, 2),
    ) -> tuple[np.ndarray, np.ndarray, list[Message], float]:
        """Commands (4,), references (4,), what the servo command caused, and volts, at the next tick."""
        stamp = self.tick * CONTROL_PERIOD_NS
        self.tick += 1
        variance = (1e-6 if known else UNKNOWN_VARIANCE,) * 6
        state = VehicleState(position, Euler(0.0, 0.0, phi), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        said = [
            ("odometry", odometry_values(state, variance, variance)),
            ("reference", pose_values((0.0, 0.0, 0.0), Euler(0.0, 0.0, 0.0))),
            ("flight_state", flight_state_values(stage, 163.0, excitation=number)),
        ]
        sent: list[Message] = []
        for place in order:
            topic, values = said[place]
            sent += self.identifier.receive(topic, stamp, values)
        assert [(m.topic, m.stamp_ns) for m in sent] == [
            ("excitation", stamp),
            ("reference_excitation", stamp),
            ("motor_excitation", stamp),
        ]
        assert all(len(m.values) == len(TOPICS[m.topic].layout.fields) for m in sent)
        linear, angular = twist_from_values(sent[1].values)
        after = self.identifier.receive("servo_command", stamp, SERVO)
        return np.array(sent[0].values[:4]), np.array([*linear, angular[2]]), after, float(sent[2].values[2])


def test_the_plans_excitations_go_out_sample_by_sample_when_they_are_flown() -> None:
    flight = Flight(Identifier(PLAN))
    assert not flight.step()[0].any()
    commands = np.array([flight.step(1)[0] for _ in range(500)])
    assert np.array_equal(commands, samples(PLAN[0])[:, :4])
    quiet, *_ = flight.step(1)
    assert not quiet.any()
    assert not flight.step(0)[0].any()
    references = np.array([flight.step(2)[1] for _ in range(400)])
    assert np.array_equal(references[:, 3], samples(PLAN[1])[:, CHANNELS.index("r")])
    assert not references[:, :3].any()


def test_the_control_voltage_can_be_excited() -> None:
    chirp = "{signal: chirp, channel: motor, amplitude_V: 0.05, band_rad_s: [0.5, 30], duration: 5}"
    flight = Flight(Identifier((excitation_from_text(chirp),)))
    sent = [flight.step(1)[3] for _ in range(500)]
    assert sent == samples(excitation_from_text(chirp))[:, CHANNELS.index("motor")].tolist()
    assert 0.045 < max(sent) <= 0.05


@settings(max_examples=20, deadline=None)
@given(st.lists(st.permutations((0, 1, 2)), min_size=20, max_size=20))
def test_the_order_of_arrival_changes_nothing(orders: list[tuple[int, ...]]) -> None:
    flight = Flight(Identifier(PLAN))
    commands = np.array([flight.step(1, order=tuple(order))[0] for order in orders])
    assert np.array_equal(commands, samples(PLAN[0])[:20, :4])


@pytest.mark.parametrize(
    ("trouble", "said"),
    [
        ({"stage": FlightState.LANDING}, "not flying (landing)"),
        ({"stage": FlightState.FAULT}, "not flying (fault)"),
        ({"known": False}, "position not known"),
        ({"position": (0.2, -0.2, 0.0)}, "0.28 m beside the reference (limit 0.25 m)"),
        ({"position": (0.0, 0.0, 0.21)}, "0.21 m above or below the reference (limit 0.2 m)"),
        ({"phi": math.radians(-13.0)}, "roll or pitch of 13.0 deg (limit 12.0 deg)"),
    ],
)
def test_it_stops_within_a_tenth_of_a_second_and_for_good(trouble: dict[str, object], said: str) -> None:
    flight = Flight(Identifier(PLAN))
    for _ in range(100):
        flight.step(1)
    table = samples(PLAN[0])[:, :4]
    falling = [flight.step(1, **trouble)[0] for _ in range(12)]  # type: ignore[arg-type]
    for n, row in enumerate(falling):
        share = max(0.0, 1.0 - 0.1 * (n + 1))
        assert np.allclose(row, share * table[100 + n], atol=1e-12)
    assert flight.identifier.remarks[-1] == ("warn", f"excitation stopped: {said}")
    assert len(flight.identifier.remarks) == 2
    assert not any(flight.step(1)[0].any() for _ in range(50))
    assert flight.step(2)[1].any()


def test_a_request_acts_at_the_next_tick() -> None:
    flight = Flight(Identifier())
    flight.step()
    flight.identifier.request(REFERENCE)
    with pytest.raises(InputError, match=r"^excite: an excitation acts already"):
        flight.identifier.request(BOTH)
    assert np.isclose(flight.step()[1][3], math.radians(10.0))
    assert flight.identifier.remarks == [("ok", "doublets on r begins")]
    with pytest.raises(InputError, match=r"^excite: an excitation acts already"):
        flight.identifier.request(BOTH)
    flight.identifier.request("")
    assert np.isclose(flight.step()[1][3], 0.9 * math.radians(10.0))
    for _ in range(10):
        flight.step()
    flight.identifier.request(BOTH)
    assert np.array_equal(flight.step()[0], samples(PLAN[0])[0, :4])


@pytest.mark.parametrize("stage", [s for s in FlightState if s is not FlightState.FLYING])
def test_a_request_on_the_ground_is_refused_with_the_reason(stage: FlightState) -> None:
    flight = Flight(Identifier())
    flight.step(stage=stage)
    with pytest.raises(
        InputError, match=rf"^excite: not possible while {stage.word} \(allowed: while flying\)"
    ):
        flight.identifier.request(BOTH)
    with pytest.raises(InputError, match=r"^excite.signal: 'hum' is no signal"):
        flight.identifier.request("{signal: hum}")


def test_a_request_waits_for_the_plan() -> None:
    flight = Flight(Identifier(PLAN))
    flight.step(1)
    with pytest.raises(InputError, match="an excitation acts already"):
        flight.identifier.request(REFERENCE)


def test_the_estimate_comes_ten_times_a_second() -> None:
    flight = Flight(Identifier(PLAN))
    sent = [message for _ in range(101) for message in flight.step(1)[2]]
    assert [m.stamp_ns for m in sent] == list(range(0, 1_000_000_001, TOPICS["estimate"].period_ns))
    assert all(len(m.values) == len(TOPICS["estimate"].layout.fields) for m in sent)


def test_numbers_that_are_not_finite_and_unknown_excitations_are_refused() -> None:
    with pytest.raises(ValueError, match=r"servo_command: position.B_1s is nan"):
        Identifier().receive("servo_command", 0, (math.nan, *SERVO[1:]))
    with pytest.raises(ValueError, match="excitation 3 is flown, but 2 are known"):
        Flight(Identifier(PLAN)).step(3)
    assert set(Identifier.inputs + Identifier.outputs) <= set(DATA_TOPICS)
