"""What a bench is built from, and the constants its compiled motion needs."""

from __future__ import annotations

from dataclasses import dataclass, field

from heli_bench_sim.arm_friction import ArmFrictionParameters, arm_friction_constants
from heli_bench_sim.arm_inertia import ArmInertiaParameters, arm_inertia_constants
from heli_bench_sim.delta_arm import arm_constants
from heli_bench_sim.end_stops import EndStopParameters, end_stop_constants
from heli_bench_sim.h_force import HForceParameters
from heli_bench_sim.hall_sensor import HallParameters, hall_constants
from heli_bench_sim.homing_hand import HandParameters, hand_constants
from heli_bench_sim.imu_parameters import ImuParameters, imu_constants
from heli_bench_sim.levers import LeverParameters
from heli_bench_sim.link import LinkParameters
from heli_bench_sim.lower_stop import StopParameters, stop_constants
from heli_bench_sim.motion import BenchConstants
from heli_bench_sim.parameters import HelicopterParameters, constants, thesis
from heli_bench_sim.room_air import RoomAirParameters, room_constants
from heli_bench_sim.servos import ServoParameters, servo_constants
from heli_bench_sim.wind_generator import WindParameters, wind_constants
from heli_common.records import packed
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
    arms: ArmInertiaParameters = field(default_factory=ArmInertiaParameters)
    wind: WindParameters = field(default_factory=WindParameters)
    room: RoomAirParameters = field(default_factory=RoomAirParameters)
    imu: ImuParameters = field(default_factory=ImuParameters)
    hall: HallParameters = field(default_factory=HallParameters)
    link: LinkParameters = field(default_factory=LinkParameters)
    levers: LeverParameters = field(default_factory=LeverParameters)
    h_force: HForceParameters = field(default_factory=HForceParameters)


def bench_constants(parameters: BenchParameters) -> BenchConstants:
    """Constants of the compiled bench, derived once.

    Args:
        parameters: what the bench is built from.
    """
    c = constants(parameters.helicopter, parameters.levers, parameters.h_force)
    depth = parameters.geometry.rest_depth
    return packed(
        BenchConstants(
            helicopter=c,
            servo=servo_constants(parameters.servo),
            stop=stop_constants(parameters.stop, depth, c.weight),
            friction=arm_friction_constants(parameters.friction),
            ends=end_stop_constants(parameters.ends, parameters.geometry),
            hand=hand_constants(parameters.hand, depth, c.weight),
            arm=arm_constants(parameters.geometry),
            inertia=arm_inertia_constants(parameters.arms),
            jet=wind_constants(parameters.wind),
            room=room_constants(parameters.room, c.hover_inflow),
            imu=imu_constants(
                parameters.imu, parameters.helicopter.gravity, parameters.helicopter.rotor_speed
            ),
            hall=hall_constants(parameters.hall, parameters.helicopter.motor_gear),
        )
    )
