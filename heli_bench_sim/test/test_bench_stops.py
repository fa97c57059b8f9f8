"""Lower stop, skids, end stops: forces by hand, one-sidedness, no energy from nowhere."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_bench_sim.end_stops import EndStopParameters, end_stop_constants, gimbal_torque, platform_force
from heli_bench_sim.lower_stop import (
    StopParameters,
    bristle_rate,
    friction_force,
    friction_moment,
    normal_force,
    one_sided,
    stop_constants,
    tilt_moment,
)
from heli_common.rig_geometry import RigGeometry

GEOMETRY = RigGeometry()
WEIGHT = 7.3 * 9.81
S = stop_constants(StopParameters(), GEOMETRY.rest_depth, WEIGHT)
E = end_stop_constants(EndStopParameters(), GEOMETRY)


def test_weight_rests_at_the_rest_depth() -> None:
    assert GEOMETRY.rest_depth == pytest.approx(0.45)
    assert normal_force(0.45, 0.0, S) == pytest.approx(WEIGHT, rel=1e-9)
    assert normal_force(S.surface, 5.0, S) == 0.0


@settings(deadline=None, max_examples=50)
@given(st.floats(-0.1, 0.1), st.floats(-3.0, 3.0))
def test_stop_never_pulls(depth: float, speed: float) -> None:
    force = one_sided(depth, speed, 1e4, 5.0)
    assert force >= 0.0
    if depth <= 0.0:
        assert force == 0.0


def test_bounce_loses_energy() -> None:
    """A mass dropped on the stop leaves it more slowly than it came."""
    depth, speed, step = 0.0, 1.0, 1e-6
    while depth >= 0.0:
        speed -= step * one_sided(depth, speed, S.stiffness, S.damping) / 7.3
        depth += step * speed
    assert -0.5 < speed < 0.0


def test_tilt_moment_by_hand_and_its_bound() -> None:
    assert tilt_moment(0.0, 0.0, WEIGHT, S) == 0.0
    assert tilt_moment(0.02, 0.0, WEIGHT, S) == pytest.approx(-WEIGHT * 0.15 / math.sqrt(2.0), rel=1e-12)
    assert abs(tilt_moment(1.0, 0.0, WEIGHT, S)) < WEIGHT * 0.15
    assert tilt_moment(0.0, 1.0, WEIGHT, S) < 0.0
    assert tilt_moment(0.1, 1.0, 0.0, S) == 0.0


def test_friction_by_hand() -> None:
    """Fully bent, a bristle carries mu N; the yaw friction mu N times its lever."""
    assert friction_force(0.005, 0.0, WEIGHT, S) == pytest.approx(-0.8 * WEIGHT)
    assert friction_moment(-0.04, 0.0, WEIGHT, S) == pytest.approx(0.8 * WEIGHT * 0.25)
    assert 0.8 * WEIGHT * 0.25 > 7.2  # more than the drive can turn with at 60 A


def slide(velocity: float, duration: float, normal: float, bend: float = 0.0) -> float:
    step = 1e-5
    for _ in range(round(duration / step)):
        bend += step * bristle_rate(bend, velocity, abs(velocity), S.slip_distance, normal, S)
    return bend


def test_skid_slips_at_the_coulomb_force() -> None:
    assert slide(0.1, 1.0, WEIGHT) == pytest.approx(0.005, rel=1e-6)
    assert slide(-0.1, 1.0, WEIGHT) == pytest.approx(-0.005, rel=1e-6)


def test_skid_at_rest_does_not_creep_but_a_lifted_one_lets_go() -> None:
    assert slide(0.0, 1.0, 0.5 * WEIGHT, 0.003) == 0.003
    assert slide(0.0, 0.05, 0.0, 0.003) == pytest.approx(0.003 / math.e, rel=1e-3)


def test_gimbal_stops() -> None:
    limit = 25.0 * math.pi / 180.0
    assert gimbal_torque(0.99 * limit, 1.0, E.tilt_limit, E) == 0.0
    assert gimbal_torque(limit + 0.02, 0.0, E.tilt_limit, E) == pytest.approx(-400.0 * 0.02)
    assert gimbal_torque(-limit - 0.02, 0.0, E.tilt_limit, E) == pytest.approx(400.0 * 0.02)
    assert gimbal_torque(limit + 0.02, 1.0, E.tilt_limit, E) < -400.0 * 0.02
    assert math.degrees(E.yaw_limit) == pytest.approx(170.0)


def test_cylinder_pushes_inwards_and_down() -> None:
    assert platform_force(0.3, 0.3, 0.0, 9.0, 9.0, -9.0, E) == (0.0, 0.0, 0.0)
    assert platform_force(0.0, 0.51, 0.0, 0.0, 0.0, 0.0, E) == pytest.approx((0.0, -80.0, 0.0))
    assert platform_force(-0.51, 0.0, 0.0, 0.0, 0.0, 0.0, E) == pytest.approx((80.0, 0.0, 0.0))
    assert platform_force(0.0, 0.0, -0.36, 0.0, 0.0, 0.0, E) == pytest.approx((0.0, 0.0, 80.0))
    assert platform_force(0.0, 0.51, 0.0, 0.0, 1.0, 0.0, E)[1] < -80.0
