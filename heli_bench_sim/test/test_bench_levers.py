"""Levers of the rotor head: off is exactly off, by hand, Table 2.1's range, the smooth dead zone."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_bench_sim.levers import (
    LeverConstants,
    LeverParameters,
    after_slack,
    cyclic_after_slack,
    lever_constants,
    lever_gains,
)
from heli_bench_sim.parameters import PARAMETER_SETS, thesis
from heli_bench_sim.trim import trim
from heli_common.compiled import compiled
from heli_common.quantities import about
from heli_common.records import packed

H = thesis()
OFF = lever_constants(LeverParameters(), H)
LOWEST, HIGHEST = math.radians(-4.0), math.radians(16.0)
MEASURED = {
    "bar_to_blade": (0.5, 0.8, 0.86),
    "plate_to_blade": (0.3, 0.7, 1.15),
    "plate_to_bar": (0.9, 1.5, 1.72),
}
"""Source Table 2.1, and the slopes named in the module."""
ANGLE = st.floats(-0.3, 0.3)
SLACK = st.floats(1e-6, 0.05)


@compiled
def gains_in_compiled_code(theta_0: float, k: LeverConstants) -> tuple[float, float, float]:
    return lever_gains(theta_0, k)


@settings(deadline=None)
@given(st.floats(-1.0, 1.0))
def test_off_is_the_constant_gains_bit_by_bit(theta_0: float) -> None:
    assert lever_gains(theta_0, OFF) == (H.bar_to_blade, H.plate_to_blade, H.plate_to_bar)


@settings(deadline=None)
@given(ANGLE, ANGLE)
def test_off_is_no_slack_bit_by_bit(back: float, right: float) -> None:
    assert after_slack(back, 0.0) == back
    assert cyclic_after_slack(back, right, 0.0) == (back, right)


def test_gains_by_hand_and_through_a_record() -> None:
    """0.1 rad above hover with slopes 0.5, -1, 2 1/rad: +0.05, -0.1, +0.2."""
    slopes = LeverParameters(
        gain_slope_bar_to_blade=0.5, gain_slope_plate_to_blade=-1.0, gain_slope_plate_to_bar=2.0
    )
    k = lever_constants(slopes, H)
    theta_0 = slopes.gain_collective + 0.1
    expected = (0.5469 + 0.05, 0.3431 - 0.1, 1.4199 + 0.2)
    assert lever_gains(theta_0, k) == pytest.approx(expected, rel=1e-12)
    assert gains_in_compiled_code(theta_0, packed(k)) == lever_gains(theta_0, k)


def test_gains_are_the_models_own_at_hover() -> None:
    """So the trim does not move when the gains begin to depend on collective."""
    assert LeverParameters().gain_collective == pytest.approx(trim(H).theta_0, abs=math.radians(5e-4))


def test_named_slopes_span_the_measured_range() -> None:
    for low, high, slope in MEASURED.values():
        assert slope * (HIGHEST - LOWEST) == pytest.approx(high - low, rel=0.01)
    texts = {field.name: about(field).text for field in dataclasses.fields(LeverParameters)}
    for name, (_, _, slope) in MEASURED.items():
        assert f"{slope} spans" in texts[f"gain_slope_{name}"]


@pytest.mark.parametrize("name", PARAMETER_SETS)
def test_no_allowed_slope_turns_a_gain_around(name: str) -> None:
    """Over the servos' whole collective every gain stays positive."""
    ends = [
        (about(field).minimum, about(field).maximum)
        for field in dataclasses.fields(LeverParameters)
        if field.name.startswith("gain_slope")
    ]
    assert len(ends) == 3
    for which in (0, 1):
        k = lever_constants(LeverParameters(*(pair[which] for pair in ends)), PARAMETER_SETS[name]())
        for theta_0 in (LOWEST, HIGHEST):
            assert min(lever_gains(theta_0, k)) > 0.0


def test_slack_by_hand() -> None:
    """A 3-4-5 triangle: of 4 mrad with 3 mrad of play gets through 1 - 3/5, so 1.6 mrad."""
    assert after_slack(4e-3, 3e-3) == pytest.approx(1.6e-3, rel=1e-12)
    # and of a swing with sides 2 and 3.4641 (size 4) each side the same share
    back, right = cyclic_after_slack(2e-3, -math.sqrt(12.0) * 1e-3, 3e-3)
    assert (back, right) == pytest.approx((0.8e-3, -0.4 * math.sqrt(12.0) * 1e-3), rel=1e-12)


@settings(deadline=None)
@given(ANGLE, SLACK)
def test_dead_zone(angle: float, slack: float) -> None:
    """Odd, never more than the angle, never less than a hard dead zone, near it for large angles."""
    through = after_slack(angle, slack)
    assert after_slack(-angle, slack) == -through
    lost = abs(angle) - abs(through)
    assert 0.0 <= lost <= min(slack, abs(angle)) + 1e-15
    if abs(angle) > 10.0 * slack:
        assert lost > 0.995 * slack


@settings(deadline=None)
@given(ANGLE, SLACK)
def test_dead_zone_is_smooth_and_rises(angle: float, slack: float) -> None:
    """Slope against its closed form, 1 - h^3 / (x^2 + h^2)^(3/2): from 0 at zero to 1."""
    slope = 1.0 - slack**3 / (angle * angle + slack * slack) ** 1.5
    assert -1e-15 <= slope <= 1.0
    step = 1e-4 * slack
    numeric = (after_slack(angle + step, slack) - after_slack(angle - step, slack)) / (2.0 * step)
    # cancellation: |angle| eps / step
    assert numeric == pytest.approx(slope, abs=1e-6 + 1e-11 * abs(angle) / slack)


@settings(deadline=None)
@given(st.floats(0.0, 0.3), st.floats(-math.pi, math.pi), SLACK)
def test_cyclic_keeps_its_direction_whatever_it_is(size: float, bearing: float, slack: float) -> None:
    back, right = cyclic_after_slack(size * math.cos(bearing), size * math.sin(bearing), slack)
    assert math.hypot(back, right) == pytest.approx(after_slack(size, slack), rel=1e-9, abs=1e-15)
    assert back * math.sin(bearing) - right * math.cos(bearing) == pytest.approx(0.0, abs=1e-15)


def test_cyclic_is_the_first_harmonic_of_a_dead_zone_to_first_order() -> None:
    """Numerical twin: a hard dead zone on the blade's swing loses 4 h / pi of its first harmonic.

    The smooth one loses h, the same size: the model is one of size, not of shape.
    """
    turn = np.linspace(0.0, 2.0 * math.pi, 20000, endpoint=False)
    size, slack = 0.1, 1e-3
    pitch = size * np.cos(turn - 0.7)
    passed = np.sign(pitch) * np.maximum(np.abs(pitch) - slack, 0.0)
    back, right = 2.0 * float(np.mean(passed * np.cos(turn))), 2.0 * float(np.mean(passed * np.sin(turn)))
    assert size - math.hypot(back, right) == pytest.approx(4.0 / math.pi * slack, rel=1e-3)
    assert math.atan2(right, back) == pytest.approx(0.7, abs=1e-6)
    smooth = cyclic_after_slack(size * math.cos(0.7), size * math.sin(0.7), slack)
    assert size - math.hypot(*smooth) == pytest.approx(slack, rel=1e-2)
    assert math.atan2(smooth[1], smooth[0]) == pytest.approx(math.atan2(right, back), abs=1e-6)
