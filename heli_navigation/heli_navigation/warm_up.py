"""Loads the compiled kernels before time runs: a navigator of its own sees a helicopter at the centre."""

from __future__ import annotations

from heli_common.rig_geometry import RigGeometry
from heli_common.timing import CONTROL_PERIOD_NS, SENSOR_PERIOD_NS
from heli_common.vehicle_state import imu_values
from heli_navigation.arm_kinematics import arms_from_position
from heli_navigation.navigator import NavigationParameters, Navigator


def warm_up() -> None:
    """Compile or load everything that a navigator calls in flight, with and without IMU."""
    geometry = RigGeometry()
    navigator = Navigator(NavigationParameters(), geometry)
    counted = (*arms_from_position((0.0, 0.0, 0.0), geometry), *(0.0,) * 9, *(1.0,) * 6)
    for stamp_ns in range(0, 4 * CONTROL_PERIOD_NS, SENSOR_PERIOD_NS):
        valid = stamp_ns < 2 * CONTROL_PERIOD_NS
        felt = imu_values((0.0, 0.0, 0.0), (0.0, 0.0, -9.81), (1e-5, 1e-3), valid)
        navigator.receive("encoders", stamp_ns, counted)
        navigator.receive("imu", stamp_ns, felt)
