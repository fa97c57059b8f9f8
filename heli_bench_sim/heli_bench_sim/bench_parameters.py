"""What a bench is built from, and the constants its compiled motion needs."""

from __future__ import annotations

from dataclasses import dataclass, field

from heli_bench_sim.arm_friction import ArmFrictionParameters, arm_friction_constants
from heli_bench_sim.end_stops import EndStopParameters, end_stop_constants
from heli_bench_sim.homing_hand import HandParameters, hand_constants
from heli_bench_sim.lower_stop import StopParameters, stop_constants
from heli_bench_sim.motion import BenchConstants
from heli_bench_sim.parameters import HelicopterParameters, constants, thesis
from heli_bench_sim.servos import ServoParameters, servo_constants
from heli_common.rig_geometry import RigGeometry


@dataclass(frozen=True)
class BenchParameters:
    """Everything a bench is built from."""

    helicopter: HelicopterParameters = field(default_factory=thesis)
    geometry: RigGeometry = field(default_factory=RigGeometry)
    servo: ServoParameters = field(default_factory=ServoParameters)
    stop: StopParameters = field(default_factory=StopParameters)
    friction: ArmFrictionParameters = field(default_factory=ArmFrictionParameters)
    ends: EndStopParameters = field(default_factory=EndStopParameters)
    hand: HandParameters = field(default_factory=HandParameters)


def bench_constants(parameters: BenchParameters) -> BenchConstants:
    """Constants of the compiled bench, derived once.

    Args:
        parameters: what the bench is built from.
    """
    c = constants(parameters.helicopter)
    depth = parameters.geometry.rest_depth
    return BenchConstants(
        helicopter=c,
        servo=servo_constants(parameters.servo),
        stop=stop_constants(parameters.stop, depth, c.weight),
        friction=arm_friction_constants(parameters.friction),
        ends=end_stop_constants(parameters.ends, parameters.geometry),
        hand=hand_constants(parameters.hand, depth, c.weight),
    )
