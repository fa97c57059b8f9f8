"""The components of a flight, built from an order as the nodes build them from their parameters."""

from __future__ import annotations

from collections.abc import Sequence
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
from heli_control.motor_control import MotorController
from heli_control.motor_controller_file import MotorControllerFile, load_motor_controller
from heli_control.position_control import PositionController, PositionParameters
from heli_flight.parameter_file import NodeValues
from heli_flight.plan import GUSTY, Plan
from heli_flight.stages import FlightLimits
from heli_flight.supervisor import Supervisor
from heli_navigation.filter_parameters import FilterParameters
from heli_navigation.imu_attitude_parameters import ImuAttitudeParameters
from heli_navigation.navigator import NavigationParameters, Navigator

DEFAULTS = NodeValues()


def bench_simulator(seed: int, values: NodeValues = DEFAULTS, plan: Plan | None = None) -> BenchSimulator:
    """The simulated bench, in the room and with the faults of a plan."""
    parameters = values.build_groups(topics.BENCH_SIM, BenchParameters)
    if plan is None:
        return BenchSimulator(Bench(parameters, seed))
    if plan.room == GUSTY:
        parameters = replace(parameters, room=replace(parameters.room, active=1.0))
    return BenchSimulator(Bench(parameters, seed, faults=FaultSchedule(plan.faults)))


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


def controllers(
    controller: ControllerFile,
    values: NodeValues = DEFAULTS,
    later: Sequence[ControllerFile] = (),
    motor: MotorControllerFile | None = None,
) -> list[Component]:
    """Navigation and the three controllers.

    Args:
        controller: that flies first.
        values: parameters of the nodes.
        later: controllers that phases of the plan change to.
        motor: of the motor; the shipped one without.
    """
    attitude = values.build(topics.ATTITUDE_CONTROLLER, AttitudeParameters)
    return [
        navigator(values),
        PositionController(values.build(topics.POSITION_CONTROLLER, PositionParameters)),
        AttitudeController(controller, attitude, later),
        MotorController((motor or load_motor_controller("motor")).parameters),
    ]
