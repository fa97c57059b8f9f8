"""Flights without a bag: the same numbers by both ways of flying, and what counts as lost."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from heli_common import topics
from heli_common.errors import InputError
from heli_common.flight_state import FlightState
from heli_flight.components import DEFAULTS
from heli_flight.flight_record import Motion
from heli_flight.noise_level import deviation, noise_level, with_noise
from heli_flight.plan import Plan, load_plan, shipped_plans
from heli_flight.unrecorded_flight import (
    FlownFlight,
    fly_excited,
    fly_for_figures,
    lost,
    messages_of,
)

GUARD = {"guard.radius": 0.5, "guard.height": 0.5, "guard.tilt": 0.35}
"""As ros_ws/config/wide_guard.yaml."""


def short_noise() -> Plan:
    """Half a second of noise on a short flight."""
    text = load_plan("noise")
    phases = list(text.phases)
    phases[3] = replace(phases[3], duration=0.5)
    excite = phases[4]
    phases[4] = replace(excite, excitation=replace(excite.excitation, duration=1.0))
    phases[5] = replace(phases[5], duration=0.5)
    return replace(text, phases=tuple(phases))


def test_both_ways_give_the_same_bits() -> None:
    plan = with_noise(short_noise(), radians(0.5), 3)
    swift = fly_excited(plan, "gst", 3)
    plain = fly_for_figures(plan, "gst", 3, DEFAULTS.changed(topics.IDENTIFICATION, GUARD))
    assert not swift.reason and not plain.reason and not lost(swift)
    assert plain.record is not None and swift.record is None
    for name in ("stamps", "position", "velocity", "rates"):
        assert np.array_equal(getattr(swift.truth, name), getattr(plain.truth, name)), name
    assert np.allclose(swift.truth.attitude, plain.truth.attitude, rtol=0.0, atol=1e-12)  # by quaternions
    for name in ("command", "actuators", "fan", "state", "excitation"):
        assert np.array_equal(getattr(swift, name), getattr(plain, name)), name
    assert swift.stages == plain.stages
    acting = swift.excitation[:, 0][np.flatnonzero(swift.excitation[:, 0])]
    assert len(acting) == 100 and np.std(acting) == pytest.approx(radians(0.5), rel=1e-9)
    with pytest.raises(ValueError, match="without messages"):
        messages_of(swift)


def test_what_an_excited_flight_refuses() -> None:
    with pytest.raises(InputError, match="excites u"):
        fly_excited(load_plan("velocity_steps"), "lq", 1)
    with pytest.raises(InputError, match="no plan for noise"):
        with_noise(load_plan("hover"), 0.01, 1)


def test_noise_plans_have_a_deviation_of_one_degree() -> None:
    for name in ("noise", "noise_5_hz"):
        (excitation,) = load_plan(name).excitations
        assert deviation(excitation) == pytest.approx(radians(1.0), rel=5e-3), name
        stronger = with_noise(load_plan(name), radians(2.0), 7).excitations[0]
        assert deviation(stronger) == pytest.approx(radians(2.0), rel=1e-9)
        assert stronger.seed == 7


def test_level_by_bisection() -> None:
    found = noise_level(lambda sigma: "tilt" if sigma > 1.234 else "", highest=3.0, resolution=0.1)
    assert found.borne <= 1.234 < (found.lost or 0.0) and found.reason == "tilt"
    assert found.level == pytest.approx(1.234, abs=0.05)
    assert noise_level(lambda _: "", highest=3.0).lost is None


def flight_of(position: tuple[float, float, float], reason: str = "") -> FlownFlight:
    """Two ticks of flying at a place, the reference at the centre."""
    stamps = np.array([0, 10_000_000], dtype=np.int64)
    zeros = np.zeros((2, 3))
    motion = Motion(stamps, np.array([position] * 2), zeros, zeros, zeros, np.ones(2, dtype=bool))
    four = np.zeros((2, 4))
    state = np.full(2, int(FlightState.FLYING))
    return FlownFlight(motion, (stamps, four), four, four, np.zeros(2), state, reason, four)


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ((0.0, 0.0, 0.0), ""),
        ((0.0, 0.0, 0.449), "lower stop"),
        ((0.0, 0.0, -0.349), "upper stop"),
        ((0.3, 0.4, 0.0), "side"),
    ],
)
def test_what_counts_as_lost(place: tuple[float, float, float], said: str) -> None:
    assert said in lost(flight_of(place)) and bool(said) == bool(lost(flight_of(place)))
    assert lost(flight_of(place, "tilt")) == "tilt"


def test_every_experiment_has_its_plan() -> None:
    for name in ("hover_steps", "hover", "wind_front", "noise", "noise_5_hz", "identification",
                 "velocity_steps", "wireless_link"):  # fmt: skip
        assert name in shipped_plans()
        assert load_plan(name).duration > 20.0
