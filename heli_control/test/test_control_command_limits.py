from __future__ import annotations

import math
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_control.command_limits import CommandLimits

DEG = math.pi / 180.0
LOWEST = (-10.0 * DEG, -10.0 * DEG, -4.0 * DEG, -5.0 * DEG)
HIGHEST = (10.0 * DEG, 10.0 * DEG, 16.0 * DEG, 25.0 * DEG)
LIMITS = CommandLimits(LOWEST, HIGHEST, 6.0 * DEG, 60.0 / 6.0 * DEG)


def within(*degrees: float) -> list[float]:
    return [value / DEG for value in LIMITS.within([value * DEG for value in degrees])]


@pytest.mark.parametrize(
    ("asked", "kept"),
    [
        ((10.0, 0.0, 6.0, 10.0), (10.0, 0.0, 6.0, 10.0)),  # the nose servo at its end, exactly
        ((10.0, 0.0, 9.0, 10.0), (7.0, 0.0, 9.0, 10.0)),  # 60 deg of shaft less 18 deg of collective
        ((-10.0, 0.0, 9.0, 10.0), (-10.0, 0.0, 9.0, 10.0)),  # nose servo at -42 deg, the others at 48 deg
        ((-10.0, 0.0, 13.0, 10.0), (-6.0, 0.0, 13.0, 10.0)),  # the other two have 18 deg left: 3 deg each
        ((3.0, -4.0, 16.0, 10.0), (0.0, 0.0, 16.0, 10.0)),  # all travel is the collective's
        ((0.0, 10.0, 16.0 - 5.0 * math.sqrt(3.0), 0.0), (0.0, 10.0, 16.0 - 5.0 * math.sqrt(3.0), 0.0)),
        ((20.0, 0.0, 6.0, 30.0), (10.0, 0.0, 6.0, 25.0)),
        ((0.0, 0.0, 20.0, -9.0), (0.0, 0.0, 16.0, -5.0)),
        ((0.0, 0.0, -9.0, 0.0), (0.0, 0.0, -4.0, 0.0)),
    ],
)
def test_by_hand(asked: tuple[float, ...], kept: tuple[float, ...]) -> None:
    assert within(*asked) == pytest.approx(kept, abs=1e-12)


def test_the_cyclic_keeps_its_direction() -> None:
    # servo at 240 deg: -5 - 8.66 of 10 deg
    back, right, _, _ = within(10.0, 10.0, 6.0, 0.0)
    assert back == pytest.approx(10.0 / (0.5 + 0.5 * math.sqrt(3.0)))
    assert right == pytest.approx(back)


@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4))
def test_what_is_kept_is_reached_and_is_kept_again(asked: list[float]) -> None:
    kept = LIMITS.within(asked)
    azimuth = np.radians([0.0, 120.0, 240.0])
    shafts = 6.0 * (kept[2] - 6.0 * DEG + kept[0] * np.cos(azimuth) + kept[1] * np.sin(azimuth))
    assert np.abs(shafts).max() <= radians(60.0) + 1e-9
    assert LIMITS.within(kept) == pytest.approx(kept, abs=1e-12)
    assert all(low <= x <= high for low, x, high in zip(LOWEST, kept, HIGHEST, strict=True))


def test_a_command_out_of_reach_is_refused_by_name() -> None:
    LIMITS.require((0.0, 0.0, 0.1, 0.1), "lq: operating_point")
    with pytest.raises(InputError, match=r"^lq: operating_point\.theta_t: 0\.6 \(allowed: -0\.08727 \.\. 0"):
        LIMITS.require((0.0, 0.0, 0.1, 0.6), "lq: operating_point")
    with pytest.raises(InputError, match=r"operating_point\.B_1s: 0\.17 \(allowed: 0\.1222 rad beside"):
        LIMITS.require((0.17, 0.0, 9.0 * DEG, 0.1), "lq: operating_point")
