"""The components of a flight, built from an order as the nodes build them from their parameters."""

from __future__ import annotations

from dataclasses import replace

from heli_bench_sim.bench import Bench
from heli_bench_sim.bench_parameters import BenchParameters
from heli_bench_sim.faults import FaultSchedule
from heli_bench_sim.simulator import BenchSimulator
from heli_common import topics
from heli_common.component import Component
from heli_common.rig_geometry import RigGeometry
from heli_control.attitude_control import AttitudeController, AttitudeParameters
from heli_control.controller_file import ControllerFile
from heli_control.motor_control import MotorController, MotorParameters
from heli_control.position_control import PositionController, PositionParameters
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import GUSTY, Plan
from heli_flight.stages import FlightLimits
from heli_flight.supervisor import Supervisor
from heli_identification.excitation_guard import GuardParameters
from heli_identification.identifier import Identifier
from heli_identification.running_estimate import EstimateParameters
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.imu_attitude_parameters import ImuAttitudeParameters
from heli_navigation.navigator import NavigationParameters, Navigator

DEFAULTS = NodeValues()


def bench_simulator(
    seed: int, values: NodeValues = DEFAULTS, plan: Plan | None = None, identified: bool = False
) -> BenchSimulator:
    """The simulated bench, in the room and with the faults of a plan, with or without an identification."""
    parameters = values.build_groups(topics.BENCH_SIM, BenchParameters)
    if plan is None:
        return BenchSimulator(Bench(parameters, seed), identified)
    if plan.room == GUSTY:
        parameters = replace(parameters, room=replace(parameters.room, active=1.0))
    return BenchSimulator(Bench(parameters, seed, faults=FaultSchedule(plan.faults)), identified)


def supervisor(plan: Plan, values: NodeValues = DEFAULTS) -> Supervisor:
    """A supervisor that flies a plan."""
    return Supervisor(values.build(topics.SUPERVISOR, FlightLimits), plan)


def navigator(values: NodeValues = DEFAULTS) -> Navigator:
    """The navigation."""
    return Navigator(
        values.build(topics.NAVIGATION, NavigationParameters),
        values.build(topics.NAVIGATION, RigGeometry, "rig."),
        values.build(topics.NAVIGATION, FilterParameters, "filter."),
        values.build(topics.NAVIGATION, ImuAttitudeParameters, "imu_attitude."),
    )


def identifier(plan: Plan | None = None, values: NodeValues = DEFAULTS) -> Identifier:
    """The identification with the excitations of a plan."""
    return Identifier(
        plan.excitations if plan else (),
        values.build(topics.IDENTIFICATION, GuardParameters, "guard."),
        values.build(topics.IDENTIFICATION, EstimateParameters, "estimate."),
    )


def controllers(
    controller: ControllerFile, values: NodeValues = DEFAULTS, identified: bool = False
) -> list[Component]:
    """Navigation and the three controllers, which an identification may excite."""
    attitude = values.build(topics.ATTITUDE_CONTROLLER, AttitudeParameters)
    return [
        navigator(values),
        PositionController(values.build(topics.POSITION_CONTROLLER, PositionParameters), identified),
        AttitudeController(controller, attitude),
        MotorController(values.build(topics.MOTOR_CONTROLLER, MotorParameters)),
    ]
