"""The picture of the rig: true lengths, right places."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_bench_sim.parameters import thesis
from heli_bench_sim.rig_picture import GIMBAL_HALF_LENGTH, NOSE, WIND_SECONDS, draw, elbows
from heli_common.rig_geometry import RigGeometry
from heli_common.rotations import Euler, matrix_from_euler, rotate
from heli_common.vehicle_state import attitude_ned, swap_earth

RIG, HELICOPTER = RigGeometry(), thesis()
LEVEL = Euler(0.0, 0.0, 0.0)
STILL = (0.0, 0.0, 0.0)

offsets = st.floats(-0.3, 0.3)
angles = st.floats(-0.6, 0.6)


def parts(position=STILL, attitude=LEVEL, wind=STILL):
    picture = draw(position, attitude, wind, RIG, HELICOPTER)
    return picture, dict(picture.lines), {disc.part: disc for disc in picture.discs}


def lengths(lines):
    return [math.dist(*line) for line in lines]


@settings(deadline=None)  # the first one loads a kernel
@given(offsets, offsets, offsets)
def test_arms_have_their_true_lengths_everywhere(x, y, z):
    _, lines, _ = parts((x, y, z))
    assert lengths(lines["upper_arms"]) == pytest.approx([0.75] * 3, abs=1e-12)
    assert lengths(lines["forearms"]) == pytest.approx([0.90] * 6, abs=1e-12)
    assert lengths(lines["base"]) == pytest.approx([0.30 * math.sqrt(3.0)] * 3)
    assert lengths(lines["platform"]) == pytest.approx([0.06 * math.sqrt(3.0)] * 3)


def test_in_the_centre_the_arms_are_alike_and_the_base_is_on_the_floor():
    _, lines, _ = parts()
    found = elbows(STILL, RIG)
    assert found[:, 2] == pytest.approx(found[0, 2])
    assert np.hypot(found[:, 0], found[:, 1]) == pytest.approx(np.hypot(*found[0, :2]))
    assert found[0, 0] > RIG.base_radius and found[0, 1] == pytest.approx(0.0), (
        "first arm north, elbow outside"
    )
    assert {round(end[2], 12) for line in lines["base"] for end in line} == {-0.90}
    # the first pivot is 0.30 m north: in ENU that is y
    assert any(end == pytest.approx((0.0, 0.30, -0.90)) for line in lines["base"] for end in line)


def test_level_helicopter_in_the_centre_by_hand():
    _, lines, discs = parts()
    nose, tail = lines["helicopter"][0][0], lines["helicopter"][1][1]
    assert nose == pytest.approx((0.0, NOSE, 0.0))
    assert tail == pytest.approx((0.0, -0.8612, 0.0210))
    assert discs["rotor_disc"].centre == pytest.approx((0.0, -0.0133, 0.20))
    assert discs["rotor_disc"].diameter == pytest.approx(1.45)
    assert discs["tail_rotor_disc"].diameter == pytest.approx(0.30)


@settings(deadline=None)
@given(angles, angles, angles)
def test_discs_are_normal_to_their_shafts(psi, theta, phi):
    attitude = Euler(psi, theta, phi)
    _, _, discs = parts(attitude=attitude)
    body = matrix_from_euler(attitude)
    assert tuple(attitude_ned(discs["rotor_disc"].attitude)) == pytest.approx(attitude, abs=1e-9)
    x, y, z, w = discs["tail_rotor_disc"].attitude
    normal = (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y))
    left = swap_earth(rotate(body, (0.0, -1.0, 0.0)))
    assert abs(np.dot(normal, left)) == pytest.approx(1.0)


def test_gimbal_axes_follow_the_rotations_before_them():
    _, lines, _ = parts(attitude=Euler(math.pi / 2.0, 0.3, 0.5))
    yaw, pitch, roll = (
        np.subtract(line[1], line[0]) / (2.0 * GIMBAL_HALF_LENGTH) for line in lines["gimbal"]
    )
    assert yaw == pytest.approx((0.0, 0.0, -1.0))
    assert pitch == pytest.approx((0.0, -1.0, 0.0)), "nose to the east: the pitch axis points south"
    assert roll == pytest.approx((math.cos(0.3), 0.0, math.sin(0.3)))


def test_wind_blows_from_tail_to_tip():
    picture, _, _ = parts(wind=(0.0, 2.0, 0.0))
    assert np.subtract(picture.wind[1], picture.wind[0]) == pytest.approx((2.0 * WIND_SECONDS, 0.0, 0.0))
    still, _, _ = parts()
    assert still.wind[0] == still.wind[1]


def test_out_of_reach_is_refused():
    with pytest.raises(ValueError, match="out of the arms' reach"):
        draw((3.0, 0.0, 0.0), LEVEL, STILL, RIG, HELICOPTER)
